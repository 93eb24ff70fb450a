//! The caches.

use rayreel_settings::Rule::{Flag, Integer, Size};
use rayreel_settings::{Bytes, Rule, settings, words};

use super::rules::{DEPTH, SMALL, WAYS};

/// Lines waited for.
const MSHRS: Rule = Integer(1, 256);

words! {
    /// Which line of a set makes room.
    pub enum Replacement {
        /// The least recently used.
        Lru = "lru",
        /// The one filled first.
        Fifo = "fifo",
        /// A random one, from a generator with a fixed seed.
        Random = "random",
    }
}

settings! {
    /// A first-level cache. Non-blocking; reads only.
    #[serde(deny_unknown_fields)]
    pub struct L1 {
        size: Bytes = SMALL, "capacity", "bytes";
        ways: u32 = WAYS, "lines of a set";
        mshrs: u32 = MSHRS, "lines that can be waited for at a time";
        latency_cycles: u32 = DEPTH, "hit latency", "cycles";
        replacement: Replacement = Replacement::RULE, "which line of a set makes room";
    }

    /// The second-level cache, in the clock of the T&I unit.
    #[serde(deny_unknown_fields)]
    pub struct L2 {
        size: Bytes = Size(4 << 10, 64 << 20), "capacity", "bytes";
        ways: u32 = WAYS, "lines of a set";
        banks: u32 = Integer(1, 64), "banks, interleaved by line; each takes one request a cycle";
        queue_entries: u32 = Integer(1, 256), "requests that a bank can queue";
        request_bytes: u32 = Integer(0, 256), "a request on the wires from a core, for energy", "bytes";
        mshrs: u32 = Integer(1, 1024), "lines that can be waited for at a time, all banks";
        latency_cycles: u32 = DEPTH, "hit latency", "cycles";
        replacement: Replacement = Replacement::RULE, "which line of a set makes room";
        inclusive: bool = Flag, "a line that leaves the L2 leaves the L1s too";
        line_bytes: u32 = Integer(16, 256), "line size of all caches", "bytes";
    }
}
