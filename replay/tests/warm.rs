//! Caches that keep from frame to frame what they hold.

use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::srp::FrameShape;
use rayreel_machine::stats::Stats;
use rayreel_machine::system::{NoProbe, System};
use rayreel_machine::work::PolicyReads;
use rayreel_replay::sequence::{FrameLoop, Simulator};
use rayreel_replay::{Detail, NamedPolicy, Options, PathSource, ReplayError, Replayer, Stop, TileSource};

/// Two frames of the teapot, 30 and 31.
fn trace() -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/v1_0_teapot.rtrace");
    Trace::open(&path, Limits::default()).unwrap()
}

/// A machine whose L2 holds the whole scene.
fn machine(warm: bool) -> NamedMachine {
    NamedMachine::load("sgrt-ti2", &[format!("gpu.warm_caches={warm}"), "l2.size=16MiB".into()]).unwrap()
}

/// What frames `frames` count on a machine.
fn stats(trace: &Trace, frames: &[u32], warm: bool, detail: Detail) -> Vec<Stats> {
    let (policy, machine, tree) = (NamedPolicy::load("adaptive", &[]).unwrap(), machine(warm), trace.topology());
    let simulator = Simulator { machine: &machine, tree: &tree, detail };
    let mut frame_loop = FrameLoop::new(trace, &policy.policy, Options::default(), &Stop::never()).unwrap();
    let mut found = Vec::new();
    let sink = |frame: rayreel_replay::sequence::FrameResult| {
        found.extend(frame.run.map(|run| run.stats));
        Ok::<_, ReplayError>(())
    };
    frame_loop.run(frames.iter().copied(), Some(simulator), &mut NoProbe, sink).unwrap();
    found
}

fn l2_misses(stats: &Stats) -> u64 {
    stats.memory.l2.misses
}

#[test]
fn a_frame_begins_with_what_the_one_before_left() {
    let trace = trace();
    let cold = stats(&trace, &[30, 31], false, Detail::Full);
    let warm = stats(&trace, &[30, 31], true, Detail::Full);
    assert_eq!(warm[0], cold[0], "before the first frame there is none");
    assert!(l2_misses(&warm[1]) * 4 < l2_misses(&cold[1]), "{} and {}", l2_misses(&warm[1]), l2_misses(&cold[1]));
    assert!(warm[1].cycles < cold[1].cycles);
    assert_eq!(stats(&trace, &[31], true, Detail::Full), cold[1..], "a frame whose predecessor was left out is cold");

    // The same by hand: two machines, one after the other.
    let (policy, machine, tree) = (NamedPolicy::load("adaptive", &[]).unwrap(), machine(true), trace.topology());
    let meta = TileSource::meta(&trace);
    let pixels = u64::from(meta.tile.div_ceil(meta.samples)).pow(2);
    let pixel_bytes = machine.config.layout.pixel_bytes;
    let shape = FrameShape {
        width_pixels: meta.width,
        samples_per_axis: meta.samples,
        pixel_bytes,
        tile_bytes: (pixels * u64::from(pixel_bytes)).next_multiple_of(machine.config.l2.line_bytes.into()),
        tile_samples: meta.tile * meta.tile,
        policy: PolicyReads::PAPER,
    };
    let mut replayer = Replayer::new(&trace, &policy, Options::default()).unwrap();
    let mut caches = None;
    for (frame, expected) in [30, 31].into_iter().zip(&warm) {
        let mut system = System::new(&machine.config, &tree, shape);
        caches.iter().for_each(|caches| system.warm(caches));
        let feed = |work| Ok(system.feed(work, &mut NoProbe)?);
        replayer.frame_with(frame, &tree, feed).unwrap();
        system.drain(&mut NoProbe).unwrap();
        caches = Some(system.caches());
        assert_eq!(system.finish(&mut NoProbe).unwrap().0, *expected);
    }
}

#[test]
fn without_cycles_too() {
    let trace = trace();
    let [cold, warm] = [false, true].map(|warm| stats(&trace, &[30, 31], warm, Detail::Counts));
    assert_eq!(warm[0], cold[0]);
    assert!(l2_misses(&warm[1]) * 4 < l2_misses(&cold[1]), "{} and {}", l2_misses(&warm[1]), l2_misses(&cold[1]));
}
