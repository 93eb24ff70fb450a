//! How near a sampled simulation comes to that of every cycle, and what it costs.
//!
//! ```text
//! cargo bench -p rayreel --bench detail                              three scenes at 512x256, three policies, sgrt-ti2, 10 %
//! cargo bench -p rayreel --bench detail -- --size 1024x512 --share 0.05 teapot FILE.rtrace
//! cargo bench -p rayreel --bench detail -- --machines sgrt-ti2,raycore --policies full,multirate
//! cargo bench -p rayreel --bench detail -- --kept FOLDER teapot    what `full` gives is kept there, and taken from there
//! ```
//!
//! Errors are those of an estimate against `--detail full`, in percent, each with half its 95 % interval; a `!` marks a value
//! outside of its interval. "perf/W ratio" is that of the policy to the first policy, on the same windows. "CPU" is the CPU time
//! of the full simulation over that of the sampled one (Linux: hundredths of a second), decoding and the policy included. At the
//! end stands how many of all intervals hold their value.

mod common;

use std::fmt;
use std::path::{Path, PathBuf};

use common::{cpu_seconds, size, trace};
use rayreel_formats::trace::Trace;
use rayreel_machine::Stats;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::system::NoProbe;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::detail::{Detail, Floors, half_width, replicates_of_ratio};
use rayreel_replay::error::RequestError;
use rayreel_replay::sequence::{FrameLoop, Simulator};
use rayreel_replay::simulate::MachineRun;
use rayreel_replay::{NamedPolicy, Options, ReplayError, Stop};
use rayreel_study::point::version::MODEL_VERSION;
use serde::{Deserialize, Serialize};

struct Arguments {
    size: (u32, u32),
    detail: Detail,
    machines: Vec<String>,
    policies: Vec<String>,
    names: Vec<String>,
    kept: Option<PathBuf>,
}

fn arguments() -> Arguments {
    let list = |text: String| text.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut parsed = Arguments {
        size: (512, 256),
        detail: "0.1".parse().expect("a share"),
        machines: list("sgrt-ti2".into()),
        policies: list("full,paper-ss,multirate".into()),
        names: Vec::new(),
        kept: None,
    };
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        let mut value = || given.next().unwrap_or_else(|| panic!("{argument} takes a value"));
        match argument.as_str() {
            "--bench" => {}
            "--size" => parsed.size = size(&value()),
            "--share" => parsed.detail = value().parse().expect("--share takes a detail"),
            "--machines" => parsed.machines = list(value()),
            "--policies" => parsed.policies = list(value()),
            "--kept" => parsed.kept = Some(value().into()),
            name => parsed.names.push(name.to_string()),
        }
    }
    if let Some(folder) = &parsed.kept {
        std::fs::create_dir_all(folder).unwrap_or_else(|error| panic!("--kept {}: {error}", folder.display()));
    }
    if parsed.names.is_empty() {
        parsed.names = ["cornell", "teapot", "chess"].map(str::to_owned).to_vec();
    }
    parsed
}

/// A run, with the CPU seconds that it took; nothing if the machine lacks a kernel of the policy.
fn run(
    (trace, tree): (&Trace, &Topology),
    policy: &str,
    machine: &NamedMachine,
    detail: Detail,
) -> Option<(MachineRun, f64)> {
    let policy = NamedPolicy::load(policy, &[]).expect("a policy");
    let begin = cpu_seconds();
    let options = Options { reference: false, perception: false, ..Options::default() };
    let mut frames = FrameLoop::new(trace, &policy.policy, options, &Stop::never()).expect("a replay");
    let simulator = Simulator { machine, tree, detail };
    let result = match frames.step(trace.meta().first_frame, Some(simulator), &mut NoProbe) {
        Err(ReplayError::Request(RequestError::MissingKernel { .. })) => return None,
        result => result.expect("a simulation"),
    };
    let seconds = cpu_seconds().zip(begin).map_or(f64::NAN, |(end, begin)| end - begin);
    Some((result.run.expect("a machine"), seconds))
}

/// What a simulation of every cycle gave.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Truth {
    cycles: f64,
    energy_fj: f64,
    dram_bytes: f64,
    cpu_seconds: f64,
}

/// The simulation of every cycle. It is kept in `folder`, under what it depends on, and not made again.
fn truth(
    folder: Option<&Path>,
    (trace, tree): (&Trace, &Topology),
    policy: &str,
    machine: &NamedMachine,
) -> Option<Truth> {
    let fingerprint: String = trace.fingerprint().expect("a fingerprint").to_hex().chars().take(16).collect();
    let file =
        folder.map(|folder| folder.join(format!("{fingerprint}-{}-{policy}-{MODEL_VERSION}.json", machine.name)));
    if let Some(text) = file.as_ref().and_then(|file| std::fs::read_to_string(file).ok()) {
        return Some(serde_json::from_str(&text).expect("a kept result"));
    }
    let (run, cpu_seconds) = run((trace, tree), policy, machine, Detail::Full)?;
    let [cycles, energy_fj, dram_bytes] = figures(&run.stats, &run.energy);
    let truth = Truth { cycles, energy_fj, dram_bytes, cpu_seconds };
    if let Some(file) = file {
        std::fs::write(file, serde_json::to_string(&truth).expect("numbers")).expect("a folder to write to");
    }
    Some(truth)
}

/// Cycles, energy and traffic.
fn figures(stats: &Stats, energy: &EnergyReport) -> [f64; 3] {
    [stats.cycles as f64, energy.gpu_fj() as f64, stats.memory.traffic.total() as f64]
}

/// A figure: the true value, the estimate, those of the replicates.
struct Figure {
    truth: f64,
    value: f64,
    replicates: Vec<f64>,
    freedom: u32,
    floor: f64,
}

impl Figure {
    fn of(truth: &Truth, run: &MachineRun, floor: fn(&Floors) -> f64, of: impl Fn([f64; 3]) -> f64) -> Self {
        let estimate = run.estimate.as_ref().expect("an estimate");
        Self {
            truth: of([truth.cycles, truth.energy_fj, truth.dram_bytes]),
            value: of(figures(&run.stats, &run.energy)),
            replicates: estimate.replicates.iter().map(|r| of(figures(&r.stats, &r.energy))).collect(),
            freedom: estimate.freedom,
            floor: floor(&estimate.floors()),
        }
    }

    /// What is the quotient of this figure and that of another policy.
    fn over(&self, other: &Self) -> Self {
        let replicates = replicates_of_ratio((self.value, &self.replicates), (other.value, &other.replicates), false);
        Self {
            truth: self.truth / other.truth,
            value: self.value / other.value,
            replicates,
            freedom: self.freedom.min(other.freedom),
            floor: self.floor.max(other.floor),
        }
    }
}

/// How many intervals hold, and how large errors are.
#[derive(Default)]
struct Held {
    all: usize,
    held: usize,
    largest: f64,
    squares: f64,
}

impl Held {
    /// The error of a figure with its interval, percent.
    fn show(&mut self, figure: &Figure) -> String {
        let error = 100.0 * (figure.value / figure.truth - 1.0);
        let Figure { value, replicates, freedom, floor, .. } = figure;
        let width = 100.0 * half_width(*value, replicates, *freedom, *floor) / value;
        let holds = error.abs() <= width;
        self.all += 1;
        self.held += usize::from(holds);
        self.largest = self.largest.max(error.abs());
        self.squares += error * error;
        format!("{error:.2} ± {width:.2}{}", if holds { "" } else { " !" })
    }
}

impl fmt::Display for Held {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { all, held, largest, squares } = self;
        let rms = (squares / (*all).max(1) as f64).sqrt();
        write!(f, "{held} of {all} intervals hold their value; errors {rms:.2} % rms, at most {largest:.2} %")
    }
}

/// What the table has errors of. Energy of a frame and frames a joule are one figure; so are their errors, but for the sign.
const ERRORS: [&str; 4] = ["cycles", "energy", "DRAM bytes", "perf/W ratio"];

fn table(name: &str, trace: &Trace, arguments: &Arguments, held: &mut [Held; ERRORS.len()], times: &mut Vec<f64>) {
    let tree = Topology::new(trace.bvh());
    for machine in &arguments.machines {
        let machine = NamedMachine::load(machine, &[]).expect("a machine");
        let mut first: Option<Figure> = None;
        for policy in &arguments.policies {
            let traced = (trace, &tree);
            let truth = truth(arguments.kept.as_deref(), traced, policy, &machine);
            let sampled = truth.and_then(|truth| Some((truth, run(traced, policy, &machine, arguments.detail)?)));
            let Some((truth, (sampled, seconds))) = sampled else { continue };
            let floors: [fn(&Floors) -> f64; 3] =
                [|floors| floors.alone, |floors| floors.with_memory, |floors| floors.with_memory];
            let figures =
                [0, 1, 2].map(|figure| Figure::of(&truth, &sampled, floors[figure], |figures| figures[figure]));
            let mut errors = [0, 1, 2].map(|figure| held[figure].show(&figures[figure])).to_vec();
            let per_watt = Figure::of(&truth, &sampled, |floors| floors.with_memory, |[_, energy, _]| 1.0 / energy);
            errors.push(first.as_ref().map(|first| held[3].show(&per_watt.over(first))).unwrap_or_default());
            let estimate = sampled.estimate.as_ref().expect("an estimate");
            times.push(truth.cpu_seconds / seconds);
            println!(
                "| {name} | {} | {policy} | {:.0} | {} | {:.1} | {} | {:.1} |",
                machine.name,
                truth.cycles,
                estimate.windows,
                100.0 * estimate.fraction(),
                errors.join(" | "),
                truth.cpu_seconds / seconds,
            );
            first = first.or(Some(per_watt));
        }
    }
}

fn main() {
    let arguments = arguments();
    println!(
        "| scene | machine | policy | cycles | windows | tiles, % | {} | CPU |\n|{}",
        ERRORS.join(", % | ") + ", %",
        "---|".repeat(7 + ERRORS.len()),
    );
    let mut held = <[Held; ERRORS.len()]>::default();
    let mut times = Vec::new();
    for name in &arguments.names {
        let (trace, _folder) = trace(name, arguments.size);
        let name = Path::new(name).file_stem().map_or(name.into(), |stem| stem.to_string_lossy());
        table(&name, &trace, &arguments, &mut held, &mut times);
    }
    println!();
    for (what, held) in ERRORS.into_iter().zip(held) {
        println!("{what}: {held}");
    }
    let mean = (times.iter().map(|ratio| ratio.ln()).sum::<f64>() / times.len() as f64).exp();
    let (least, most) = times.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &ratio| (a.min(ratio), b.max(ratio)));
    println!("CPU time of full over that of the sample: {least:.1} to {most:.1}, geometric mean {mean:.1}");
}
