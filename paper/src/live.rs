//! Frames that are traced when they are replayed, and never written.
//!
//! A trace is worth its making when it is read often. The whole animation is read once, by all its policies at a time: coding
//! and decoding it would take longer than tracing it, and a disk would have to hold it.

use std::sync::{Arc, PoisonError, RwLock};

use rayon::prelude::*;
use rayreel_formats::bvh::Bvh;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_formats::trace::PackedColumn;
use rayreel_formats::{Error, Result};
use rayreel_machine::work::recorded::TilePaths;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::source::PackedTile;
use rayreel_replay::{PathSource, ReplayError, Stop, TileSource};
use rayreel_scenes::Scene;
use rayreel_tracer::accel::Built;
use rayreel_tracer::{TraceSettings, Tracer, convert};

/// What a trace of `meta` would hold.
pub struct LiveSource<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    tracer: Tracer<'a>,
    meta: &'a Meta,
}

impl<'a> LiveSource<'a> {
    /// Nothing is traced yet.
    pub fn new(scene: &'a Scene, built: &'a Built, meta: &'a Meta) -> Self {
        let settings = TraceSettings::of(meta);
        Self { scene, bvh: &built.bvh, tracer: Tracer::new(scene, built, settings), meta }
    }

    fn traced<const PATHS: bool>(&self, frame: u32, index: u32) -> Result<Tile> {
        Ok(self.tracer.tile::<PATHS>(&self.camera(frame)?, self.meta.tile_rect(index), frame, index))
    }
}

impl TileSource for LiveSource<'_> {
    fn meta(&self) -> &Meta {
        self.meta
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.bvh.triangles[triangle as usize].object
    }

    fn camera(&self, frame: u32) -> Result<Camera> {
        let (columns, rows) = self.meta.grid();
        let camera = self.scene.cameras.get(frame as usize).ok_or_else(|| Error::usage("no such frame"))?;
        Ok(convert::camera(camera, columns, rows))
    }

    fn tile(&self, frame: u32, index: u32) -> Result<Tile> {
        self.traced::<false>(frame, index)
    }
}

impl PathSource for LiveSource<'_> {
    fn topology(&self) -> Topology {
        Topology::new(self.bvh)
    }

    fn material_of(&self, triangle: u32) -> u32 {
        self.bvh.triangles[triangle as usize].material
    }

    fn tile_with_paths(&self, frame: u32, index: u32) -> Result<Tile> {
        self.traced::<true>(frame, index)
    }
}

/// A source of which one frame is held in memory, without paths, for all who replay it.
pub struct FrameHolder<'a, S> {
    source: &'a S,
    frame: RwLock<Option<WholeFrame>>,
}

/// All tiles of a frame.
pub struct WholeFrame {
    number: u32,
    tiles: Vec<Arc<Tile>>,
}

impl<'a, S: PathSource> FrameHolder<'a, S> {
    /// Holds nothing yet.
    pub fn new(source: &'a S) -> Self {
        Self { source, frame: RwLock::new(None) }
    }

    /// Reads a whole frame; `stop` ends it at the next tile.
    ///
    /// # Errors
    /// Those of the source; an interruption.
    pub fn read(&self, number: u32, stop: &Stop) -> rayreel_replay::Result<WholeFrame> {
        let read = |index: u32| {
            stop.check()?;
            self.source.shared_tile(number, index).map_err(|error| ReplayError::tile((number, index), error))
        };
        // Collected one by one before errors are looked at: the first tile that cannot be read is told, whichever was tried first.
        let tiles: Vec<_> = (0..self.source.meta().tile_count()).into_par_iter().map(read).collect();
        Ok(WholeFrame { number, tiles: tiles.into_iter().collect::<rayreel_replay::Result<_>>()? })
    }

    /// Holds this frame from now on, and none other.
    pub fn hold(&self, frame: WholeFrame) {
        *self.frame.write().unwrap_or_else(PoisonError::into_inner) = Some(frame);
    }
}

impl<S: PathSource> TileSource for FrameHolder<'_, S> {
    fn meta(&self) -> &Meta {
        self.source.meta()
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.source.object_of(triangle)
    }

    fn camera(&self, frame: u32) -> Result<Camera> {
        self.source.camera(frame)
    }

    fn tile(&self, frame: u32, index: u32) -> Result<Tile> {
        self.shared_tile(frame, index).map(Arc::unwrap_or_clone)
    }

    fn shared_tile(&self, frame: u32, index: u32) -> Result<Arc<Tile>> {
        match &*self.frame.read().unwrap_or_else(PoisonError::into_inner) {
            Some(held) if held.number == frame => {
                held.tiles.get(index as usize).cloned().ok_or_else(|| Error::usage("no such tile"))
            }
            _ => self.source.shared_tile(frame, index),
        }
    }
}

impl<S: PathSource> PathSource for FrameHolder<'_, S> {
    fn topology(&self) -> Topology {
        self.source.topology()
    }

    fn material_of(&self, triangle: u32) -> u32 {
        self.source.material_of(triangle)
    }

    fn tile_with_paths(&self, frame: u32, index: u32) -> Result<Tile> {
        self.source.tile_with_paths(frame, index)
    }

    fn packed_tile(&self, frame: u32, index: u32) -> Result<PackedTile> {
        self.source.packed_tile(frame, index)
    }

    fn paths(&self, tile: &Tile, packed: &PackedColumn) -> Result<Arc<TilePaths>> {
        self.source.paths(tile, packed)
    }
}
