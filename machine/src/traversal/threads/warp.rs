//! A warp: threads in lockstep. With one lane it is a thread.
//!
//! The loop of a warp of rays: as long as a lane wants a node or a child from its stack, the lanes that want a node visit theirs,
//! then those that want a child take theirs, and so on in turn; then all lanes that have come to a leaf test a triangle each,
//! until none has one left. Lanes that want something else are off meanwhile. (The while-while loop of Aila and Laine 2009.)

use super::program::{Asked, BlockId};
use crate::link::Job;
use crate::time::TiCycle;
use crate::traversal::cursor::{Cursor, Want};
use crate::work::layout::{Layout, Region};

/// The block that does what a ray wants.
fn block_of(lane: &Cursor) -> Option<BlockId> {
    match lane.want {
        Want::Visit { .. } => Some(BlockId::Visit),
        Want::Triangle(_) => Some(BlockId::Triangle),
        Want::Pop { .. } => Some(BlockId::Pop),
        Want::Nothing => None,
    }
}

/// Whether a lane takes part in a block.
pub fn is_in(lane: &Cursor, block: BlockId) -> bool {
    block == BlockId::Ray || block_of(lane) == Some(block)
}

/// What a warp does.
#[derive(Clone, Debug)]
pub enum Task {
    /// Nothing.
    None,
    /// It takes rays through the tree, and is at a block.
    Rays(BlockId),
    /// It executes items.
    Items(Job),
}

/// What a warp's cycles are spent on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// There is nothing in its place.
    Empty,
    /// It waits for lines since a cycle.
    Waits(TiCycle),
    /// It executes since a cycle: alone it would be done at the second one, and it is at the third.
    Executes(TiCycle, TiCycle, TiCycle),
}

/// A warp.
#[derive(Clone, Debug)]
pub struct Warp {
    /// What it does.
    pub task: Task,
    /// Its rays.
    pub lanes: Vec<Cursor>,
    /// What its cycles are spent on.
    pub state: State,
    /// Lines that have not come.
    pub missing: u32,
    /// What the block at hand asks for.
    pub asked: Option<Asked>,
}

impl Warp {
    /// An empty place.
    pub fn new() -> Self {
        Self { task: Task::None, lanes: Vec::new(), state: State::Empty, missing: 0, asked: None }
    }

    /// The block that comes after `block`; nothing where all rays are through.
    pub fn block_after(&self, block: BlockId) -> Option<BlockId> {
        let order = match block {
            BlockId::Ray | BlockId::Pop => [BlockId::Visit, BlockId::Pop, BlockId::Triangle],
            BlockId::Visit => [BlockId::Pop, BlockId::Visit, BlockId::Triangle],
            BlockId::Triangle => [BlockId::Triangle, BlockId::Visit, BlockId::Pop],
        };
        order.into_iter().find(|&block| self.lanes.iter().any(|lane| is_in(lane, block)))
    }

    /// Appends the lines that the lanes of a block read, each once.
    pub fn data(&self, block: BlockId, layout: &Layout, into: &mut Vec<(u64, Region)>) {
        for lane in self.lanes.iter().filter(|lane| is_in(lane, block)) {
            let (lines, region) = match (block, lane.want) {
                (BlockId::Visit, Want::Visit { node, .. }) => (layout.node(node), Region::Node),
                (BlockId::Triangle, Want::Triangle(triangle)) => (layout.triangle(triangle), Region::Triangle),
                _ => continue,
            };
            for line in lines.first..=lines.last {
                if !into.contains(&(line, region)) {
                    into.push((line, region));
                }
            }
        }
    }
}
