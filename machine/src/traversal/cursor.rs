//! A ray on its way through its operations, for units that keep a whole stack: what it wants next, triangle by triangle.

use crate::link::RayRef;
use crate::ti::TrvCounters;
use crate::time::TiCycle;
use crate::work::TileWork;
use crate::work::ops::{Op, OpKind};

/// What a ray wants next.
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

impl Want {
    /// It is done.
    pub fn count(self, events: &mut TrvCounters) {
        match self {
            Self::Visit { defers, .. } => {
                events.node_visits += 1;
                events.box_tests += 2;
                events.pushes += u64::from(defers);
            }
            Self::Triangle(_) => events.triangle_tests += 1,
            Self::Pop { culled } => {
                events.stack_operations += 1;
                events.culled += u64::from(culled);
            }
            Self::Nothing => {}
        }
    }
}

/// A ray on its way.
#[derive(Clone, Copy, Debug)]
pub struct Cursor {
    /// The ray.
    pub ray: RayRef,
    /// When it came.
    pub entered: TiCycle,
    /// What it wants next.
    pub want: Want,
    /// Next operation and end, in the operations of the tile.
    at: u32,
    end: u32,
    /// Of the leaf at hand: the next triangle, and how many are left.
    triangle: u32,
    tests: u8,
}

impl Cursor {
    /// A ray that enters; `leaves` counts the leaves that it comes to.
    pub fn new(ray: RayRef, entered: TiCycle, work: &TileWork, leaves: &mut u64) -> Self {
        let found = work.rays[ray.ray as usize];
        let (at, end) = (found.ops_start, found.ops_start + found.ops_len);
        let mut cursor = Self { ray, entered, at, end, triangle: 0, tests: 0, want: Want::Nothing };
        cursor.go_on(&work.ops, leaves);
        cursor
    }

    /// What it wanted is done; `ops` are those of its tile.
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
}
