//! A sampling policy of another package: `cargo run --release --bin policy`, in this folder.
//!
//! It traces a cross of each 3 x 3 samples, and the rest only where the arms of the cross met different objects. What it may see is its
//! `TileView`: asking for a sample that it has not traced panics.

use rayreel_formats::{Limits, Meta, Trace};
use rayreel_machine::{NamedMachine, system::NoProbe};
use rayreel_replay::policy::{SamplePolicy, SampleState, Sampler, TileView};
use rayreel_replay::{NamedPolicy, Options, PathSource, Replayer, Result, simulate::simulate};

/// The policy: a description, from which each replay makes a sampler of its own.
struct Cross;

impl SamplePolicy for Cross {
    fn name(&self) -> String {
        "cross".into()
    }

    fn text(&self) -> String {
        "cross, version 1".into()
    }

    fn sampler(&self, _: &Meta) -> Result<Box<dyn Sampler>> {
        Ok(Box::new(Self))
    }
}

impl Sampler for Cross {
    fn begin_tile(&self, view: &mut TileView) {
        let rect = view.rect();
        let middle = |from: u32, at: u32, len: u32| (from + (at - from) / 3 * 3 + 1).min(from + len - 1);
        let centre = |x: u32, y: u32| (middle(rect.x, x, rect.width), middle(rect.y, y, rect.height));
        for (x, y) in view.samples().filter(|&(x, y)| centre(x, y).0 == x || centre(x, y).1 == y) {
            view.trace(x, y, SampleState::Reference, 0);
        }
        for (x, y) in view.samples() {
            let (across, down) = centre(x, y);
            if across == x || down == y {
                continue;
            }
            // Beside the arms: the nearest sample of each.
            let (near, far) = (view.tree(across, y).to_vec(), view.tree(x, down).to_vec());
            let object = |tree: &[rayreel_replay::policy::tree::Node]| tree[0].surface.map(|surface| surface.object);
            if object(&near) == object(&far) {
                view.interpolate(x, y, &rayreel_replay::policy::between(&near, &far, 0.5), 1);
            } else {
                view.trace(x, y, SampleState::Traced, 1);
            }
        }
    }
}

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let trace = Trace::open("../../traces/v1_0_teapot.rtrace".as_ref(), Limits::default())?;
    let machine = NamedMachine::load("sgrt-ti2", &[])?;
    let (tree, frame) = (trace.topology(), trace.meta().first_frame);
    for policy in [&NamedPolicy::load("full", &[])? as &dyn SamplePolicy, &NamedPolicy::load("adaptive", &[])?, &Cross]
    {
        let mut replayer = Replayer::new(&trace, policy, Options::default())?;
        let run = simulate(&mut replayer, frame, &tree, (&machine.name, &machine.config), &mut NoProbe)?;
        let (rays, flip) = (run.stats.rays(), run.replay.stats.quality.and_then(|quality| quality.flip));
        println!(
            "{:9} {rays:6} rays {:7} cycles, FLIP {:.4}",
            policy.name(),
            run.stats.cycles,
            flip.unwrap_or_default()
        );
    }
    Ok(())
}
