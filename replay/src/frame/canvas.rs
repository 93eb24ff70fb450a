//! A frame that is put together from its rows of tiles.

use rayreel_formats::scene::Meta;

use super::states::{Blocks, StateMap};
use super::traced::TracedMap;
use crate::counts::{FrameStats, TileStats};
use crate::error::Result;
use crate::image::Image;
use crate::image::compare::Comparer;
use crate::image::flip::FlipMap;
use crate::image::resolve::Resolver;
use crate::policy::tree::Node;
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
    /// The rays that were traced for each, if they were asked for.
    pub traced: Option<TracedMap>,
    /// Block edge of each tile in samples; 1 for `full`.
    pub blocks: Blocks,
    /// Counts and quality.
    pub stats: FrameStats,
}

/// The picture of `full`.
enum Reference {
    /// It is not wanted.
    Not,
    /// It is made here too.
    Made(Resolver),
    /// It was made elsewhere.
    Given(Image),
}

/// A frame that is being put together.
pub(super) struct Canvas {
    image: Resolver,
    reference: Reference,
    states: StateMap,
    traced: Option<TracedMap>,
    /// What the tiles cost that are in, in order.
    pub tiles: Vec<TileStats>,
}

impl Canvas {
    /// For a frame of a trace; with `reference` it makes the picture of `full` too, with `traced` the map of rays.
    pub fn new(meta: &Meta, reference: bool, traced: bool) -> Self {
        let resolver = || Resolver::new(meta.width, meta.height, meta.samples);
        Self {
            image: resolver(),
            reference: if reference { Reference::Made(resolver()) } else { Reference::Not },
            states: StateMap::new(meta.grid()),
            traced: traced.then(|| TracedMap::new(meta)),
            tiles: Vec::new(),
        }
    }

    /// Takes over a row of decided tiles; rows come top to bottom.
    pub fn add(&mut self, tiles: &[TileView], stats: Vec<TileStats>) {
        let rows = tiles.first().map_or(0..0, |t| t.rect().y..t.rect().y + t.rect().height);
        let known = |y, add: &mut dyn FnMut(&[Node])| tiles.iter().for_each(|view| view.row(y, |tree, _| add(tree)));
        self.image.add_rows(rows.clone(), |y, add| known(y, &mut |tree| add(tree[0].colour)));
        if let Reference::Made(reference) = &mut self.reference {
            reference.add_rows(rows.clone(), |y, add| {
                tiles.iter().for_each(|view| view.recorded_row(y).for_each(&mut *add))
            });
        }
        self.states.set_rows(rows, |y, set| tiles.iter().for_each(|view| view.row(y, |_, state| set(state))));
        if let Some(traced) = &mut self.traced {
            tiles.iter().for_each(|view| traced.add(view));
        }
        self.tiles.extend(stats);
    }

    /// The picture of `full`, once all rows are in; the canvas is without it then.
    pub fn take_reference(&mut self) -> Option<Image> {
        match std::mem::replace(&mut self.reference, Reference::Not) {
            Reference::Not => None,
            Reference::Made(made) => Some(made.finish()),
            Reference::Given(image) => Some(image),
        }
    }

    /// The canvas with this picture of `full`, of the same frame.
    #[must_use]
    pub fn with_reference(mut self, reference: Option<&Image>) -> Self {
        self.reference = reference.map_or(Reference::Not, |image| Reference::Given(image.clone()));
        self
    }

    /// The frame, once all rows are in.
    ///
    /// # Errors
    /// Never for pictures of this canvas: they have the same size.
    pub fn finish(mut self, frame: u32, blocks: Blocks, comparer: &mut Comparer) -> Result<FrameReplay> {
        let reference = self.take_reference();
        let image = self.image.finish();
        let compared = reference.as_ref().map(|full| comparer.compare(frame, &image, full)).transpose()?;
        let counts = self.tiles.iter().map(|t| t.counts).sum();
        let (quality, tile_errors, flip) = match compared {
            Some(found) => (Some(found.quality), found.tiles, found.flip),
            None => (None, Vec::new(), None),
        };
        let stats = FrameStats { frame, counts, tiles: self.tiles, quality, tile_errors };
        Ok(FrameReplay { frame, image, reference, flip, states: self.states, traced: self.traced, blocks, stats })
    }
}
