//! A frame that is put together from its rows of tiles.

use rayreel_formats::scene::Meta;

use super::states::{Blocks, StateMap};
use crate::counts::{FrameStats, TileStats};
use crate::error::Result;
use crate::image::Image;
use crate::image::compare::Comparer;
use crate::image::flip::FlipMap;
use crate::image::resolve::Resolver;
use crate::policy::view::TileView;

/// A replayed frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameReplay {
    /// Frame number.
    pub frame: u32,
    /// The policy's picture, linear RGB.
    pub image: Image,
    /// The picture of `full`, if it was asked for.
    pub reference: Option<Image>,
    /// Where a viewer sees that they differ, if they were compared so.
    pub flip: Option<FlipMap>,
    /// What became of each sample.
    pub states: StateMap,
    /// Block edge of each tile in samples; 1 for `full`.
    pub blocks: Blocks,
    /// Counts and quality.
    pub stats: FrameStats,
}

/// A frame that is being put together.
pub(super) struct Canvas {
    image: Resolver,
    reference: Option<Resolver>,
    states: StateMap,
    /// What the tiles cost that are in, in order.
    pub tiles: Vec<TileStats>,
}

impl Canvas {
    /// For a frame of a trace; with `reference` it makes the picture of `full` too.
    pub fn new(meta: &Meta, reference: bool) -> Self {
        let resolver = || Resolver::new(meta.width, meta.height, meta.samples);
        Self {
            image: resolver(),
            reference: reference.then(resolver),
            states: StateMap::new(meta.grid()),
            tiles: Vec::new(),
        }
    }

    /// Takes over a row of decided tiles; rows come top to bottom.
    pub fn add(&mut self, tiles: &[TileView], stats: Vec<TileStats>) {
        let rows = tiles.first().map_or(0..0, |t| t.rect().y..t.rect().y + t.rect().height);
        for y in rows {
            for view in tiles {
                let rect = view.rect();
                for x in rect.x..rect.x + rect.width {
                    self.image.add(x, y, view.tree(x, y)[0].colour);
                    if let Some(state) = view.state(x, y) {
                        self.states.set(x, y, state);
                    }
                }
                if let Some(reference) = &mut self.reference {
                    (rect.x..).zip(view.recorded_row(y)).for_each(|(x, colour)| reference.add(x, y, colour));
                }
            }
        }
        self.tiles.extend(stats);
    }

    /// The frame, once all rows are in.
    ///
    /// # Errors
    /// Never for pictures of this canvas: they have the same size.
    pub fn finish(self, frame: u32, blocks: Blocks, comparer: &mut Comparer) -> Result<FrameReplay> {
        let image = self.image.finish();
        let reference = self.reference.map(Resolver::finish);
        let compared = reference.as_ref().map(|full| comparer.compare(frame, &image, full)).transpose()?;
        let counts = self.tiles.iter().map(|t| t.counts).sum();
        let (quality, tile_errors, flip) = match compared {
            Some(found) => (Some(found.quality), found.tiles, found.flip),
            None => (None, Vec::new(), None),
        };
        let stats = FrameStats { frame, counts, tiles: self.tiles, quality, tile_errors };
        Ok(FrameReplay { frame, image, reference, flip, states: self.states, blocks, stats })
    }
}
