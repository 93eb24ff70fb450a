//! Several frames, one after the other.

use super::canvas::FrameReplay;
use super::replayer::{Options, Replayer};
use crate::counts::FrameStats;
use crate::error::{RequestError, Result};
use crate::policy::SamplePolicy;
use crate::source::TileSource;

/// Several replayed frames, all in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The frames, in the order asked for.
    pub frames: Vec<FrameReplay>,
}

impl Replay {
    /// The statistics of all frames, as a report takes them.
    pub fn stats(&self) -> Vec<FrameStats> {
        self.frames.iter().map(|f| f.stats.clone()).collect()
    }
}

/// Replays `frames` and keeps them all.
///
/// # Errors
/// As [`Replayer::new`] and [`Replayer::frame`].
pub fn replay<S: TileSource + ?Sized, P: SamplePolicy + ?Sized>(
    source: &S,
    policy: &P,
    frames: impl IntoIterator<Item = u32>,
    options: Options,
) -> Result<Replay> {
    let mut kept = Vec::new();
    replay_each(source, policy, frames, options, |frame| {
        kept.push(frame);
        Ok(())
    })?;
    Ok(Replay { frames: kept })
}

/// Replays `frames` one by one, gives each to `sink` and keeps only its statistics.
///
/// # Errors
/// As [`Replayer::new`] and [`Replayer::frame`], and what `sink` returns.
pub fn replay_each<S: TileSource + ?Sized, P: SamplePolicy + ?Sized>(
    source: &S,
    policy: &P,
    frames: impl IntoIterator<Item = u32>,
    options: Options,
    mut sink: impl FnMut(FrameReplay) -> Result<()>,
) -> Result<Vec<FrameStats>> {
    let mut replayer = Replayer::new(source, policy, options)?;
    let mut stats = Vec::new();
    for number in frames {
        let frame = replayer.frame(number)?;
        stats.push(frame.stats.clone());
        sink(frame)?;
    }
    if stats.is_empty() {
        return Err(RequestError::Nothing { what: "no frame was chosen" }.into());
    }
    Ok(stats)
}
