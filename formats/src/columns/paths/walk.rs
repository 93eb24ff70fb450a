//! A path on its way through the tree.

use super::labels::{Cell, NeighbourLabels};

/// A ray of a stream.
#[derive(Clone, Copy)]
pub(super) struct RayPlace {
    /// Its sample in the tile.
    pub sample: u32,
    /// Its number in ray order.
    pub ray: u32,
    /// A shadow ray: it ends at the first hit.
    pub any_hit: bool,
}

/// A path that was coded; that of a ray that has a neighbour's path is the neighbour's.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CodedPath {
    /// Its number, under which its labels are kept; 0 for no path.
    pub number: u32,
    /// The ray that it was coded for.
    pub ray: u32,
}

/// How a path was coded.
pub(super) enum Coded {
    /// It is that of this ray.
    Like(u32),
    /// By so many steps.
    Steps(u32),
}

/// A child put on the stack: the slot of the node that put it there, which child, and what the neighbours did at that node.
#[derive(Clone, Copy, Default)]
pub(super) struct StackEntry {
    /// The slot, and in the lowest bit the side.
    place: u32,
    /// What the neighbours did.
    pub around: NeighbourLabels,
}

impl StackEntry {
    #[inline(always)]
    pub fn new(slot: u32, side: u8, around: NeighbourLabels) -> Self {
        Self { place: slot << 1 | u32::from(side), around }
    }

    /// The slot of the node.
    #[inline(always)]
    pub fn slot(self) -> u32 {
        self.place >> 1
    }

    /// Which child: 0 the left one, 1 the right one.
    #[inline(always)]
    pub fn side(self) -> u8 {
        (self.place & 1) as u8
    }
}

/// A path on its way through the tree.
pub(super) struct PathWalk<'a, S> {
    /// A shadow ray: it ends at the first hit.
    pub any_hit: bool,
    /// Where the path's labels go.
    pub path: Cell,
    /// Where the neighbours' labels are.
    pub cells: &'a [Cell; 4],
    /// Steps still to be encoded.
    pub given: std::slice::Iter<'a, u8>,
    /// Where steps go.
    pub sink: &'a mut S,
    /// Steps so far.
    pub steps: u32,
    /// Number of children put aside.
    pub top: usize,
    /// Something was hit.
    pub hit: bool,
    /// Label of the node visited last.
    pub last: u8,
}
