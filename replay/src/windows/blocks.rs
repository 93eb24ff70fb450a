//! Which tiles of a frame are simulated: the frame is cut into blocks of consecutive tiles, and some blocks become windows.
//!
//! The choice depends on the number of tiles, the machine's tile slots and the share asked for, and on nothing else: runs of
//! several policies have the same windows, so that what these share cancels in ratios. The first block and the last are always
//! simulated: at the beginning the machine is empty and its caches are cold, at the end it drains.

use std::ops::Range;

use crate::detail::Detail;

/// Fewer windows than this tell too little about one another.
const FEWEST_WINDOWS: usize = 12;
/// More of the tiles than this, warm-up included, are not worth a sample: the frame is simulated whole.
const WORTH: f64 = 0.75;
/// Where all blocks are simulated: tiles of a block for each slot of the machine. Each seam between two blocks costs accuracy,
/// and the warm-up of each costs time; but the tiles of a block are in memory together.
const LONG_BLOCK: usize = 16;

/// The blocks of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocks {
    tiles: usize,
    /// Tiles of a block; the last one has what is left as well.
    length: usize,
    /// Tiles before a window that are simulated, and not measured.
    warm_up: usize,
    /// Per block whether it is a window.
    chosen: Vec<bool>,
}

impl Blocks {
    /// The blocks of a frame of `tiles` tiles on a machine with `slots` tile slots; nothing where the frame is to be simulated
    /// whole. `share` is the part of the tiles to be measured, or 1 for all of them.
    pub fn new(tiles: usize, slots: usize, share: f64) -> Option<Self> {
        let (slots, all) = (slots.max(4), share >= 1.0);
        let length = if all { slots * LONG_BLOCK } else { slots };
        let warm_up = if all { 2 * slots } else { slots };
        let blocks = tiles / length;
        if blocks < if all { 2 } else { FEWEST_WINDOWS + 2 } {
            return None;
        }
        let middle = blocks - 2;
        let windows = if all { middle } else { ((share * blocks as f64).round() as usize).max(FEWEST_WINDOWS) };
        let simulated = (windows + 2) * (length + slots);
        if !all && (windows > middle || simulated as f64 > WORTH * tiles as f64) {
            return None;
        }
        let mut chosen = vec![false; blocks];
        (chosen[0], chosen[blocks - 1]) = (true, true);
        // In the middle of equal parts.
        (0..windows).for_each(|i| chosen[1 + (2 * i + 1) * middle / (2 * windows)] = true);
        Some(Self { tiles, length, warm_up, chosen })
    }

    /// The blocks of what a frame is to be simulated with, as [`Blocks::new`].
    pub fn of(detail: Detail, tiles: usize, slots: usize) -> Option<Self> {
        match detail {
            Detail::Full | Detail::Counts => None,
            Detail::All => Self::new(tiles, slots, 1.0),
            Detail::Sampled(share) => Self::new(tiles, slots, share.fraction()),
            Detail::Precision(_) => Self::new(tiles, slots, 0.0),
        }
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.chosen.len()
    }

    /// The block of a tile.
    pub fn block_of(&self, tile: usize) -> usize {
        (tile / self.length).min(self.len() - 1)
    }

    /// The tiles of a block.
    pub fn tiles(&self, block: usize) -> Range<usize> {
        let end = if block + 1 == self.len() { self.tiles } else { (block + 1) * self.length };
        block * self.length..end
    }

    /// Where the warm-up of a block begins.
    pub fn warm_up(&self, block: usize) -> usize {
        (block * self.length).saturating_sub(self.warm_up)
    }

    /// Whether a block is a window.
    pub fn is_chosen(&self, block: usize) -> bool {
        self.chosen[block]
    }

    /// Whether a block is simulated however few are: the first and the last.
    pub fn is_edge(&self, block: usize) -> bool {
        block == 0 || block + 1 == self.len()
    }

    /// Windows between the first block and the last, and blocks there.
    pub fn middle(&self) -> (usize, usize) {
        (self.chosen.iter().filter(|chosen| **chosen).count() - 2, self.len() - 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_every_tile_once() {
        for (tiles, share) in [(2048, 0.1), (2050, 0.05), (517, 0.2), (2047, 1.0)] {
            let blocks = Blocks::new(tiles, 8, share).unwrap();
            let held: Vec<usize> = (0..blocks.len()).flat_map(|block| blocks.tiles(block)).collect();
            assert_eq!(held, (0..tiles).collect::<Vec<_>>());
            assert!((0..tiles).all(|tile| blocks.tiles(blocks.block_of(tile)).contains(&tile)));
            let warm_up = if share < 1.0 { 8 } else { 16 };
            assert!((1..blocks.len()).all(|block| blocks.warm_up(block) == blocks.tiles(block).start - warm_up));
        }
    }

    #[test]
    fn windows_are_as_many_as_asked_for_and_evenly_spread() {
        let blocks = Blocks::new(8192, 8, 0.05).unwrap();
        assert_eq!(blocks.middle(), (51, 1022));
        let at: Vec<usize> = (0..blocks.len()).filter(|&block| blocks.is_chosen(block)).collect();
        let steps: Vec<usize> = at[1..at.len() - 1].windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| (19..=21).contains(step)), "{steps:?}");
        assert!(blocks.is_chosen(0) && blocks.is_chosen(1023));
    }

    #[test]
    fn small_frames_are_simulated_whole() {
        assert_eq!(Blocks::new(64, 8, 0.1), None);
        assert_eq!(Blocks::new(2048, 8, 0.5), None, "with warm-up that is all of it");
        assert!(Blocks::new(512, 8, 0.1).is_some());
        assert_eq!(Blocks::new(64, 8, 1.0), None);
    }

    #[test]
    fn where_all_is_simulated_every_block_is_a_window() {
        let blocks = Blocks::new(2048, 8, 1.0).unwrap();
        assert!((0..blocks.len()).all(|block| blocks.is_chosen(block)));
        assert_eq!(blocks.middle(), (14, 14));
    }
}
