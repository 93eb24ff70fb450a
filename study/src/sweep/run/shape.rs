//! How a shard is run, how far it is, and what came of it.

use std::time::Duration;

use rayreel_formats::trace::Trace;
use rayreel_replay::Stop;

use crate::point::segment::Writer;
use crate::sweep::reused::ReusedRows;
use crate::sweep::shard::Shard;

/// How a shard is run.
pub struct Settings<'a> {
    /// Which points.
    pub shard: Shard,
    /// Points that are worked on at a time.
    pub threads: usize,
    /// Bytes of decoded tiles and paths that are kept, of all traces. The more, the more policies go side by side through a large one.
    pub memory: usize,
    /// Least time between two segments: zero writes whatever is finished at once; on a shared file system seconds save files.
    pub flush: Duration,
    /// Who runs it.
    pub writer: Writer,
    /// Ends it early.
    pub stop: Stop,
    /// Opens a trace at the location of the plan.
    pub open: &'a (dyn Fn(&str) -> Result<Trace, String> + Sync),
    /// Rows from elsewhere: points that need not be computed.
    pub reused: &'a ReusedRows,
}

/// How far a shard is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunProgress {
    /// Points whose rows were there before, at the beginning.
    pub skipped: usize,
    /// Points to do, at the beginning.
    pub todo: usize,
    /// Points done, with those being computed in part.
    pub done: f64,
    /// Points whose rows are on disk.
    pub saved: usize,
    /// Points whose rows say that they cannot be computed.
    pub failed: usize,
}

/// What came of a shard.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Points of the shard.
    pub points: usize,
    /// Points whose rows were there before.
    pub skipped: usize,
    /// Rows taken from elsewhere.
    pub reused: usize,
    /// Points computed.
    pub computed: usize,
    /// Those of them that cannot be computed.
    pub failed: usize,
    /// Points that this attempt could not do and another may: what they are, and why.
    pub troubles: Vec<(String, String)>,
    /// Whether a signal ended it.
    pub interrupted: bool,
}
