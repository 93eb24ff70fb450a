//! What a path needs of the BVH.

use crate::bvh::{Bvh, Child};

/// A BVH without boxes and corners, packed for walking: the children of every node, and which triangles a ray may pass.
#[derive(Debug)]
pub struct BvhTopology {
    pub(super) children: Vec<[Child; 2]>,
    /// Per triangle: bit 0, any ray may pass; bit 1, a shadow ray may pass.
    pub(super) passes: Vec<u8>,
}

impl BvhTopology {
    /// The topology of `bvh`.
    pub fn new(bvh: &Bvh) -> Self {
        let passes = |t: usize| {
            let material = bvh.material(t);
            u8::from(material.may_pass(false)) | u8::from(material.may_pass(true)) << 1
        };
        Self {
            children: bvh.nodes.iter().map(|node| node.children).collect(),
            passes: (0..bvh.triangles.len()).map(passes).collect(),
        }
    }
}
