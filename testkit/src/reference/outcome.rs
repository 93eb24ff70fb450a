//! What the second implementation says about a frame.

use std::collections::{BTreeMap, BTreeSet};

use rayreel_replay::policy::view::SampleState;

use crate::past::Traced;
use crate::recorded::Rays;
use crate::rules::Hit;

/// Origin a sample came to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An R-sample, traced first.
    R,
    /// Traced by the X or the Y step, or by correction.
    Traced,
    /// Some rays were traced and some hits interpolated.
    Partial,
    /// Interpolated.
    Interpolated,
}

impl From<SampleState> for Origin {
    fn from(state: SampleState) -> Self {
        match state {
            SampleState::Reference => Self::R,
            SampleState::Traced => Self::Traced,
            SampleState::Partial => Self::Partial,
            SampleState::Interpolated => Self::Interpolated,
        }
    }
}

/// What was sought in a history.
#[derive(Default)]
pub struct Sought {
    /// Hits whose lights were sought.
    pub hits: u64,
    /// Entries that were read.
    pub read: BTreeSet<usize>,
    /// By tile, by its first sample: checks, and those that were mistaken.
    pub checked: BTreeMap<(usize, usize), (u64, u64)>,
    /// Of hits of which the history was right: the local colour that would have stood for another one, and the true one.
    pub twins: Vec<[[f32; 3]; 2]>,
}

/// What the reference found out about a frame. Samples are row by row over the whole grid.
pub struct Outcome {
    /// Samples in a row.
    pub width: usize,
    /// Origin each came to be known.
    pub how: Vec<Origin>,
    /// The round in which each was decided; 0 for R-samples.
    pub rounds: Vec<u8>,
    /// Linear red, green and blue of each.
    pub colours: Vec<[f32; 3]>,
    /// Per sample and recorded hit which of its rays were traced.
    pub traced: Vec<Vec<Traced>>,
    /// Samples whose primary hit is interpolated and has traced hits below, with its tree.
    pub stand_ins: Vec<(usize, Hit)>,
    /// All rays that are recorded.
    pub rays_full: Rays,
    /// Rays that tiles traced for their samples.
    pub rays_traced: Rays,
    /// Rays traced once more by a tile that shares no apron.
    pub rays_apron: Rays,
    /// Samples traced once more.
    pub samples_apron: u64,
    /// Attributes of interpolated hits, if they are made when they are read.
    pub attributes: u64,
    /// What was sought in the history.
    pub history: Sought,
    /// Rays of the traced and of the apron samples, per tile.
    pub tiles: Vec<(Rays, Rays)>,
}

impl Outcome {
    /// Number of samples of a kind.
    pub fn count(&self, how: Origin) -> u64 {
        self.how.iter().filter(|h| **h == how).count() as u64
    }
}
