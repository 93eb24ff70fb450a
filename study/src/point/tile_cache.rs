//! Tiles that several points read, decoded once.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_formats::trace::{PackedColumn, Trace};

use rayreel_machine::work::recorded::TilePaths;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::source::{PackedTile, PathSource, TileSource};

/// A trace with the tiles that were read before, as far as memory is allowed, their paths packed. What does not fit is decoded
/// each time.
pub struct TileCache {
    trace: Trace,
    /// By frame and tile.
    tiles: Vec<OnceLock<PackedTile>>,
    bytes: AtomicUsize,
    limit: usize,
}

impl TileCache {
    /// Nothing is decoded yet; at most about `limit` bytes will be kept.
    pub fn new(trace: Trace, limit: usize) -> Self {
        let meta = trace.meta();
        // A trace whose table of tiles alone is over the limit keeps none.
        let count = meta.frames as usize * meta.tile_count() as usize;
        let count = if count.saturating_mul(size_of::<OnceLock<PackedTile>>()) <= limit { count } else { 0 };
        let tiles = std::iter::repeat_with(OnceLock::new).take(count).collect();
        Self { trace, tiles, bytes: AtomicUsize::new(0), limit }
    }

    fn read(&self, frame: u32, index: u32) -> rayreel_formats::Result<PackedTile> {
        let meta = self.trace.meta();
        let at = (frame.wrapping_sub(meta.first_frame)) as usize * meta.tile_count() as usize + index as usize;
        let slot = self.tiles.get(at);
        if let Some(tile) = slot.and_then(OnceLock::get) {
            return Ok(tile.clone());
        }
        let tile = PathSource::packed_tile(&self.trace, frame, index)?;
        if let Some(slot) = slot {
            let bytes = weight(&tile);
            // Both may be over the limit for a moment; the one that is gives its share back.
            if self.bytes.fetch_add(bytes, Ordering::Relaxed) + bytes > self.limit || slot.set(tile.clone()).is_err() {
                self.bytes.fetch_sub(bytes, Ordering::Relaxed);
            }
        }
        Ok(tile)
    }
}

impl TileSource for TileCache {
    fn meta(&self) -> &Meta {
        self.trace.meta()
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.trace.object_of(triangle)
    }

    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        TileSource::camera(&self.trace, frame)
    }

    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        self.shared_tile(frame, index).map(Arc::unwrap_or_clone)
    }

    fn shared_tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Arc<Tile>> {
        Ok(self.read(frame, index)?.tile)
    }
}

impl PathSource for TileCache {
    fn topology(&self) -> Topology {
        self.trace.topology()
    }

    fn material_of(&self, triangle: u32) -> u32 {
        self.trace.material_of(triangle)
    }

    fn tile_with_paths(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        PathSource::tile_with_paths(&self.trace, frame, index)
    }

    fn packed_tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<PackedTile> {
        self.read(frame, index)
    }

    fn paths(&self, tile: &Tile, packed: &PackedColumn) -> rayreel_formats::Result<TilePaths> {
        PathSource::paths(&self.trace, tile, packed)
    }
}

/// Bytes that a tile takes in memory.
fn weight(PackedTile { tile, packed }: &PackedTile) -> usize {
    size_of::<Tile>()
        + size_of_val(&tile.tree.first[..])
        + size_of_val(&tile.tree.nodes[..])
        + size_of_val(&tile.hits[..])
        + size_of_val(&tile.radiance[..])
        + size_of_val(&tile.paths.steps[..])
        + size_of_val(&tile.paths.spans[..])
        + packed.as_ref().map_or(0, |packed| size_of::<PackedColumn>() + packed.bytes.len())
}
