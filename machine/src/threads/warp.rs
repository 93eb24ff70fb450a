//! A warp: threads in lockstep. With one lane it is a thread.
//!
//! The loop of a warp of rays: as long as a lane wants a node or a child from its stack, the lanes that want a node visit theirs,
//! then those that want a child take theirs, and so on in turn; then all lanes that have come to a leaf test a triangle each,
//! until none has one left. Lanes that want something else are off meanwhile. (The while-while loop of Aila and Laine 2009.)

use super::program::{Asked, BlockId};
use crate::link::{Job, RayRef};
use crate::time::TiCycle;
use crate::work::TileWork;
use crate::work::layout::{Layout, Region};
use crate::work::ops::{Op, OpKind};

/// What a lane wants next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Want {
    /// A node visit.
    Visit {
        /// The node.
        node: u32,
        /// A child goes on the stack.
        defers: bool,
    },
    /// A test of this triangle.
    Triangle(u32),
    /// A child from the stack; it may be culled.
    Pop {
        /// It is.
        culled: bool,
    },
    /// Nothing: the ray is through.
    Nothing,
}

/// A ray in a lane.
#[derive(Clone, Copy, Debug)]
pub struct Lane {
    /// The ray.
    pub ray: RayRef,
    /// When it came.
    pub entered: TiCycle,
    at: u32,
    end: u32,
    /// Of the leaf at hand.
    triangle: u32,
    tests: u8,
    /// What it wants next.
    pub want: Want,
}

impl Lane {
    /// A ray that enters; `leaves` counts the leaves that it passes.
    pub fn new(ray: RayRef, entered: TiCycle, work: &TileWork, leaves: &mut u64) -> Self {
        let found = work.rays[ray.ray as usize];
        let (at, end) = (found.ops_start, found.ops_start + found.ops_len);
        let mut lane = Self { ray, entered, at, end, triangle: 0, tests: 0, want: Want::Nothing };
        lane.go_on(&work.ops, leaves);
        lane
    }

    /// What it wanted is done.
    pub fn go_on(&mut self, ops: &[Op], leaves: &mut u64) {
        self.want = loop {
            if self.tests > 0 {
                (self.tests, self.triangle) = (self.tests - 1, self.triangle + 1);
                break Want::Triangle(self.triangle - 1);
            }
            if self.at == self.end {
                break Want::Nothing;
            }
            let op = ops[self.at as usize];
            self.at += 1;
            match op.kind() {
                OpKind::Visit { node, defers } => break Want::Visit { node, defers },
                OpKind::Leaf { triangle, tests } => {
                    *leaves += 1;
                    (self.triangle, self.tests) = (triangle, tests);
                }
                OpKind::Pop { .. } | OpKind::End => break Want::Pop { culled: false },
                OpKind::Cull { .. } => break Want::Pop { culled: true },
            }
        };
    }

    /// The block that does what it wants.
    fn block(&self) -> Option<BlockId> {
        match self.want {
            Want::Visit { .. } => Some(BlockId::Visit),
            Want::Triangle(_) => Some(BlockId::Triangle),
            Want::Pop { .. } => Some(BlockId::Pop),
            Want::Nothing => None,
        }
    }

    /// Whether it takes part in a block.
    pub fn is_in(&self, block: BlockId) -> bool {
        block == BlockId::Ray || self.block() == Some(block)
    }
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
    pub lanes: Vec<Lane>,
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
        order.into_iter().find(|&block| self.lanes.iter().any(|lane| lane.is_in(block)))
    }

    /// Appends the lines that the lanes of a block read, each once.
    pub fn data(&self, block: BlockId, layout: &Layout, into: &mut Vec<(u64, Region)>) {
        for lane in self.lanes.iter().filter(|lane| lane.is_in(block)) {
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
