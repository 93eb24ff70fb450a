//! Where a replay reads from: a trace, or a synthetic frame of a test.

use std::cell::RefCell;
use std::sync::Arc;

use rayreel_formats::Error;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{Column, Tile};
use rayreel_formats::trace::{Codec, PackedColumn, Scratch, Trace};
use rayreel_machine::work::recorded::{PathRecorder, TilePaths};
use rayreel_machine::work::topology::Topology;

/// A recorded frame sequence. Every call may come from any thread.
pub trait TileSource: Sync {
    /// What was captured.
    fn meta(&self) -> &Meta;

    /// The object that a triangle (in leaf order) belongs to.
    fn object_of(&self, triangle: u32) -> u32;

    /// The camera of a frame.
    ///
    /// # Errors
    /// When the source cannot be read or does not hold the frame.
    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera>;

    /// The ray trees, hits and radiance of a tile; traversal paths may be missing.
    ///
    /// # Errors
    /// When the source cannot be read or does not hold the tile.
    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile>;

    /// As [`TileSource::tile`]. A source that keeps tiles hands out the one that it has.
    ///
    /// # Errors
    /// As there.
    fn shared_tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Arc<Tile>> {
        self.tile(frame, index).map(Arc::new)
    }

    /// How many rays a tile has, under `full`.
    ///
    /// # Errors
    /// As [`TileSource::tile`].
    fn ray_count(&self, frame: u32, index: u32) -> rayreel_formats::Result<u64> {
        self.shared_tile(frame, index).map(|tile| tile.tree.ray_count())
    }
}

/// A tile with its paths: as steps in [`Tile::paths`], which nobody has checked, or as bytes.
#[derive(Clone, Debug)]
pub struct PackedTile {
    /// The tile.
    pub tile: Arc<Tile>,
    /// What [`PathSource::paths`] makes its paths of; `None` if the tile has them.
    pub packed: Option<Arc<PackedColumn>>,
}

/// A source that also holds traversal paths: what the machine needs beside the policy.
pub trait PathSource: TileSource {
    /// The tree that the paths lead through.
    fn topology(&self) -> Topology;

    /// The material of a triangle (in leaf order).
    fn material_of(&self, triangle: u32) -> u32;

    /// As [`TileSource::tile`], with the traversal paths.
    ///
    /// # Errors
    /// As there.
    fn tile_with_paths(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile>;

    /// As [`TileSource::tile`], with the traversal paths for later: packed they are a hundredth of what is made of them.
    ///
    /// # Errors
    /// As there.
    fn packed_tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<PackedTile> {
        Ok(PackedTile { tile: Arc::new(self.tile_with_paths(frame, index)?), packed: None })
    }

    /// The paths of a tile as operations, from the bytes that came with it. They are known to lead through the tree. A source that
    /// keeps paths hands out those that it has.
    ///
    /// # Errors
    /// When they are damaged; when this source does not pack paths.
    fn paths(&self, tile: &Tile, _packed: &PackedColumn) -> rayreel_formats::Result<Arc<TilePaths>> {
        Err(Error::usage(format!("the source of tile {} packs no paths", tile.index)))
    }
}

/// What a policy reads of a trace: everything but the traversal paths.
const COLUMNS: &[Column] = &[Column::Tree, Column::Hits, Column::Radiance];

impl TileSource for Trace {
    fn meta(&self) -> &Meta {
        Self::meta(self)
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.bvh().triangles[triangle as usize].object
    }

    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        Self::camera(self, frame)
    }

    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        SCRATCH.with_borrow_mut(|scratch| self.tile_with(frame, index, COLUMNS, scratch))
    }

    fn ray_count(&self, frame: u32, index: u32) -> rayreel_formats::Result<u64> {
        Self::ray_count(self, frame, index)
    }
}

impl PathSource for Trace {
    fn topology(&self) -> Topology {
        Topology::new(self.bvh())
    }

    fn material_of(&self, triangle: u32) -> u32 {
        self.bvh().triangles[triangle as usize].material
    }

    fn tile_with_paths(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        Self::tile(self, frame, index, &Column::ALL)
    }

    fn packed_tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<PackedTile> {
        let (mut tile, packed) = Self::packed_tile(self, frame, index)?;
        if packed.codec == Codec::CONTEXT {
            return Ok(PackedTile { tile: Arc::new(tile), packed: Some(Arc::new(packed)) });
        }
        tile.paths = SCRATCH.with_borrow_mut(|scratch| Self::paths(self, &tile, &packed, scratch))?;
        Ok(PackedTile { tile: Arc::new(tile), packed: None })
    }

    fn paths(&self, tile: &Tile, packed: &PackedColumn) -> rayreel_formats::Result<Arc<TilePaths>> {
        let mut recorder = PathRecorder::default();
        let decode = |scratch: &mut Scratch| self.paths_to(tile, packed, scratch, &mut recorder);
        let shared = SCRATCH.with_borrow_mut(decode)?;
        Ok(Arc::new(recorder.finish(shared)))
    }
}

thread_local! {
    /// Memory of decoders, kept from tile to tile.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}
