//! The trees of the samples that are known: those that were traced are the recorded ones, the others were made.

use std::ops::Range;

use rayreel_formats::scene::Rect;

use super::recorded::Recorded;
use crate::policy::tree::Node;

/// Per sample where its tree stands.
pub(super) struct Known {
    /// First hit, with [`RECORDED`] if it is among those recorded and not among those made; and the number of hits, 0 where
    /// nothing is known.
    spans: Vec<(u32, u32)>,
    made: Vec<Node>,
}

const RECORDED: u32 = 1 << 31;

impl Known {
    /// Nothing is known of so many samples.
    pub fn new(samples: usize) -> Self {
        Self { spans: vec![(0, 0); samples], made: Vec::new() }
    }

    /// A sample is as recorded in this range, whatever was known of it.
    pub fn trace(&mut self, sample: usize, range: Range<usize>) {
        self.spans[sample] = (range.start as u32 | RECORDED, range.len() as u32);
    }

    /// A sample has this tree.
    pub fn make(&mut self, sample: usize, tree: &[Node]) {
        self.spans[sample] = (self.made.len() as u32, tree.len() as u32);
        self.made.extend_from_slice(tree);
    }

    /// Hits beyond one a sample, of which `kept` are kept of the hits of a sample.
    pub fn secondary_hits(&self, kept: impl Fn(usize, u32) -> u32) -> u32 {
        self.spans.iter().enumerate().map(|(i, &(_, len))| kept(i, len).saturating_sub(1)).sum()
    }
}

/// What is known of a tile: it gives out nothing else.
#[derive(Clone, Copy)]
pub struct KnownTrees<'a> {
    pub(super) rect: Rect,
    pub(super) known: &'a Known,
    pub(super) recorded: &'a Recorded,
}

impl<'a> KnownTrees<'a> {
    /// The tree of a sample that was traced or interpolated.
    ///
    /// # Panics
    /// When the sample is outside the tile, or not known yet.
    #[inline]
    pub fn tree(self, x: u32, y: u32) -> &'a [Node] {
        let i = offset(self.rect, x, y);
        let tree = self.of(i);
        assert!(!tree.is_empty(), "a policy read sample ({x}, {y}) before it was known");
        tree
    }

    /// The tree of the `i`-th sample of the tile; empty if it is not known.
    #[inline]
    pub(super) fn of(self, i: usize) -> &'a [Node] {
        let (start, len) = self.known.spans[i];
        let nodes = if start & RECORDED == 0 { &self.known.made } else { &self.recorded.nodes };
        &nodes[(start & !RECORDED) as usize..][..len as usize]
    }
}

/// The number of a sample in its tile.
///
/// # Panics
/// When it is outside.
#[inline]
pub(super) fn offset(rect: Rect, x: u32, y: u32) -> usize {
    let Rect { x: left, y: top, width, height } = rect;
    let inside = (left..left + width).contains(&x) && (top..top + height).contains(&y);
    assert!(inside, "sample ({x}, {y}) is outside the tile");
    (y - top) as usize * width as usize + (x - left) as usize
}
