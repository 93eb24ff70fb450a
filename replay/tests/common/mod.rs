//! What tests of the work for a machine share.

use rayreel_formats::trace::Trace;
use rayreel_machine::work::TileWork;
use rayreel_replay::policy::SamplePolicy;
use rayreel_replay::{FrameReplay, Options, PathSource, Replayer};

/// What a replay made of a frame, and what a machine has to do for each tile.
pub type FrameWork = (FrameReplay, Vec<TileWork>);

/// Some frames of a trace, one after the other.
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
