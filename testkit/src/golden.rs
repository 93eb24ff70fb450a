//! The golden traces, and the work that their tiles become.

use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_machine::work::TileWork;
use rayreel_replay::policy::SamplePolicy;
use rayreel_replay::{FrameReplay, Options, PathSource, Replayer};

/// A trace of the folder `traces`.
///
/// # Panics
/// When there is none of that name, or it cannot be read.
pub fn trace(name: &str) -> Trace {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces").join(name);
    Trace::open(&file, Limits::default()).unwrap()
}

/// Both.
pub fn traces() -> [Trace; 2] {
    ["v1_0_cornell.rtrace", "v1_0_teapot.rtrace"].map(trace)
}

/// What a replay made of a frame, and what a machine has to do for each tile.
pub type FrameWork = (FrameReplay, Vec<TileWork>);

/// Some frames of a trace, one after the other.
///
/// # Panics
/// When a frame cannot be replayed.
pub fn work_of(trace: &Trace, policy: &impl SamplePolicy, frames: impl IntoIterator<Item = u32>) -> Vec<FrameWork> {
    let mut replayer = Replayer::new(trace, policy, Options::default()).unwrap();
    let frame = |number| {
        let mut works = Vec::new();
        let keep = |work| {
            works.push(work);
            Ok(())
        };
        let (frame, _) = replayer.frame_with(number, &trace.topology(), keep).unwrap();
        (frame, works)
    };
    frames.into_iter().map(frame).collect()
}

/// The same of its first frame.
///
/// # Panics
/// When it cannot be replayed.
pub fn first_work(trace: &Trace, policy: &impl SamplePolicy) -> FrameWork {
    work_of(trace, policy, [trace.meta().first_frame]).remove(0)
}
