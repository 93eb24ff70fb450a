//! Threads that traverse by instructions: the processors of machines without a traversal unit (`ti.pipeline = "software"`).

use rayreel_settings::Rule::Integer;
use rayreel_settings::{Rule, settings};

use super::cache::L1;

/// Instructions of a block.
const COUNT: Rule = Integer(0, 1000);
/// Operations a cycle.
const UNITS: Rule = Integer(1, 256);
/// A share.
const PERCENT: Rule = Integer(0, 100);

settings! {
    /// Instructions of a block of code, by class, as one thread executes them.
    #[derive(Copy, Eq)]
    #[serde(deny_unknown_fields)]
    pub struct Block {
        add: u32 = COUNT, "floating-point additions and subtractions";
        multiply: u32 = COUNT, "floating-point multiplications";
        compare: u32 = COUNT, "minima, maxima and comparisons";
        integer: u32 = COUNT, "integer operations, bit operations and branches";
        special: u32 = COUNT, "reciprocals";
        memory: u32 = COUNT, "loads and stores of a word";
        stall_cycles: u32 = COUNT, "a thread by itself waits for its own results", "cycles";
    }

    /// The loop of the traversal, block by block.
    #[derive(Eq)]
    #[serde(deny_unknown_fields)]
    pub struct Code {
        ray: Block, "a ray is taken and set up, and its hit written";
        visit: Block, "an inner node: both boxes, the order of the children, the farther one pushed";
        triangle: Block, "a triangle";
        pop: Block, "a child is taken from the stack and culled or not; or the stack is empty";
        instruction_bytes: u32 = Integer(1, 16), "an instruction", "bytes";
    }

    /// What the operations of kernels are, in percent of them: 100 together.
    #[derive(Eq)]
    #[serde(deny_unknown_fields)]
    pub struct KernelMix {
        add_percent: u32 = PERCENT, "floating-point additions and subtractions", "%";
        multiply_percent: u32 = PERCENT, "floating-point multiplications", "%";
        compare_percent: u32 = PERCENT, "minima, maxima and comparisons", "%";
        integer_percent: u32 = PERCENT, "integer operations, bit operations and branches", "%";
        special_percent: u32 = PERCENT, "reciprocals", "%";
        memory_percent: u32 = PERCENT, "loads and stores of a word", "%";
    }

    /// Functional units that the threads of a processor share.
    #[derive(Eq)]
    #[serde(deny_unknown_fields)]
    pub struct Units {
        add: u32 = UNITS, "floating-point adders", "operations per cycle";
        multiply: u32 = UNITS, "floating-point multipliers", "operations per cycle";
        compare: u32 = UNITS, "units of minima, maxima and comparisons", "operations per cycle";
        integer: u32 = UNITS, "integer units", "operations per cycle";
        special: u32 = UNITS, "units of reciprocals", "operations per cycle";
        memory: u32 = UNITS, "banks of the data cache", "words per cycle";
    }

    /// A processor. It takes the place of a traversal unit: `ti.trv` of them a core, `ti.rays_per_trv` rays each, `ti.trv_l1` for
    /// data.
    #[serde(deny_unknown_fields)]
    pub struct Processor {
        /// `ti.rays_per_trv` over it is the number of warps.
        lanes: u32 = Integer(1, 32), "threads in lockstep, a warp; 1 is MIMD";
        vector: u32 = Integer(1, 4), "components that a floating-point instruction does at a time";
        issue: u32 = Integer(1, 128), "instructions that all warps together issue", "per cycle";
        warp_wait_cycles: u32 = Integer(0, 1000),
            "a ray waits so long for others before its warp starts with lanes that are off", "cycles";
        units: Units, "functional units";
        code: Code, "instructions of the traversal";
        kernel_mix: KernelMix, "instructions of the kernels";
        code_l1: L1, "instruction cache of a processor";
    }
}

impl Block {
    /// Instructions by class: add, multiply, compare, integer, special, memory.
    pub fn counts(&self) -> [u32; 6] {
        [self.add, self.multiply, self.compare, self.integer, self.special, self.memory]
    }
}

impl KernelMix {
    /// Percent by class, in the order of [`Block::counts`].
    pub fn percents(&self) -> [u32; 6] {
        let Self { add_percent, multiply_percent, compare_percent, .. } = self;
        let Self { integer_percent, special_percent, memory_percent, .. } = self;
        [add_percent, multiply_percent, compare_percent, integer_percent, special_percent, memory_percent].map(|p| *p)
    }
}
