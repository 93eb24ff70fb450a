//! The part of the tree that the rays of a tile have met: small, and dense in memory, as the whole tree is not.

use super::labels::Labels;
use super::topology::BvhTopology;
use crate::bvh::Child;

/// An inner node that was met.
#[derive(Clone, Copy, Debug)]
pub(super) struct MetNode {
    children: [Child; 2],
    /// The slots of the children; 0 where they were not met.
    slots: [u32; 2],
    /// Its number in the tree.
    pub number: u32,
}

/// A node or leaf with the slot under which its labels are kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub child: Child,
    pub slot: u32,
}

impl Place {
    /// The root. No child has its slot.
    pub const ROOT: Self = Self { child: Child::ROOT, slot: 0 };
}

/// The nodes that were met, by slot, with their labels and those of leaves.
#[derive(Debug, Default)]
pub(super) struct MetTree {
    nodes: Vec<MetNode>,
    pub node_labels: Labels,
    pub leaf_labels: Labels,
}

impl MetNode {
    /// The left (0) or right (1) child, if it was met.
    #[inline(always)]
    pub fn child(&self, side: u8) -> Option<Place> {
        let side = usize::from(side & 1);
        let place = Place { child: self.children[side], slot: self.slots[side] };
        (place.slot != 0).then_some(place)
    }
}

impl MetTree {
    /// Starts a tile.
    pub fn start(&mut self, topology: &BvhTopology) {
        self.nodes.clear();
        self.nodes.push(MetNode { children: topology.children[0], slots: [0; 2], number: 0 });
        self.node_labels.start();
        // Slot 0 of the leaves is nobody's: it stands for a leaf that was not met.
        self.leaf_labels.start();
    }

    /// Forgets every label.
    pub fn forget(&mut self) {
        self.node_labels.forget();
        self.leaf_labels.forget();
    }

    /// An inner node.
    #[inline(always)]
    pub fn node(&self, slot: u32) -> &MetNode {
        &self.nodes[slot as usize]
    }

    /// Meets the left (0) or right (1) child of an inner node, which was not met before.
    #[cold]
    pub fn meet(&mut self, parent: u32, side: u8, topology: &BvhTopology) -> Place {
        let (parent, side) = (parent as usize, usize::from(side & 1));
        let child = self.nodes[parent].children[side];
        let slot = if child.is_leaf() {
            self.leaf_labels.meet()
        } else {
            let children = topology.children[child.node()];
            self.nodes.push(MetNode { children, slots: [0; 2], number: child.node() as u32 });
            self.node_labels.meet()
        };
        self.nodes[parent].slots[side] = slot;
        Place { child, slot }
    }
}
