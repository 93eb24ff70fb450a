//! What a processor counts beside what a traversal unit does.

use crate::counters::counters;
use crate::memory::CacheCounters;

counters! {
    /// Instructions, and what the warps did in each cycle: every cycle of every warp is in one of the last four.
    pub struct ProcessorCounters {
        warps: "warps", "warps started: of rays, and of items of kernels";
        instructions: "instructions", "instructions issued, one for all lanes of a warp";
        lane_instructions: "instructions", "the same times the lanes at work";
        lanes_off: "instructions", "the same times the lanes that were off";
        add: "operations", "floating-point additions";
        multiply: "operations", "floating-point multiplications";
        compare: "operations", "minima, maxima and comparisons";
        integer: "operations", "integer operations and branches";
        special: "operations", "reciprocals";
        words: "words", "words read and written";
        executing: "warp cycles", "a warp executes, or waits for its own results";
        units: "warp cycles", "a warp waits for functional units that others have";
        memory: "warp cycles", "a warp waits for data or for instructions";
        empty: "warp cycles", "there is nothing in a warp's place";
    }
}

/// What a processor reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProcessorStats {
    /// Instructions and warps.
    pub counters: ProcessorCounters,
    /// The instruction cache.
    pub code_l1: CacheCounters,
}
