//! The tags of a set-associative cache, and which line of a set makes room.
//!
//! The oldest line of a set is the next to go: the one that was used (LRU) or filled (FIFO) longest ago, and before it any free
//! way.

mod sets;

use crate::config::Replacement;
use crate::work::layout::Region;
use sets::{Sets, Tag};

/// Seed of random replacement: the same for every cache, so that a run is reproducible.
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// Tags of as many bits as are needed. A tag is a line number without the bits that are the number of its set.
#[derive(Clone, Debug)]
enum Width {
    Narrow(Sets<u32>),
    Wide(Sets<u64>),
}

macro_rules! in_width {
    ($sets:expr, $name:ident => $what:expr) => {
        match $sets {
            Width::Narrow($name) => $what,
            Width::Wide($name) => $what,
        }
    };
}

/// A tag array.
#[derive(Clone, Debug)]
pub struct Tags {
    sets: Width,
    ways: usize,
    set_bits: u32,
    set_mask: u64,
    replacement: Replacement,
    /// Four ways and LRU.
    is_usual: bool,
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
        let (set_bits, ways) = (sets.trailing_zeros(), ways as usize);
        let last_tag = (Region::END / u64::from(line_bytes)) >> set_bits;
        let sets = if last_tag < u64::from(u32::FREE) {
            Width::Narrow(Sets::new(sets as usize, ways))
        } else {
            Width::Wide(Sets::new(sets as usize, ways))
        };
        Self {
            sets,
            ways,
            set_bits,
            set_mask: (1 << set_bits) - 1,
            replacement,
            is_usual: ways == 4 && replacement == Replacement::Lru,
            random: SEED,
        }
    }

    /// The number of a line's set, and its tag.
    #[inline]
    fn place(&self, line: u64) -> (usize, u64) {
        ((line & self.set_mask) as usize, line >> self.set_bits)
    }

    /// Whether `line` is here; a hit refreshes it (LRU).
    #[inline(always)]
    pub fn touch(&mut self, line: u64) -> bool {
        let (set, tag) = self.place(line);
        match &mut self.sets {
            // What most L1s are, which nearly all lookups go to.
            Width::Narrow(sets) if self.is_usual => sets.touch_ways::<4>(set, Tag::new(tag)),
            _ => self.touch_any(line),
        }
    }

    #[inline(never)]
    fn touch_any(&mut self, line: u64) -> bool {
        if self.replacement != Replacement::Lru {
            return self.contains(line);
        }
        let (set, tag) = self.place(line);
        in_width!(&mut self.sets, sets => sets.touch(set, Tag::new(tag)))
    }

    /// Whether `line` is here. Changes nothing.
    #[inline]
    pub fn contains(&self, line: u64) -> bool {
        let (set, tag) = self.place(line);
        in_width!(&self.sets, sets => sets.contains(set, Tag::new(tag)))
    }

    /// Puts `line` in, which is not here, and returns the line that had to leave.
    pub fn insert(&mut self, line: u64) -> Option<u64> {
        debug_assert!(!self.contains(line), "a line comes once");
        let (set, tag) = self.place(line);
        let way = if self.replacement == Replacement::Random { Some(self.random_way(set)) } else { None };
        let evicted = in_width!(&mut self.sets, sets => match way {
            Some(way) => sets.put(set, way, Tag::new(tag)).tag(),
            None => sets.push(set, Tag::new(tag)).tag(),
        });
        evicted.map(|tag| tag << self.set_bits | set as u64)
    }

    /// Drops `line`; whether it was here.
    pub fn invalidate(&mut self, line: u64) -> bool {
        let (set, tag) = self.place(line);
        let ordered = self.replacement != Replacement::Random;
        in_width!(&mut self.sets, sets => sets.remove(set, Tag::new(tag), ordered))
    }

    /// The first free way of `set`, or a random one. The generator moves only when it decides.
    fn random_way(&mut self, set: usize) -> usize {
        if let Some(free) = in_width!(&self.sets, sets => sets.free_way(set)) {
            return free;
        }
        // xorshift64: full period, and its high bits are good enough to choose a way.
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (((self.random >> 32) * self.ways as u64) >> 32) as usize
    }
}

#[cfg(test)]
mod tests;
