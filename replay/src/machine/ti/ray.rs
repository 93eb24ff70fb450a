//! A ray inside a traversal unit: where it is in the tree, what its recorded path says next, its stack.
//!
//! The recorded path decides every outcome; the machine decides only when. The logical stack always holds all deferred
//! children; the hardware's short stack holds the uppermost of them, and a pop that finds it empty while children are deferred
//! walks down again from the root (restart trail, US 9,495,792).

use rayreel_formats::bvh::{Child, MAX_TREE_DEPTH};
use rayreel_formats::tile::{RayKind, step};

use crate::machine::link::RayRef;
use crate::machine::work::TileWork;
use crate::machine::work::topology::Topology;

/// A deferred child and the node at which it was deferred.
#[derive(Clone, Copy, Debug)]
struct Deferred {
    child: Child,
    node: u32,
}

/// What a ray needs next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// A visit of this inner node.
    Inner(u32),
    /// The triangles of its leaf.
    Leaf,
    /// A pop.
    Pop,
    /// Nothing: its hit is known.
    Done,
}

/// The place of a ray in a traversal unit.
#[derive(Clone, Debug)]
pub struct RaySlot {
    /// The ray.
    pub ray: RayRef,
    kind: RayKind,
    /// Next step and end of the path, in the steps of the tile.
    at: u32,
    end: u32,
    current: Child,
    stack: Box<[Deferred; MAX_TREE_DEPTH]>,
    top: u8,
    /// Uppermost entries that the short stack still holds.
    held: u8,
    /// Nodes still to be visited on a walk down again, the next one last.
    trail: Vec<u32>,
    /// Passes left of this node visit, for one box a cycle.
    pub passes: u8,
    /// Triangles of the leaf still to be tested: the path says how many.
    pub tests: u8,
    /// The next of them.
    pub triangle: u32,
}

/// What a stack operation did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Popped {
    /// The stack was empty.
    Empty,
    /// A child to visit.
    Child,
    /// A child that lies behind the closest hit.
    Culled,
    /// The short stack had lost the child: the nodes down to it are visited again.
    Restart,
}

impl Default for RaySlot {
    fn default() -> Self {
        let none = Deferred { child: Child::leaf(0, 0), node: 0 };
        Self {
            ray: RayRef { slot: 0, ray: 0 },
            kind: RayKind::Primary,
            at: 0,
            end: 0,
            current: Child::inner(0),
            stack: Box::new([none; MAX_TREE_DEPTH]),
            top: 0,
            held: 0,
            trail: Vec::with_capacity(MAX_TREE_DEPTH),
            passes: 0,
            tests: 0,
            triangle: 0,
        }
    }
}

impl RaySlot {
    /// A ray enters: it begins at the root.
    pub fn enter(&mut self, ray: RayRef, work: &TileWork) {
        let own = &work.rays[ray.ray as usize];
        self.ray = ray;
        self.kind = own.kind;
        (self.at, self.end) = (own.steps_start, own.steps_start + own.steps_len);
        self.current = Child::inner(0);
        (self.top, self.held) = (0, 0);
        self.trail.clear();
    }

    /// A node visit is complete. Returns what comes next and whether a child was deferred.
    #[inline]
    pub fn visited(&mut self, work: &TileWork, tree: &Topology, short: u8) -> (Next, bool) {
        if self.trail.pop().is_some() {
            return (self.descend_again(work, short), false);
        }
        let node = self.current.node() as u32;
        let [left, right] = tree.children[node as usize];
        let code = work.steps[self.at as usize];
        self.at += 1;
        let (next, deferred) = match code {
            step::LEFT => (left, None),
            step::RIGHT => (right, None),
            step::LEFT_FIRST => (left, Some(right)),
            step::RIGHT_FIRST => (right, Some(left)),
            _ => return (Next::Pop, false),
        };
        if let Some(child) = deferred {
            self.stack[self.top as usize] = Deferred { child, node };
            self.top += 1;
            self.held = (self.held + 1).min(short);
        }
        (self.go(next), deferred.is_some())
    }

    /// The tests of the leaf at hand: how many triangles, the first of them. Sets what the leaf leads to.
    #[inline]
    pub fn enter_leaf(&mut self, work: &TileWork) {
        let steps = &work.steps[self.at as usize..self.end as usize];
        let mut tests = self.current.count().min(steps.len());
        if self.kind == RayKind::Shadow
            && let Some(hit) = steps[..tests].iter().position(|&s| s == step::HIT)
        {
            tests = hit + 1;
        }
        self.tests = tests as u8;
        self.triangle = self.current.first() as u32;
        self.at += tests as u32;
    }

    /// The tests of the leaf are done.
    #[inline]
    pub fn left_leaf(&self, work: &TileWork) -> Next {
        let any_hit = self.kind == RayKind::Shadow
            && self.at == self.end
            && self.at > 0
            && self.current.count() > 0
            && work.steps[self.at as usize - 1] == step::HIT;
        if any_hit { Next::Done } else { Next::Pop }
    }

    /// A stack operation is complete.
    #[inline]
    pub fn popped(&mut self, work: &TileWork, tree: &Topology) -> (Next, Popped) {
        if self.top == 0 {
            return (Next::Done, Popped::Empty);
        }
        if self.held == 0 {
            let mut node = self.stack[self.top as usize - 1].node;
            self.trail.push(node);
            while node != 0 {
                node = tree.parents[node as usize];
                self.trail.push(node);
            }
            return (Next::Inner(0), Popped::Restart);
        }
        self.held -= 1;
        self.take(work)
    }

    /// Deferred children.
    pub fn deferred(&self) -> u8 {
        self.top
    }

    /// On a walk down again.
    #[inline]
    pub fn restarting(&self) -> bool {
        !self.trail.is_empty()
    }

    /// One node of the walk down again is visited.
    fn descend_again(&mut self, work: &TileWork, short: u8) -> Next {
        if let Some(&next) = self.trail.last() {
            return Next::Inner(next);
        }
        // At the node where the lost child hangs. Every child deferred on the way was pushed again; the lost one stands
        // uppermost, and this visit leads to it without a pop.
        self.held = (self.top - 1).min(short);
        self.take(work).0
    }

    fn take(&mut self, work: &TileWork) -> (Next, Popped) {
        self.top -= 1;
        let code = work.steps[self.at as usize];
        self.at += 1;
        if code == step::CULLED {
            return (Next::Pop, Popped::Culled);
        }
        let child = self.stack[self.top as usize].child;
        (self.go(child), Popped::Child)
    }

    #[inline]
    fn go(&mut self, child: Child) -> Next {
        self.current = child;
        if child.is_leaf() { Next::Leaf } else { Next::Inner(child.node() as u32) }
    }
}
