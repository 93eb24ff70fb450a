//! The tree as the machine sees it: who is whose child, and nothing of boxes or triangles.

use rayreel_formats::bvh::{Bvh, Child};

/// Children and parents of the inner nodes.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Per inner node its two children.
    pub children: Vec<[Child; 2]>,
    /// Per inner node its parent; the root is its own.
    pub parents: Vec<u32>,
    /// Number of triangles.
    pub triangles: u32,
}

impl Topology {
    /// The topology of a tree.
    pub fn new(bvh: &Bvh) -> Self {
        Self::from_children(bvh.nodes.iter().map(|n| n.children).collect(), bvh.triangles.len() as u32)
    }

    /// The topology of a tree given by its children alone. A node stands before its children.
    pub fn from_children(children: Vec<[Child; 2]>, triangles: u32) -> Self {
        let mut parents = vec![0; children.len()];
        for (node, pair) in children.iter().enumerate() {
            for child in pair.iter().filter(|c| !c.is_leaf()) {
                parents[child.node()] = node as u32;
            }
        }
        Self { children, parents, triangles }
    }
}
