//! What became of each sample of a frame.

use std::ops::Range;

use rayon::prelude::*;
use rayreel_formats::scene::Meta;

use crate::policy::view::SampleState;

/// State and round of every sample of a frame, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateMap {
    /// Columns of samples.
    pub width: u32,
    /// Rows of samples.
    pub height: u32,
    states: Vec<SampleState>,
    rounds: Vec<u8>,
}

impl StateMap {
    /// A map in which every sample is an R-sample.
    pub fn new((width, height): (u32, u32)) -> Self {
        let len = width as usize * height as usize;
        Self { width, height, states: vec![SampleState::Reference; len], rounds: vec![0; len] }
    }

    /// The state of sample (`x`, `y`).
    ///
    /// # Panics
    /// When the sample is outside the frame.
    pub fn state(&self, x: u32, y: u32) -> SampleState {
        self.states[self.offset(x, y)]
    }

    /// The round in which a sample was traced or interpolated: 0 for R-samples, then the tests of the X step, then those of
    /// the Y step, one round a level of refinement.
    ///
    /// # Panics
    /// When the sample is outside the frame.
    pub fn round(&self, x: u32, y: u32) -> u8 {
        self.rounds[self.offset(x, y)]
    }

    /// Sets whole rows: `states` is asked for each of them and gives its states, left to right.
    pub(crate) fn set_rows(
        &mut self,
        rows: Range<u32>,
        states: impl Fn(u32, &mut dyn FnMut(Option<(SampleState, u8)>)) + Sync,
    ) {
        let width = self.width as usize;
        if rows.is_empty() || width == 0 {
            return;
        }
        let range = rows.start as usize * width..rows.end as usize * width;
        let lines = self.states[range.clone()].par_chunks_exact_mut(width);
        let lines = lines.zip(self.rounds[range].par_chunks_exact_mut(width)).zip(rows);
        lines.for_each(|((line, rounds), y)| {
            let mut samples = line.iter_mut().zip(rounds);
            states(y, &mut |state| {
                if let (Some((to, round)), Some(state)) = (samples.next(), state) {
                    (*to, *round) = state;
                }
            });
        });
    }

    fn offset(&self, x: u32, y: u32) -> usize {
        assert!(x < self.width && y < self.height, "sample ({x}, {y}) is outside the frame");
        y as usize * self.width as usize + x as usize
    }
}

/// The block edge of each tile of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocks {
    /// Tiles in a row.
    columns: u32,
    /// Tile edge, samples.
    tile: u32,
    blocks: Vec<u32>,
}

impl Blocks {
    /// The blocks of the tiles of a frame of `meta`, in tile order.
    ///
    /// # Panics
    /// When there is not one a tile.
    pub fn new(blocks: Vec<u32>, meta: &Meta) -> Self {
        assert_eq!(blocks.len(), meta.tile_count() as usize, "one block a tile");
        Self { columns: meta.tile_grid().0, tile: meta.tile, blocks }
    }

    /// A column of tiles of so many samples, for tests.
    #[cfg(test)]
    pub(crate) fn column(tile: u32, blocks: Vec<u32>) -> Self {
        Self { columns: 1, tile, blocks }
    }

    /// The same block for all samples.
    pub fn uniform(block: u32) -> Self {
        Self { columns: 1, tile: u32::MAX, blocks: vec![block] }
    }

    /// The block at sample (`x`, `y`).
    pub fn at(&self, x: u32, y: u32) -> u32 {
        self.blocks[((y / self.tile) * self.columns + x / self.tile) as usize]
    }

    /// Tile edge in samples, no longer than this edge of the frame.
    pub fn tile_edge(&self, of_frame: u32) -> u32 {
        self.tile.min(of_frame.max(1))
    }

    /// The blocks in tile order.
    pub fn tiles(&self) -> &[u32] {
        &self.blocks
    }
}
