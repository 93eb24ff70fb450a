//! How fast a trace is read: its columns, and what a replay makes of them without a machine.
//!
//! ```text
//! cargo bench -p rayreel --bench decode                            chess, teapot and lab at 512x256, 2x2 samples, depth 4
//! cargo bench -p rayreel --bench decode -- --size 1024x512 car
//! cargo bench -p rayreel --bench decode -- FILE.rtrace
//! ```
//!
//! Columns are decoded in one thread. A column needs those that it is predicted from: its time is that of all of them less the
//! time of those. Speeds are by CPU time, the best of several rounds that take turns, so that ratios hold on a noisy machine. A ray
//! is one that was recorded, whatever a policy makes of it; under several policies it counts for each.

mod common;

use common::{cpu_seconds, size, trace};
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{Scratch, Trace};
use rayreel_machine::work::recorded::PathRecorder;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::{NamedPolicy, Options, Replayer, Replayers, SamplePolicy};

const ROUNDS: usize = 5;

/// CPU time of this thread so far, seconds (Linux).
fn thread_seconds() -> f64 {
    let times = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    times.split_whitespace().next().and_then(|text| text.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}

/// CPU time of all threads of this process so far, seconds.
fn process_seconds() -> f64 {
    cpu_seconds().expect("Linux")
}

/// The least time of several rounds, seconds.
#[derive(Clone, Copy)]
struct Best(f64);

impl Best {
    fn round<T>(&mut self, seconds: fn() -> f64, run: impl FnOnce() -> T) -> T {
        let start = seconds();
        let result = run();
        self.0 = self.0.min(seconds() - start);
        result
    }
}

struct Arguments {
    size: (u32, u32),
    names: Vec<String>,
}

fn arguments() -> Arguments {
    let mut parsed = Arguments { size: (512, 256), names: Vec::new() };
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        match argument.as_str() {
            "--bench" => {}
            "--size" => parsed.size = size(&given.next().unwrap_or_default()),
            name => parsed.names.push(name.to_string()),
        }
    }
    if parsed.names.is_empty() {
        parsed.names = ["chess", "teapot", "lab"].map(String::from).to_vec();
    }
    parsed
}

/// What is decoded together, and what of that is not the column itself: places in this list.
const COLUMNS: [(&str, &[Column], Option<usize>); 4] = [
    ("tree", &[Column::Tree], None),
    ("hits", &[Column::Tree, Column::Hits], Some(0)),
    ("radiance", &[Column::Tree, Column::Hits, Column::Radiance], Some(1)),
    ("paths", &[Column::Tree, Column::Paths], Some(0)),
];

fn columns(trace: &Trace, frame: u32) -> u64 {
    let (mut scratch, tiles) = (Scratch::default(), 0..trace.meta().tile_count());
    let mut times = [Best(f64::MAX); COLUMNS.len()];
    let mut rays = 0;
    for _ in 0..ROUNDS {
        for ((_, columns, _), best) in COLUMNS.iter().zip(&mut times) {
            rays = best.round(thread_seconds, || {
                let tile = |index| trace.tile_with(frame, index, columns, &mut scratch).expect("a whole trace");
                tiles.clone().map(tile).map(|tile| tile.tree.ray_count()).sum()
            });
        }
    }
    println!("  {:<28} {:>9} {:>9} {:>9} {:>9}", "column", "Mrays/s", "MB/s file", "MB/s raw", "ns a ray");
    for (i, (name, columns, without)) in COLUMNS.iter().enumerate() {
        let seconds = times[i].0 - without.map_or(0.0, |other| times[other].0);
        let id = *columns.last().expect("a column") as u8;
        let totals = trace.column_totals().iter().find(|totals| totals.id == id).expect("all columns are there");
        let frames = f64::from(trace.meta().frames);
        let speed = |bytes: u64| bytes as f64 / frames / seconds / 1e6;
        let rays = rays as f64;
        println!(
            "  {name:<28} {:>9.2} {:>9.1} {:>9.1} {:>9.1}",
            rays / seconds / 1e6,
            speed(totals.packed_bytes),
            speed(totals.raw_bytes),
            seconds / rays * 1e9
        );
    }
    rays
}

/// Paths as operations, straight from the decoder.
fn operations(trace: &Trace, frame: u32, rays: u64) {
    let (mut scratch, mut best) = (Scratch::default(), Best(f64::MAX));
    let packed = |index| trace.packed_tile(frame, index).expect("a whole trace");
    let tiles: Vec<_> = (0..trace.meta().tile_count()).map(packed).collect();
    let (mut ops, mut paths) = (0, 0);
    for _ in 0..ROUNDS {
        (ops, paths) = (0, 0);
        best.round(thread_seconds, || {
            for (tile, packed) in &tiles {
                let mut recorder = PathRecorder::default();
                let shared = trace.paths_to(tile, packed, &mut scratch, &mut recorder).expect("a whole trace");
                let made = recorder.finish(shared);
                paths += made.paths();
                ops += (0..made.paths() as u32).map(|path| made.path(path).1.len()).sum::<usize>();
            }
        });
    }
    let (share, mean) = (100.0 * paths as f64 / rays as f64, ops as f64 / paths.max(1) as f64);
    println!(
        "  {:<28} {:>9.2} {:>29.1}   {share:.0} paths for 100 rays, of {mean:.1} operations",
        "paths as operations",
        rays as f64 / best.0 / 1e6,
        best.0 / rays as f64 * 1e9
    );
}

/// Replays a frame under each of some policies, and under several at a time.
fn replays(trace: &Trace, frame: u32, rays: u64) {
    let load = |name: &&str| NamedPolicy::load(name, &[]).expect("a preset");
    let all: Vec<NamedPolicy> = ["full", "multirate", "paper-ss"].iter().map(load).collect();
    let tree = Topology::new(trace.bvh());
    let [plain, seen] =
        [false, true].map(|perception| Options { reference: perception, perception, ..Options::default() });
    let mut times = vec![[Best(f64::MAX); 3]; all.len()];
    let pairs = [[0, 1], [2, 1]];
    let mut together = [[Best(f64::MAX); 2]; 2];
    for _ in 0..ROUNDS {
        for (policy, times) in all.iter().zip(&mut times) {
            let replayer = |options| Replayer::new(trace, &policy.policy, options).expect("a replay");
            times[0].round(process_seconds, || replayer(plain).frame(frame).expect("a replay"));
            times[1].round(process_seconds, || replayer(seen).frame(frame).expect("a replay"));
            times[2].round(process_seconds, || replayer(plain).frame_with(frame, &tree, |_| Ok(())).expect("work"));
        }
        for (pair, times) in pairs.iter().zip(&mut together) {
            let policies = pair.map(|i| &all[i] as &dyn SamplePolicy);
            for (options, best) in [plain, seen].into_iter().zip(times) {
                let run = || Replayers::new(trace, &policies, options).expect("policies").frame(frame).expect("frames");
                best.round(process_seconds, run);
            }
        }
    }
    let speed = |best: Best, policies: u64| (rays * policies) as f64 / best.0 / 1e6;
    println!("  {:<28} {:>9} {:>9} {:>9}   Mrays/s of CPU time", "policy", "pictures", "compared", "work");
    for (policy, times) in all.iter().zip(&times) {
        let [pictures, compared, work] = times.map(|best| speed(best, 1));
        println!("  {:<28} {pictures:>9.2} {compared:>9.2} {work:>9.2}", policy.name);
    }
    for (pair, both) in pairs.iter().zip(&together) {
        let [pictures, compared] = both.map(|best| speed(best, 2));
        let apart = |i: usize| pair.iter().map(|&policy| times[policy][i].0).sum::<f64>();
        let names = pair.map(|i| all[i].name.as_str()).join(" + ");
        let gain = [0, 1].map(|i| apart(i) / both[i].0);
        println!("  {names:<28} {pictures:>9.2} {compared:>9.2}   {:.2} and {:.2} times one by one", gain[0], gain[1]);
    }
}

fn bench(trace: &Trace) {
    let frame = trace.meta().first_frame;
    let rays = columns(trace, frame);
    operations(trace, frame, rays);
    replays(trace, frame, rays);
}

fn main() {
    let arguments = arguments();
    for name in &arguments.names {
        println!("{name}, {} threads", rayon::current_num_threads());
        let (trace, _folder) = trace(name, arguments.size);
        bench(&trace);
    }
}
