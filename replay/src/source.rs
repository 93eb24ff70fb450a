//! Where a replay reads from: a trace, or a synthetic frame of a test.

use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{Column, Tile};
use rayreel_formats::trace::Trace;

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
        Self::tile(self, frame, index, COLUMNS)
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
}
