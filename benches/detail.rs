//! How near a sampled simulation comes to that of every cycle, and what it costs.
//!
//! ```text
//! cargo bench -p rayreel --bench detail                              three scenes at 512x256, three policies, sgrt-ti2, 10 %
//! cargo bench -p rayreel --bench detail -- --size 1024x512 --share 0.05 teapot FILE.rtrace
//! cargo bench -p rayreel --bench detail -- --machines sgrt-ti2,raycore --policies full,multirate
//! ```
//!
//! Errors are those of an estimate against `--detail full`, in percent, each with half its 95 % interval; a `!` marks a value
//! outside of its interval. "perf/W ratio" is that of the policy to the first policy, on the same windows. "CPU" is the CPU time
//! of the full simulation over that of the sampled one (Linux: hundredths of a second), decoding and the policy included. At the
//! end stands how many of all intervals hold their value.

mod common;

use common::{cpu_seconds, size, trace};
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::system::NoProbe;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::detail::{Detail, half_width};
use rayreel_replay::sequence::{FrameLoop, Simulator};
use rayreel_replay::simulate::MachineRun;
use rayreel_replay::{NamedPolicy, Options, Stop};

struct Arguments {
    size: (u32, u32),
    detail: Detail,
    machines: Vec<String>,
    policies: Vec<String>,
    names: Vec<String>,
}

fn arguments() -> Arguments {
    let list = |text: String| text.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut parsed = Arguments {
        size: (512, 256),
        detail: "0.1".parse().expect("a share"),
        machines: list("sgrt-ti2".into()),
        policies: list("full,paper-ss,multirate".into()),
        names: Vec::new(),
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
            name => parsed.names.push(name.to_string()),
        }
    }
    if parsed.names.is_empty() {
        parsed.names = ["cornell", "teapot", "chess"].map(str::to_owned).to_vec();
    }
    parsed
}

/// A run, with the CPU seconds that it took.
fn run(trace: &Trace, tree: &Topology, policy: &str, machine: &NamedMachine, detail: Detail) -> (MachineRun, f64) {
    let policy = NamedPolicy::load(policy, &[]).expect("a policy");
    let begin = cpu_seconds();
    let options = Options { reference: false, perception: false };
    let mut frames = FrameLoop::new(trace, &policy.policy, options, &Stop::never()).expect("a replay");
    let simulator = Simulator { machine, tree, detail };
    let result = frames.step(trace.meta().first_frame, Some(simulator), &mut NoProbe).expect("a simulation");
    let seconds = cpu_seconds().zip(begin).map_or(f64::NAN, |(end, begin)| end - begin);
    (result.run.expect("a machine"), seconds)
}

/// Values of a figure: the true one, the estimate, those of the replicates.
struct Figure {
    truth: f64,
    value: f64,
    replicates: Vec<f64>,
    freedom: u32,
}

impl Figure {
    fn of(full: &MachineRun, run: &MachineRun, of: impl Fn(f64, f64) -> f64) -> Self {
        let estimate = run.estimate.as_ref().expect("an estimate");
        let replicates = estimate.replicates.iter().map(|r| of(r.stats.cycles as f64, r.energy.gpu_fj() as f64));
        let value = |run: &MachineRun| of(run.stats.cycles as f64, run.energy.gpu_fj() as f64);
        Self { truth: value(full), value: value(run), replicates: replicates.collect(), freedom: estimate.freedom }
    }

    /// What is the quotient of this figure and another one.
    fn over(&self, other: &Self) -> Self {
        let replicates = self.replicates.iter().zip(&other.replicates).map(|(a, b)| a / b).collect();
        let freedom = self.freedom.min(other.freedom);
        Self { truth: self.truth / other.truth, value: self.value / other.value, replicates, freedom }
    }
}

/// How many intervals hold.
#[derive(Default)]
struct Held {
    all: usize,
    held: usize,
    largest: f64,
}

impl Held {
    /// The error of a figure with its interval, percent.
    fn show(&mut self, figure: &Figure) -> String {
        let error = 100.0 * (figure.value / figure.truth - 1.0);
        let width = 100.0 * half_width(figure.value, &figure.replicates, figure.freedom) / figure.value;
        let holds = error.abs() <= width;
        self.all += 1;
        self.held += usize::from(holds);
        self.largest = self.largest.max(error.abs());
        format!("{error:>7.2} ±{width:>5.2}{}", if holds { ' ' } else { '!' })
    }
}

fn table(trace: &Trace, arguments: &Arguments, held: &mut [Held; 3]) {
    let tree = Topology::new(trace.bvh());
    for name in &arguments.machines {
        let machine = NamedMachine::load(name, &[]).expect("a machine");
        let mut first: Option<Figure> = None;
        for policy in &arguments.policies {
            let (full, full_seconds) = run(trace, &tree, policy, &machine, Detail::Full);
            let (sampled, seconds) = run(trace, &tree, policy, &machine, arguments.detail);
            let cycles = Figure::of(&full, &sampled, |cycles, _| cycles);
            let energy = Figure::of(&full, &sampled, |_, energy| energy);
            let per_watt = Figure::of(&full, &sampled, |_, energy| 1.0 / energy);
            let ratio = first.as_ref().map(|first| held[2].show(&per_watt.over(first)));
            let estimate = sampled.estimate.as_ref().expect("an estimate");
            println!(
                "  {name:<20} {policy:<10} {:>10} {:>8} {:>6.1} {} {} {:>16} {:>6.1}",
                full.stats.cycles,
                estimate.windows,
                100.0 * estimate.fraction(),
                held[0].show(&cycles),
                held[1].show(&energy),
                ratio.unwrap_or_default(),
                full_seconds / seconds,
            );
            first = first.or(Some(per_watt));
        }
    }
}

fn main() {
    let arguments = arguments();
    println!(
        "  {:<20} {:<10} {:>10} {:>8} {:>6} {:>15} {:>15} {:>16} {:>6}",
        "machine", "policy", "cycles", "windows", "%", "cycles, %", "energy, %", "perf/W ratio, %", "CPU"
    );
    let mut held = <[Held; 3]>::default();
    for name in &arguments.names {
        println!("{name}");
        let (trace, _folder) = trace(name, arguments.size);
        table(&trace, &arguments, &mut held);
    }
    for (what, Held { all, held, largest }) in ["cycles", "energy", "perf/W ratio"].into_iter().zip(held) {
        println!("{what}: {held} of {all} intervals hold their value; largest error {largest:.2} %");
    }
}
