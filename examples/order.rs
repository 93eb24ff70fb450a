//! Does it matter in which order the rays of a round start? A frame on a machine, every cycle of it, once for each order:
//!
//! ```console
//! $ cargo run --release --example order -- chess.rtrace [POLICY [MACHINE]]
//! ```
//!
//! The presets start them row by row. A work list is what a policy hands to a machine, so whatever lies between the two can change it.

use rayreel_formats::{Limits, Trace};
use rayreel_machine::config::NamedMachine;
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::system::{NoProbe, System};
use rayreel_machine::work::{RayWork, TileWork};
use rayreel_replay::simulate::frame_shape;
use rayreel_replay::{NamedPolicy, Options, PathSource, Replayer};

/// Rays start in the order of their keys, and row by row where these are the same.
type Key = fn(&RayWork) -> u64;

const ORDERS: [(&str, Key); 5] = [
    ("row by row", |_| 0),
    ("column by column", |ray| u64::from(ray.x)),
    ("along a Morton curve", |ray| morton(ray.x, ray.y)),
    ("by the triangle that they hit", |ray| u64::from(ray.triangle)), // which no machine knows beforehand
    ("in no order", |ray| morton(ray.x, ray.y).wrapping_mul(0x9E37_79B9_7F4A_7C15)),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/v1_0_teapot.rtrace");
    let given: Vec<String> = std::env::args().skip(1).collect();
    let argument = |i: usize, default: &str| given.get(i).cloned().unwrap_or_else(|| default.to_owned());
    let trace = Trace::open(argument(0, golden).as_ref(), Limits::default())?;
    let policy = NamedPolicy::load(&argument(1, "multirate"), &[])?;
    let machine = NamedMachine::load(&argument(2, "sgrt-ti2"), &[])?;

    let (tree, frame) = (trace.topology(), trace.meta().first_frame);
    println!("| order | cycles | GPU, mJ | lines from DRAM |\n|---|---|---|---|");
    for (name, key) in ORDERS {
        let mut replayer = Replayer::new(&trace, &policy, Options::default())?;
        let shape = frame_shape(trace.meta(), &machine.config, replayer.reads());
        let mut system = System::new(&machine.config, &tree, shape);
        replayer.frame_with(frame, &tree, |mut work| {
            sort(&mut work, key);
            Ok(system.feed(work, &mut NoProbe)?)
        })?;
        let (stats, _) = system.finish(&mut NoProbe)?;
        let energy = EnergyReport::new(&machine.config, &stats).gpu_fj() as f64 * 1e-12;
        println!("| {name} | {} | {energy:.3} | {} |", stats.cycles, stats.memory.dram().read_lines);
    }
    Ok(())
}

/// Puts what the rounds of a tile start in the order of `key`.
fn sort(work: &mut TileWork, key: Key) {
    let TileWork { rounds, rays, .. } = work;
    rounds.iter_mut().for_each(|round| round.starts.sort_by_key(|&ray| key(&rays[ray as usize])));
}

/// The bits of both in turns.
fn morton(x: u32, y: u32) -> u64 {
    (0..32).map(|bit| (u64::from(x) >> bit & 1) << (2 * bit) | (u64::from(y) >> bit & 1) << (2 * bit + 1)).sum()
}
