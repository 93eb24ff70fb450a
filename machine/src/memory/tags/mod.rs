//! The tags of a set-associative cache, and which line of a set makes room.
//!
//! Every way has a stamp: when it was last used (LRU) or filled (FIFO). The lowest of the set is the next to go; a free way has
//! stamp 0. With random replacement the stamps only say which ways are free.

use crate::config::Replacement;

/// A way without a line. No address reaches this line number.
const FREE: u64 = u64::MAX;

/// Seed of random replacement: the same for every cache, so that a run is reproducible.
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// A tag array.
#[derive(Clone, Debug)]
pub struct Tags {
    tags: Vec<u64>,
    stamps: Vec<u64>,
    clock: u64,
    ways: usize,
    set_mask: u64,
    replacement: Replacement,
    random: u64,
}

impl Tags {
    /// A cache of `bytes` in `ways`, with lines of `line_bytes`. Set number: line number modulo the number of sets.
    ///
    /// # Panics
    /// When the number of sets is not a power of two: the configuration was not checked.
    pub fn new(bytes: u64, ways: u32, line_bytes: u32, replacement: Replacement) -> Self {
        let set_bytes = u64::from(ways) * u64::from(line_bytes);
        assert!(set_bytes > 0 && bytes.is_multiple_of(set_bytes), "{bytes} B is not a whole number of sets");
        let sets = bytes / set_bytes;
        assert!(sets.is_power_of_two(), "the number of sets must be a power of two, not {sets}");
        let lines = (sets * u64::from(ways)) as usize;
        Self {
            tags: vec![FREE; lines],
            stamps: vec![0; lines],
            clock: 0,
            ways: ways as usize,
            set_mask: sets - 1,
            replacement,
            random: SEED,
        }
    }

    /// Whether `line` is here; a hit refreshes it (LRU).
    #[inline]
    pub fn touch(&mut self, line: u64) -> bool {
        let Some(way) = self.find(line) else { return false };
        if self.replacement == Replacement::Lru {
            self.clock += 1;
            self.stamps[way] = self.clock;
        }
        true
    }

    /// The place of `line`. All ways are compared: a loop that stops early costs more in mispredictions.
    #[inline]
    fn find(&self, line: u64) -> Option<usize> {
        let first = self.first(line);
        let set = &self.tags[first..first + self.ways];
        let found = set.iter().enumerate().fold(usize::MAX, |found, (way, &tag)| if tag == line { way } else { found });
        (found != usize::MAX).then(|| first + found)
    }

    /// Whether `line` is here. Changes nothing.
    #[inline]
    pub fn contains(&self, line: u64) -> bool {
        self.find(line).is_some()
    }

    /// Puts `line` in and returns the line that had to leave. A line that is already here counts as used again.
    pub fn fill(&mut self, line: u64) -> Option<u64> {
        if self.touch(line) {
            return None;
        }
        let victim = self.victim(line);
        let evicted = std::mem::replace(&mut self.tags[victim], line);
        self.clock += 1;
        self.stamps[victim] = self.clock;
        (evicted != FREE).then_some(evicted)
    }

    /// Drops `line`; whether it was here.
    pub fn invalidate(&mut self, line: u64) -> bool {
        let Some(way) = self.find(line) else { return false };
        (self.tags[way], self.stamps[way]) = (FREE, 0);
        true
    }

    /// The way that makes room for `line`: a free one, or the one with the lowest stamp, or a random one. The generator moves
    /// only when it decides.
    fn victim(&mut self, line: u64) -> usize {
        let first = self.first(line);
        let set = first..first + self.ways;
        let oldest = set.min_by_key(|&way| self.stamps[way]).unwrap_or(first);
        if self.replacement != Replacement::Random || self.tags[oldest] == FREE {
            return oldest;
        }
        // xorshift64: full period, and its high bits are good enough to choose a way.
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        first + (((self.random >> 32) * self.ways as u64) >> 32) as usize
    }

    #[inline]
    fn first(&self, line: u64) -> usize {
        (line & self.set_mask) as usize * self.ways
    }
}

#[cfg(test)]
mod tests;
