//! A frame of a trace under a policy on a machine: `cargo run --release --example simulate [TRACE [POLICY [MACHINE]]]`.

use rayreel_formats::{Limits, Trace};
use rayreel_machine::{config::NamedMachine, system::NoProbe};
use rayreel_replay::{NamedPolicy, Options, PathSource, Replayer, simulate::simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/v1_0_teapot.rtrace");
    let given: Vec<String> = std::env::args().skip(1).collect();
    let argument = |i: usize, default: &str| given.get(i).cloned().unwrap_or_else(|| default.to_owned());
    let trace = Trace::open(argument(0, golden).as_ref(), Limits::default())?;
    let policy = NamedPolicy::load(&argument(1, "multirate"), &[])?;
    let machine = NamedMachine::load(&argument(2, "sgrt-ti2"), &[])?;

    let mut replayer = Replayer::new(&trace, &policy, Options::default())?;
    let named = (machine.name.as_str(), &machine.config);
    let first = trace.meta().first_frame;
    let frame = simulate(&mut replayer, first, &trace.topology(), named, &mut NoProbe)?;
    let counts = frame.replay.stats.counts;
    println!(
        "{} on {}: {} of {} rays",
        policy.name,
        machine.name,
        counts.rays_traced.total(),
        counts.rays_full.total()
    );
    println!("{} cycles, {:.3} mJ", frame.stats.cycles, frame.energy.gpu_fj() as f64 * 1e-12);
    Ok(())
}
