//! Which attributes of interpolated hits there are: those that were made with their sample, and those that a test has read.

use rayreel_formats::scene::Rect;

/// Per sample how many of its hits, in the order of its tree, have attributes. Tests read trees in this order, and end early.
#[derive(Default)]
pub(super) struct MadeAttributes {
    /// Of the tile's samples; empty where all are made with their samples, or never.
    samples: Vec<u32>,
    /// Of the samples of the row below, which a tile reads.
    below: Vec<u32>,
}

impl MadeAttributes {
    /// From now on attributes are made when they are read.
    pub fn begin(&mut self, rect: Rect) {
        (self.samples, self.below) = (vec![0; rect.len()], vec![0; rect.width as usize]);
    }

    /// The first `hits` hits of a sample have attributes.
    pub fn make(&mut self, sample: usize, hits: u32) {
        if let Some(made) = self.samples.get_mut(sample) {
            *made = hits;
        }
    }

    /// The first `hits` hits of a sample are read: how many have to be made for that.
    pub fn read(&mut self, sample: usize, hits: u32) -> u32 {
        self.samples.get_mut(sample).map_or(0, |made| raise(made, hits))
    }

    /// As [`MadeAttributes::read`], for a column of the row below.
    pub fn read_below(&mut self, column: usize, hits: u32) -> u32 {
        self.below.get_mut(column).map_or(0, |made| raise(made, hits))
    }

    /// Hits of a sample that have attributes, if they are made when they are read.
    pub fn of(&self, sample: usize) -> Option<u32> {
        self.samples.get(sample).copied()
    }
}

/// Raises `made` to `hits`; by how much.
fn raise(made: &mut u32, hits: u32) -> u32 {
    let new = hits.saturating_sub(*made);
    *made += new;
    new
}
