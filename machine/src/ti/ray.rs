//! A ray inside a traversal unit: its next operation and the state of its short stack.
//!
//! What a ray does was decided when it was recorded; the machine decides when. The stack's contents are in the operations, so
//! only its fill is kept: how many children are deferred, and how many of them, the uppermost, the short stack still holds. A
//! pop that finds none of them walks down again from the root (restart trail, US 9,495,792): every inner node on the way to
//! the one that deferred the child is visited again, which puts the other deferred children back and leads to the lost one.

use crate::link::RayRef;
use crate::work::ops::{Op, OpKind};
use crate::work::topology::Topology;
use crate::work::{RayWork, TileWork};

/// No node.
const NONE: u32 = u32::MAX;

/// The place of a ray in a traversal unit. A core has hundreds of them: it is small.
#[derive(Clone, Copy, Debug)]
pub struct RaySlot {
    /// The ray.
    pub ray: RayRef,
    /// The next operation, and the end, in the operations of the tile.
    at: u32,
    end: u32,
    /// The next operation, read ahead: it was written by another thread, or is far away by now.
    next: Op,
    /// The next triangle of the leaf at hand; or of the stack operation at hand the node that deferred the child, [`NONE`] where
    /// the stack is empty.
    target: u32,
    /// Deferred children.
    deferred: u8,
    /// Uppermost deferred children that the short stack holds.
    held: u8,
    /// The node visit at hand defers a child.
    defers: bool,
    /// It walks down again.
    restarting: bool,
    /// Passes left of the node visit at hand, for one box a cycle.
    pub passes: u8,
    /// Triangles of the leaf at hand still to be tested.
    pub tests: u8,
}

/// Nodes still to be visited on a walk down again, the next one last; empty otherwise.
pub type Trail = Vec<u32>;

/// What a stack operation found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Popped {
    /// Nothing: the ray ends.
    Empty,
    /// The child that was deferred last.
    Held,
    /// The short stack has lost it: the walk down again begins at the root.
    Lost,
}

impl Default for RaySlot {
    fn default() -> Self {
        Self {
            ray: RayRef { slot: 0, ray: 0 },
            at: 0,
            end: 0,
            next: Op::END,
            target: NONE,
            deferred: 0,
            held: 0,
            defers: false,
            restarting: false,
            passes: 0,
            tests: 0,
        }
    }
}

impl RaySlot {
    /// A ray enters.
    pub fn enter(&mut self, ray: RayRef, work: &TileWork) {
        let RayWork { ops_start, ops_len, .. } = work.rays[ray.ray as usize];
        self.ray = ray;
        (self.at, self.end) = (ops_start, ops_start + ops_len);
        (self.deferred, self.held, self.tests) = (0, 0, 0);
        // The operations were written by another thread. Reading one of each line of the host's cache now lets the misses
        // overlap, instead of one after the other when the ray gets there.
        let path = &work.ops[self.at as usize..self.end as usize];
        std::hint::black_box(path.iter().step_by(16).fold(0, |all, op| all ^ op.bits()));
        self.next = path.first().copied().unwrap_or(Op::END);
    }

    /// The next operation, which becomes the one at hand; `None` when the ray is done.
    #[inline]
    pub fn next(&mut self, work: &TileWork) -> Option<OpKind> {
        if self.at == self.end {
            return None;
        }
        let kind = self.next.kind();
        self.at += 1;
        // Behind the last operation of a ray lie those of another: nobody looks at them.
        self.next = work.ops.get(self.at as usize).copied().unwrap_or(Op::END);
        match kind {
            OpKind::Visit { defers, .. } => self.defers = defers,
            OpKind::Leaf { triangle, tests } => (self.target, self.tests) = (triangle, tests),
            OpKind::Pop { node } | OpKind::Cull { node } => self.target = node,
            OpKind::End => self.target = NONE,
        }
        Some(kind)
    }

    /// The triangle of the leaf at hand that is tested next.
    #[inline]
    pub fn triangle(&self) -> u32 {
        self.target
    }

    /// A triangle of the leaf at hand was tested.
    #[inline]
    pub fn tested(&mut self) {
        self.tests -= 1;
        self.target += 1;
    }

    /// Whether the visit at hand is one of a walk down again.
    #[inline]
    pub fn restarting(&self) -> bool {
        self.restarting
    }

    /// A node visit is complete; returns whether it pushed a child. The short stack holds `short` of them.
    #[inline]
    pub fn visited(&mut self, short: u8) -> bool {
        if self.defers {
            self.deferred += 1;
            self.held = (self.held + 1).min(short);
        }
        self.defers
    }

    /// A node of a walk down again is visited. `Ok` is the next node of the walk; at its end, `Err` says how many children
    /// were pushed again on the way.
    pub fn visited_again(&mut self, trail: &mut Trail, short: u8) -> Result<u32, u8> {
        trail.pop();
        if let Some(&next) = trail.last() {
            return Ok(next);
        }
        // The lost child stands uppermost, and this visit leads to it without a pop.
        self.restarting = false;
        self.deferred -= 1;
        self.held = self.deferred.min(short);
        Err(self.deferred)
    }

    /// A stack operation is complete.
    #[inline]
    pub fn popped(&mut self) -> Popped {
        if self.target == NONE {
            return Popped::Empty;
        }
        if self.held == 0 {
            return Popped::Lost;
        }
        self.held -= 1;
        self.deferred -= 1;
        Popped::Held
    }

    /// Begins the walk down again to the child that was lost, along `trail`; gives the first node of it.
    #[cold]
    pub fn restart(&mut self, trail: &mut Trail, tree: &Topology) -> u32 {
        let mut node = self.target;
        self.restarting = true;
        trail.push(node);
        while node != 0 {
            node = tree.parents[node as usize];
            trail.push(node);
        }
        node
    }
}
