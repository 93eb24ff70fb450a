//! How fast the machine model is, beside tracing the same rays.
//!
//! ```text
//! cargo bench -p rayreel --bench machine                            all built-in scenes at 512x256, 2x2 samples, depth 4
//! cargo bench -p rayreel --bench machine -- --size 1024x512 teapot
//! cargo bench -p rayreel --bench machine -- --presets               every preset, not only sgrt-ti2
//! cargo bench -p rayreel --bench machine -- FILE.rtrace             a trace; no plain tracing beside it
//! ```
//!
//! All runs use one thread of the thread pool. The replay decodes tiles and checks paths in one thread and simulates in another.
//! So two figures are given: rays a second of wall clock, and of CPU time of all threads (Linux; whole hundredths of a second);
//! "a core" is the second one. "plain" is tracing and shading of all samples without recording. "policy" is the replay without a
//! machine. Energy is made of the counters after a run, and timed by itself.
//!
//! Speeds are the best of several rounds that take turns, so that ratios hold on a noisy machine. An adaptive policy is compared
//! by the rays that it traces, which are fewer.

mod common;

use std::path::Path;
use std::time::Instant;

use common::{cpu_seconds, open, size, trace};
use rayreel_formats::trace::Trace;
use rayreel_machine::config::{MachineConfig, NamedMachine, PRESETS};
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::stats::Stats;
use rayreel_machine::system::NoProbe;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::simulate::simulate;
use rayreel_replay::{NamedPolicy, Options, Replayer, Result};
use rayreel_tracer::{TraceSettings, Tracer, build, convert};

const ROUNDS: usize = 3;
const POLICIES: [&str; 2] = ["full", "adaptive"];

struct Arguments {
    size: (u32, u32),
    presets: bool,
    names: Vec<String>,
}

fn arguments() -> Arguments {
    let mut parsed = Arguments { size: (512, 256), presets: false, names: Vec::new() };
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        match argument.as_str() {
            "--bench" => {}
            "--presets" => parsed.presets = true,
            "--size" => parsed.size = size(&given.next().unwrap_or_default()),
            name => parsed.names.push(name.to_string()),
        }
    }
    if parsed.names.is_empty() {
        parsed.names = rayreel_scenes::builtin_names().iter().map(ToString::to_string).collect();
    }
    parsed
}

/// Best wall clock and CPU time of several rounds, seconds.
#[derive(Clone, Copy)]
struct Best {
    wall: f64,
    cpu: f64,
}

impl Best {
    const NONE: Self = Self { wall: f64::MAX, cpu: f64::MAX };

    fn round<T>(&mut self, run: impl FnOnce() -> T) -> T {
        let (cpu, wall) = (cpu_seconds(), Instant::now());
        let result = run();
        let wall = wall.elapsed().as_secs_f64();
        self.wall = self.wall.min(wall);
        let spent = cpu_seconds().zip(cpu).map_or(f64::NAN, |(end, start)| end - start);
        self.cpu = self.cpu.min(spent);
        result
    }
}

/// Traces the samples of a frame without recording anything.
type Plain<'a> = &'a dyn Fn();

/// One policy, with and without a machine.
struct Case<'a> {
    trace: &'a Trace,
    tree: &'a Topology,
    policy: &'a str,
    machine: &'a NamedMachine,
}

impl Case<'_> {
    fn replayer(&self, policy: &NamedPolicy, run: impl FnOnce(&mut Replayer<'_, Trace>) -> Result<()>) {
        let mut replayer = Replayer::new(self.trace, &policy.policy, Options::default()).expect("a replay");
        run(&mut replayer).expect("the machine runs the policy");
    }

    fn bench(&self, plain: Option<(Plain<'_>, &mut Best)>) -> Result<()> {
        let (frame, config) = (self.trace.meta().first_frame, &self.machine.config);
        let named = NamedPolicy::load(self.policy, &[])?;
        let (mut alone, mut whole) = (Best::NONE, Best::NONE);
        let (mut stats, mut rays) = (Stats::default(), 0);
        let mut plain = plain;
        for _ in 0..ROUNDS {
            if let Some((run, best)) = &mut plain {
                best.round(run);
            }
            alone.round(|| self.replayer(&named, |r| r.frame_with(frame, self.tree, |_| Ok(())).map(drop)));
            whole.round(|| {
                self.replayer(&named, |replayer| {
                    let machine = (self.machine.name.as_str(), config);
                    let run = simulate(replayer, frame, self.tree, machine, &mut NoProbe)?;
                    (stats, rays) = (run.stats, run.paths.rays);
                    Ok(())
                });
            });
        }
        let millions = |count: u64, seconds: f64| count as f64 / seconds / 1e6;
        println!(
            "  {:<9} {:<20} {rays:>9} {:>8.2} {:>8.2} {:>8.2} {:>9.2} {:>9.2} {:>9.1} {}",
            self.policy,
            self.machine.name,
            millions(rays, alone.wall),
            millions(rays, whole.wall),
            millions(rays, whole.cpu),
            millions(stats.cycles, whole.wall),
            millions(stats.cycles, whole.cpu),
            1e6 * energy_seconds(config, &stats),
            plain.map_or(String::new(), |(_, best)| {
                // Of the same rays: the full policy traces what plain tracing does.
                format!("{:>7.1} {:>7.1}", whole.wall / best.wall, whole.cpu / best.cpu)
            }),
        );
        Ok(())
    }
}

/// Energy is made of counters once, after the run. The counters are those of the statistics: without energy they
/// would be kept too.
fn energy_seconds(config: &MachineConfig, stats: &Stats) -> f64 {
    const TIMES: u32 = 1000;
    let start = Instant::now();
    for _ in 0..TIMES {
        std::hint::black_box(EnergyReport::new(config, std::hint::black_box(stats)));
    }
    start.elapsed().as_secs_f64() / f64::from(TIMES)
}

fn all(trace: &Trace, presets: bool, plain: Option<Plain<'_>>) {
    let tree = Topology::new(trace.bvh());
    let mut best = Best::NONE;
    for (name, _) in PRESETS.iter().filter(|(name, _)| presets || *name == "sgrt-ti2") {
        let machine = NamedMachine::load(name, &[]).expect("a preset");
        for policy in POLICIES {
            if policy != "full" && machine.config.srp.kernels.similarity.stages == 0 {
                continue;
            }
            let case = Case { trace, tree: &tree, policy, machine: &machine };
            // Plain tracing has no policy: it takes turns with the full one of the first machine.
            let turns = (*name == "sgrt-ti2" && policy == "full").then_some(plain).flatten();
            case.bench(turns.map(|run| (run, &mut best))).expect("a replay");
        }
    }
    if plain.is_some() {
        let rays = rays_of(trace);
        let speed = rays as f64 / best.wall / 1e6;
        println!("  plain tracing: {rays} rays, {speed:.2} Mrays/s of wall clock, which is CPU time too");
    }
}

fn rays_of(trace: &Trace) -> u64 {
    let policy = NamedPolicy::load("full", &[]).expect("a policy");
    let mut replayer = Replayer::new(trace, &policy.policy, Options::default()).expect("a replay");
    let tree = Topology::new(trace.bvh());
    replayer.frame_with(trace.meta().first_frame, &tree, |_| Ok(())).expect("a replay").1.rays
}

fn scene(name: &str, arguments: &Arguments) {
    let scene = rayreel_scenes::load(name).expect("a built-in scene");
    let built = build(&scene).expect("bvh");
    let (trace, _folder) = trace(name, arguments.size);
    let meta = trace.meta();
    let tracer = Tracer::new(&scene, &built, TraceSettings::default());
    let (columns, rows) = meta.grid();
    let camera = convert::camera(&scene.cameras[0], columns, rows);
    let plain = || {
        for tile in 0..meta.tile_count() {
            std::hint::black_box(tracer.colours(&camera, meta.tile_rect(tile)));
        }
    };
    println!("{name}");
    all(&trace, arguments.presets, Some(&plain));
}

fn main() {
    let arguments = arguments();
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("one thread");
    println!(
        "Mrays/s: policy alone; with the machine by wall clock, by CPU time. Mcycles/s likewise.\n\
         energy: microseconds to make energy of the counters, once a run. slower: time over that of plain tracing."
    );
    println!(
        "  {:<9} {:<20} {:>9} {:>8} {:>8} {:>8} {:>9} {:>9} {:>9} {:>7} {:>7}",
        "policy", "machine", "rays", "alone", "rays/s", "a core", "cycles/s", "a core", "energy", "slower", "a core"
    );
    for name in &arguments.names {
        if name.ends_with(".rtrace") {
            println!("{name}");
            all(&open(Path::new(name)), arguments.presets, None);
        } else {
            scene(name, &arguments);
        }
    }
}
