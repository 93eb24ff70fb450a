//! Tiles that several points read, decoded once.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_formats::trace::{PackedColumn, Trace};

use rayreel_machine::work::recorded::TilePaths;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::source::{PackedTile, PathSource, TileSource};

/// A trace with what was read of it before, as far as memory is allowed: tiles, and their paths as operations. What does not fit
/// is decoded each time.
pub struct TileCache {
    trace: Trace,
    /// By frame and tile.
    tiles: Vec<KeptTile>,
    /// How often each is read before it is dropped.
    readers: usize,
    budget: Arc<MemoryBudget>,
    /// Bytes that this trace has of the budget.
    bytes: AtomicUsize,
}

/// What is kept of a tile.
#[derive(Default)]
struct KeptTile {
    tile: Mutex<Kept<PackedTile>>,
    paths: Mutex<Kept<Arc<TilePaths>>>,
}

/// Something that was read, if it is kept.
struct Kept<T> {
    value: Option<T>,
    /// How often it was asked for.
    reads: usize,
}

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self { value: None, reads: 0 }
    }
}

/// Memory that caches share.
#[derive(Debug)]
pub struct MemoryBudget {
    used: AtomicUsize,
    limit: usize,
}

impl MemoryBudget {
    /// About so many bytes.
    pub fn new(limit: usize) -> Arc<Self> {
        Arc::new(Self { used: AtomicUsize::new(0), limit })
    }

    /// Takes so many bytes, if they are free.
    fn take(&self, bytes: usize) -> bool {
        // Two may be over the limit for a moment; the one that is gives its share back.
        let fits = self.used.fetch_add(bytes, Ordering::Relaxed) + bytes <= self.limit;
        if !fits {
            self.give(bytes);
        }
        fits
    }

    fn give(&self, bytes: usize) {
        self.used.fetch_sub(bytes, Ordering::Relaxed);
    }
}

impl TileCache {
    /// Nothing is decoded yet; what will be kept has to find room.
    pub fn new(trace: Trace, budget: &Arc<MemoryBudget>) -> Self {
        let meta = trace.meta();
        // A trace whose table of tiles alone is over the limit keeps none.
        let count = meta.frames as usize * meta.tile_count() as usize;
        let count = if count.saturating_mul(size_of::<KeptTile>()) <= budget.limit { count } else { 0 };
        let tiles = std::iter::repeat_with(KeptTile::default).take(count).collect();
        Self { trace, tiles, readers: usize::MAX, budget: Arc::clone(budget), bytes: AtomicUsize::new(0) }
    }

    /// The same for so many readers who go through the trace side by side: what all of them have read is dropped.
    #[must_use]
    pub fn for_readers(mut self, readers: usize) -> Self {
        self.readers = readers;
        self
    }

    /// The trace.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Where a tile is kept; nowhere if the trace has no such tile, and then the trace says so.
    fn slot(&self, frame: u32, index: u32) -> Option<&KeptTile> {
        let meta = self.trace.meta();
        if index >= meta.tile_count() {
            return None;
        }
        let frame = frame.wrapping_sub(meta.first_frame) as usize;
        self.tiles.get(frame * meta.tile_count() as usize + index as usize)
    }

    fn read(&self, frame: u32, index: u32) -> rayreel_formats::Result<PackedTile> {
        let slot = self.slot(frame, index).map(|kept| &kept.tile);
        self.kept(slot, weight, || PathSource::packed_tile(&self.trace, frame, index))
    }

    /// What stands in `slot`, or else what `make` makes, which is kept if it finds room and someone is still to read it. Who comes while
    /// it is made waits for it.
    fn kept<T: Clone>(
        &self,
        slot: Option<&Mutex<Kept<T>>>,
        weight: impl Fn(&T) -> usize,
        make: impl FnOnce() -> rayreel_formats::Result<T>,
    ) -> rayreel_formats::Result<T> {
        let Some(slot) = slot else { return make() };
        let mut kept = slot.lock().unwrap_or_else(PoisonError::into_inner);
        let known = kept.value.take();
        let was_kept = known.is_some();
        let value = known.map_or_else(make, Ok)?;
        kept.reads += 1;
        if kept.reads < self.readers && (was_kept || self.take(weight(&value))) {
            kept.value = Some(value.clone());
        } else if was_kept {
            self.give(weight(&value));
        }
        Ok(value)
    }

    /// Takes so many bytes of the budget, if they are free.
    fn take(&self, bytes: usize) -> bool {
        let fits = self.budget.take(bytes);
        self.bytes.fetch_add(if fits { bytes } else { 0 }, Ordering::Relaxed);
        fits
    }

    fn give(&self, bytes: usize) {
        self.bytes.fetch_sub(bytes, Ordering::Relaxed);
        self.budget.give(bytes);
    }
}

impl Drop for TileCache {
    fn drop(&mut self) {
        self.budget.give(*self.bytes.get_mut());
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

    fn ray_count(&self, frame: u32, index: u32) -> rayreel_formats::Result<u64> {
        self.trace.ray_count(frame, index)
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

    fn paths(&self, tile: &Tile, packed: &PackedColumn) -> rayreel_formats::Result<Arc<TilePaths>> {
        let slot = self.slot(tile.frame, tile.index).map(|kept| &kept.paths);
        self.kept(slot, |paths| paths.bytes(), || PathSource::paths(&self.trace, tile, packed))
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

#[cfg(test)]
mod tests {
    use super::*;
    use rayreel_formats::Limits;

    fn trace() -> Trace {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../traces/v1_0_cornell.rtrace");
        Trace::open(path.as_ref(), Limits::default()).unwrap()
    }

    fn read(cache: &TileCache) -> (Arc<Tile>, Arc<TilePaths>) {
        let PackedTile { tile, packed } = cache.packed_tile(0, 1).unwrap();
        let paths = cache.paths(&tile, &packed.unwrap()).unwrap();
        (tile, paths)
    }

    #[test]
    fn rays_of_a_tile_are_those_of_its_trees() {
        let cache = TileCache::new(trace(), &MemoryBudget::new(0));
        for index in 0..cache.meta().tile_count() {
            let tile = cache.shared_tile(0, index).unwrap();
            assert_eq!(cache.ray_count(0, index).unwrap(), tile.tree.ray_count());
        }
        let error = cache.ray_count(0, cache.meta().tile_count()).unwrap_err().to_string();
        assert!(error.contains("tile"), "{error}");
    }

    #[test]
    fn what_finds_room_is_decoded_once_and_leaves_with_its_cache() {
        let budget = MemoryBudget::new(1 << 30);
        let cache = TileCache::new(trace(), &budget);
        let (first, again) = (read(&cache), read(&cache));
        assert!(Arc::ptr_eq(&first.0, &again.0) && Arc::ptr_eq(&first.1, &again.1));
        let used = || budget.used.load(Ordering::Relaxed);
        assert!(used() > first.1.bytes());
        let other = TileCache::new(trace(), &budget);
        let (alone, both) = (used(), read(&other));
        assert_eq!(used(), 2 * alone);
        assert_eq!((both.0, both.1.rays()), (first.0, first.1.rays()));
        drop(other);
        assert_eq!(used(), alone);
    }

    #[test]
    fn what_all_have_read_is_dropped() {
        let budget = MemoryBudget::new(1 << 30);
        let cache = TileCache::new(trace(), &budget).for_readers(3);
        let used = || budget.used.load(Ordering::Relaxed);
        let (first, again) = (read(&cache), read(&cache));
        assert!(Arc::ptr_eq(&first.1, &again.1) && used() > first.1.bytes());
        let last = read(&cache);
        assert!(Arc::ptr_eq(&first.1, &last.1));
        assert_eq!(used(), 0);
        // Who comes after them, as for a second pass, gets it made again, and nothing is kept for him.
        let late = read(&cache);
        assert!(!Arc::ptr_eq(&first.1, &late.1) && late.0 == first.0);
        assert_eq!(used(), 0);
        let alone = TileCache::new(trace(), &budget).for_readers(1);
        read(&alone);
        assert_eq!(used(), 0, "nobody else reads it");
    }

    #[test]
    fn who_come_at_once_get_the_same() {
        let cache = TileCache::new(trace(), &MemoryBudget::new(1 << 30));
        let all: Vec<_> = std::thread::scope(|scope| {
            let readers: Vec<_> = (0..4).map(|_| scope.spawn(|| read(&cache))).collect();
            readers.into_iter().map(|reader| reader.join().unwrap()).collect()
        });
        assert!(all.iter().all(|(tile, paths)| Arc::ptr_eq(tile, &all[0].0) && Arc::ptr_eq(paths, &all[0].1)));
    }

    /// It was the first tile of the frame behind it.
    #[test]
    fn a_tile_that_is_not_there_is_an_error() {
        let mut cache = TileCache::new(trace(), &MemoryBudget::new(1 << 30));
        let (frame, count) = (cache.meta().first_frame, cache.meta().tile_count());
        // As if there were such a frame, and its first tile were known.
        let known = cache.packed_tile(frame, 0).unwrap();
        cache.tiles.push(KeptTile { tile: Mutex::new(Kept { value: Some(known), reads: 1 }), ..KeptTile::default() });
        let (found, want) = (cache.tile(frame, count), TileSource::tile(cache.trace(), frame, count));
        assert_eq!(found.unwrap_err().to_string(), want.unwrap_err().to_string());
    }

    #[test]
    fn without_room_all_is_decoded_each_time() {
        let budget = MemoryBudget::new(0);
        let cache = TileCache::new(trace(), &budget);
        let (first, again) = (read(&cache), read(&cache));
        assert!(!Arc::ptr_eq(&first.1, &again.1) && first.0 == again.0);
        assert_eq!(budget.used.load(Ordering::Relaxed), 0);
    }
}
