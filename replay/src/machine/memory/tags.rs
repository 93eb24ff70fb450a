//! The tags of a set-associative cache, and which line of a set makes room.
//!
//! The ways of a set lie side by side in order of rank: the first is the most recently used (LRU) or filled (FIFO), the last is
//! the next to go. With random replacement the order means nothing. Free ways are always last in their set.

use crate::machine::config::Replacement;

/// A way without a line. No address reaches this line number.
const FREE: u64 = u64::MAX;

/// Seed of random replacement: the same for every cache, so that a run is reproducible.
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// A tag array.
#[derive(Clone, Debug)]
pub struct Tags {
    tags: Vec<u64>,
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
        Self {
            tags: vec![FREE; (sets * u64::from(ways)) as usize],
            ways: ways as usize,
            set_mask: sets - 1,
            replacement,
            random: SEED,
        }
    }

    /// Whether `line` is here; a hit refreshes it (LRU).
    #[inline]
    pub fn touch(&mut self, line: u64) -> bool {
        let lru = self.replacement == Replacement::Lru;
        let set = self.set(line);
        if set[0] == line {
            return true;
        }
        let Some(way) = set.iter().position(|&tag| tag == line) else { return false };
        if lru {
            push_front(&mut set[..=way], line);
        }
        true
    }

    /// Whether `line` is here. Changes nothing.
    #[inline]
    pub fn contains(&self, line: u64) -> bool {
        let first = self.first(line);
        self.tags[first..first + self.ways].contains(&line)
    }

    /// Puts `line` in and returns the line that had to leave. A line that is already here counts as used again.
    pub fn fill(&mut self, line: u64) -> Option<u64> {
        if self.touch(line) {
            return None;
        }
        let ways = self.ways;
        let victim = match self.replacement {
            Replacement::Lru | Replacement::Fifo => ways - 1,
            Replacement::Random => self.random_way(line),
        };
        let set = self.set(line);
        let evicted = set[victim];
        push_front(&mut set[..=victim], line);
        (evicted != FREE).then_some(evicted)
    }

    /// Drops `line`; whether it was here.
    pub fn invalidate(&mut self, line: u64) -> bool {
        let set = self.set(line);
        let Some(way) = set.iter().position(|&tag| tag == line) else { return false };
        set.copy_within(way + 1.., way);
        set[set.len() - 1] = FREE;
        true
    }

    #[inline]
    fn first(&self, line: u64) -> usize {
        (line & self.set_mask) as usize * self.ways
    }

    #[inline]
    fn set(&mut self, line: u64) -> &mut [u64] {
        let first = self.first(line);
        &mut self.tags[first..first + self.ways]
    }

    /// A random way of a full set, else a free one. The generator moves only when it decides.
    fn random_way(&mut self, line: u64) -> usize {
        let last = self.first(line) + self.ways - 1;
        if self.tags[last] == FREE {
            return self.ways - 1;
        }
        // xorshift64: full period, and its high bits are good enough to choose a way.
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (((self.random >> 32) * self.ways as u64) >> 32) as usize
    }
}

/// Moves all back by one, over the last, and puts `line` first. A loop: the few ways are moved faster than by a call.
#[inline]
fn push_front(ways: &mut [u64], line: u64) {
    let mut carried = line;
    for way in ways {
        carried = std::mem::replace(way, carried);
    }
}

#[cfg(test)]
#[path = "tags_tests.rs"]
mod tests;
