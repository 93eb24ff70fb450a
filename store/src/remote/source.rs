//! An object as a source of a trace's bytes.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use rayreel_formats::container::{ChunkRecord, Source};

use super::ahead::ReadAhead;
use super::disk::DiskCache;
use super::fetch::Fetch;
use super::memory::{Block, Lookup, MemoryCache};
use crate::traffic::Traffic;

/// Reads from memory, else from disk, else from the object.
#[derive(Debug)]
pub(super) struct RemoteSource<F> {
    object: F,
    size: u64,
    disk: Option<DiskCache>,
    memory: MemoryCache,
    ahead: ReadAhead,
    traffic: Arc<Traffic>,
}

impl<F: Fetch> RemoteSource<F> {
    pub(super) fn new(object: F, size: u64, disk: Option<DiskCache>, traffic: Arc<Traffic>) -> Self {
        Self { object, size, disk, memory: MemoryCache::default(), ahead: ReadAhead::default(), traffic }
    }

    /// Takes in bytes that came by themselves.
    pub(super) fn keep(&self, start: u64, bytes: Vec<u8>) {
        self.memory.keep(Block { start, bytes });
    }

    /// The block that holds `wanted`, which is not empty.
    fn block(&self, wanted: &Range<u64>) -> io::Result<Arc<Block>> {
        let on_disk = self.disk.as_ref().and_then(|disk| disk.find(wanted));
        let on_disk = on_disk.as_ref();
        let extend = |held: &dyn Fn(&Range<u64>) -> bool| match on_disk {
            Some(range) => range.clone(),
            None => self.ahead.extend(wanted.clone(), |range| held(range) || self.is_on_disk(range)),
        };
        let flight = match self.memory.ask(wanted, extend) {
            Lookup::Held(block) => return Ok(block),
            Lookup::ToFetch(flight) => flight,
        };
        let range = flight.range.clone();
        if let Some(bytes) = self.disk.as_ref().and_then(|disk| disk.load(&range)) {
            self.traffic.count_cached(bytes.len() as u64);
            return Ok(self.memory.keep(Block { start: range.start, bytes }));
        }
        let bytes = self.object.fetch(range.clone())?;
        if let Some(disk) = &self.disk {
            disk.store(&range, &bytes);
        }
        Ok(self.memory.keep(Block { start: range.start, bytes }))
    }

    fn is_on_disk(&self, range: &Range<u64>) -> bool {
        self.disk.as_ref().is_some_and(|disk| disk.holds(range))
    }
}

impl<F: Fetch> Source for RemoteSource<F> {
    fn size(&self) -> io::Result<u64> {
        Ok(self.size)
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        let wanted = offset..offset.saturating_add(buffer.len() as u64).min(self.size);
        if wanted.is_empty() {
            return Ok(0);
        }
        let block = self.block(&wanted)?;
        let part = block.part(&wanted);
        let count = part.len().min(buffer.len());
        buffer[..count].copy_from_slice(&part[..count]);
        Ok(count)
    }

    fn announce(&self, offset: u64, len: u64) -> io::Result<()> {
        let wanted = offset..offset.saturating_add(len).min(self.size);
        if wanted.is_empty() { Ok(()) } else { self.block(&wanted).map(|_| ()) }
    }

    fn distrust(&self, offset: u64, len: u64) -> Option<String> {
        let range = offset..offset.saturating_add(len).min(self.size);
        self.memory.forget(&range);
        let cache = self.disk.as_ref().map(|disk| disk.forget(&range).display().to_string());
        let kept = cache.map_or_else(String::new, |cache| format!(", and the cache {cache} does not keep it"));
        Some(format!("fetched twice from the server{kept}"))
    }

    fn layout(&self, chunks: &[ChunkRecord]) {
        self.ahead.layout(chunks);
    }
}
