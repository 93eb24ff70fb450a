//! What a block of code asks of a processor: instructions, places of functional units, operations; and where code lies.

use crate::config::{Block, MachineConfig};
use crate::work::layout::{Layout, Lines, Region};

/// Classes of instructions, in the order of [`Block`]: add, multiply, compare, integer, special, memory.
pub const CLASSES: usize = 6;
/// Of these the first three are floating-point instructions, which may do several components at a time.
const VECTOR: usize = 3;
/// Reciprocals: one lane after the other, and none for lanes that are off.
const SPECIAL: usize = 4;

/// Something for each class of instructions.
pub type ByClass = [u64; CLASSES];

/// A block of the traversal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockId {
    /// A ray is taken and set up.
    Ray = 0,
    /// An inner node.
    Visit = 1,
    /// A triangle.
    Triangle = 2,
    /// A child is taken from the stack.
    Pop = 3,
}

/// What a block asks of a processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// Instructions that a warp issues.
    pub instructions: u64,
    /// Cycles of a warp that is alone.
    pub cycles: u64,
    /// Places in functional units that a warp takes.
    pub places: ByClass,
    /// Operations that its lanes do.
    pub operations: ByClass,
    /// Instructions times lanes at work.
    pub lane_instructions: u64,
}

/// The traversal as instructions.
#[derive(Clone, Debug)]
pub struct Program {
    blocks: [Block; 4],
    mix: ByClass,
    lanes: u64,
    vector: u64,
    load_cycles: u64,
    code: [Lines; 4],
}

fn counts(block: &Block) -> ByClass {
    block.counts().map(u64::from)
}

/// The blocks of the traversal, in order of [`BlockId`].
fn blocks(config: &MachineConfig) -> [Block; 4] {
    let code = &config.processor.code;
    [code.ray, code.visit, code.triangle, code.pop]
}

impl Program {
    /// That of a machine.
    pub fn new(config: &MachineConfig, layout: &Layout) -> Self {
        let processor = &config.processor;
        let mut code = CodeLayout::new(config, layout);
        Self {
            blocks: blocks(config),
            mix: processor.kernel_mix.percents().map(u64::from),
            lanes: processor.lanes.into(),
            vector: processor.vector.into(),
            load_cycles: config.ti.trv_l1.latency_cycles.into(),
            code: blocks(config).map(|block| code.next(counts(&block).iter().sum())),
        }
    }

    /// The lines of a block's code.
    pub fn code(&self, block: BlockId) -> Lines {
        self.code[block as usize]
    }

    /// What a warp of which `active` lanes execute a block asks.
    pub fn block(&self, block: BlockId, active: u64) -> Asked {
        let Block { stall_cycles, .. } = self.blocks[block as usize];
        let counts = counts(&self.blocks[block as usize]);
        self.asked(counts, counts.map(|count| count * active), active, stall_cycles.into())
    }

    /// What a warp asks whose lanes execute a kernel: the longest of them so many operations, all together so many.
    pub fn kernel(&self, longest: u64, all: u64, active: u64) -> Asked {
        self.asked(self.mixed(longest), self.mixed(all), active, 0)
    }

    /// Operations of a kernel by class; what does not divide is integer.
    fn mixed(&self, operations: u64) -> ByClass {
        let mut mixed = self.mix.map(|percent| operations * percent / 100);
        mixed[3] += operations - mixed.iter().sum::<u64>();
        mixed
    }

    fn asked(&self, counts: ByClass, operations: ByClass, active: u64, stall_cycles: u64) -> Asked {
        let (mut instructions, mut places) = (0, [0; CLASSES]);
        for (class, count) in counts.into_iter().enumerate() {
            let components = if class < VECTOR { self.vector } else { 1 };
            let issued = count.div_ceil(components);
            let lanes = if class == SPECIAL { active } else { self.lanes };
            instructions += issued;
            places[class] = issued * components * lanes;
        }
        let loads = if counts[CLASSES - 1] > 0 { self.load_cycles } else { 0 };
        let cycles = (instructions + stall_cycles + loads).max(1);
        Asked { instructions, cycles, places, operations, lane_instructions: instructions * active }
    }
}

/// Code in the order in which it is asked for, densely: the traversal first.
#[derive(Clone, Debug)]
pub struct CodeLayout {
    layout: Layout,
    instruction_bytes: u64,
    at: u64,
}

impl CodeLayout {
    /// Nothing is there yet.
    pub fn new(config: &MachineConfig, layout: &Layout) -> Self {
        let instruction_bytes = config.processor.code.instruction_bytes.into();
        Self { layout: *layout, instruction_bytes, at: Region::Code.base() }
    }

    /// The same behind the traversal.
    pub fn behind_traversal(config: &MachineConfig, layout: &Layout) -> Self {
        let mut code = Self::new(config, layout);
        blocks(config).iter().for_each(|block| {
            code.next(counts(block).iter().sum());
        });
        code
    }

    /// The lines of the next `instructions`.
    pub fn next(&mut self, instructions: u64) -> Lines {
        let bytes = instructions * self.instruction_bytes;
        let lines = self.layout.lines(self.at, bytes);
        self.at += bytes;
        lines
    }
}
