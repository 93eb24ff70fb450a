//! A ray's way through the tree as the machine needs it: one word an operation, with the node or triangle it is about.
//!
//! A traversal unit that meets these in order never looks at the tree: what a node visit leads to is the next operation.
//! They are made once, where paths are checked, off the simulator's thread.

/// One operation of a ray.
///
/// ```text
/// bit 31  1: leaf, bits 30..28 tests, bits 27..0 first triangle
///         0: bits 30..29 kind; bit 28 of a visit: a child is deferred; bits 27..0 node
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Op(u32);

/// What an operation adds to the counts of its ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tally {
    /// 1 for a node visit.
    pub visits: u32,
    /// Triangles tested.
    pub tests: u32,
    /// 1 where a child goes on the stack.
    pub pushes: u32,
    /// 1 where a child is taken from the stack and visited.
    pub pops: u32,
    /// 1 where a child is taken from the stack and dropped.
    pub culled: u32,
}

/// What an operation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpKind {
    /// Both boxes of an inner node are tested. With `defers` the farther child goes on the stack.
    Visit {
        /// The node.
        node: u32,
        /// A child goes on the stack.
        defers: bool,
    },
    /// Triangles of a leaf are tested.
    Leaf {
        /// The first of them.
        triangle: u32,
        /// How many.
        tests: u8,
    },
    /// A child is taken from the stack.
    Pop {
        /// The node that deferred it.
        node: u32,
    },
    /// A child is taken from the stack and lies behind the closest hit.
    Cull {
        /// The node that deferred it.
        node: u32,
    },
    /// The stack is found empty: the ray ends.
    End,
}

const LEAF: u32 = 1 << 31;
const DEFERS: u32 = 1 << 28;
const INDEX: u32 = (1 << 28) - 1;
const POP: u32 = 1 << 29;
const CULL: u32 = 2 << 29;
const END: u32 = 3 << 29;

impl Op {
    /// A node visit.
    #[inline]
    pub fn visit(node: u32, defers: bool) -> Self {
        debug_assert!(node <= INDEX);
        Self(node | u32::from(defers) << 28)
    }

    /// The tests of a leaf.
    #[inline]
    pub fn leaf(triangle: u32, tests: u32) -> Self {
        debug_assert!(triangle <= INDEX && tests <= 7);
        Self(LEAF | tests << 28 | triangle)
    }

    /// A pop of a child that `node` deferred.
    #[inline]
    pub fn pop(node: u32, culled: bool) -> Self {
        debug_assert!(node <= INDEX);
        Self(node | if culled { CULL } else { POP })
    }

    /// The end of a ray whose stack is empty.
    pub const END: Self = Self(END);

    /// The word.
    #[inline]
    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    /// What it adds to the counts of its ray.
    #[inline(always)]
    pub(crate) fn tally(self) -> Tally {
        let kind = self.0 >> 28;
        let is = |first: u32, last: u32| u32::from(kind >= first && kind <= last);
        let [visit, defers, pop, cull, leaf] = [0, DEFERS, POP, CULL, LEAF].map(|bits| bits >> 28);
        Tally {
            visits: is(visit, defers),
            tests: is(leaf, 15) * (kind & 7),
            pushes: is(defers, defers),
            pops: is(pop, pop),
            culled: is(cull, cull),
        }
    }

    /// What it is.
    #[inline]
    pub fn kind(self) -> OpKind {
        let index = self.0 & INDEX;
        if self.0 & LEAF != 0 {
            return OpKind::Leaf { triangle: index, tests: (self.0 >> 28 & 7) as u8 };
        }
        match self.0 & END {
            0 => OpKind::Visit { node: index, defers: self.0 & DEFERS != 0 },
            POP => OpKind::Pop { node: index },
            CULL => OpKind::Cull { node: index },
            _ => OpKind::End,
        }
    }
}

impl std::fmt::Debug for Op {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.kind().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_trip() {
        let top = INDEX;
        let kinds = [
            (Op::visit(top, true), OpKind::Visit { node: top, defers: true }),
            (Op::visit(0, false), OpKind::Visit { node: 0, defers: false }),
            (Op::leaf(top, 4), OpKind::Leaf { triangle: top, tests: 4 }),
            (Op::leaf(0, 0), OpKind::Leaf { triangle: 0, tests: 0 }),
            (Op::pop(top, false), OpKind::Pop { node: top }),
            (Op::pop(0, true), OpKind::Cull { node: 0 }),
            (Op::END, OpKind::End),
        ];
        for (op, kind) in kinds {
            assert_eq!(op.kind(), kind);
            let [visits, tests, pushes, pops, culled] = match kind {
                OpKind::Visit { defers, .. } => [1, 0, u32::from(defers), 0, 0],
                OpKind::Leaf { tests, .. } => [0, u32::from(tests), 0, 0, 0],
                OpKind::Pop { .. } => [0, 0, 0, 1, 0],
                OpKind::Cull { .. } => [0, 0, 0, 0, 1],
                OpKind::End => [0; 5],
            };
            assert_eq!(op.tally(), Tally { visits, tests, pushes, pops, culled });
        }
    }
}
