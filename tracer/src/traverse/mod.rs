//! Traversal of two-child nodes: closest hit and any hit, with or without recording the path.
//!
//! One ray walks alone (`single.rs`), rays that start and point alike walk as a packet (`packet.rs`). A ray in a packet
//! does what it would do alone, step by step: the same children in the same order, the same culls, the same tests.
//! Capture and rendering walk packets; verification walks every ray alone, so it checks the packets too.
//!
//! SIMD is used element by element, never to sum or compare lanes: each lane is the scalar IEEE operation, so a path is
//! the same on every machine.

#[cfg(target_arch = "x86_64")]
mod avx;
mod lanes;
mod log;
mod packet;
mod padding;
mod single;

use glam::Vec4;
use rayreel_formats::bvh::{Bvh, Child};
use rayreel_formats::math::Vec3;

pub use lanes::LANES;
pub use packet::{LaneHits, PacketRays, PacketScratch};
use padding::Padding;
pub use single::TraversalScratch;

/// Widening of a box's far distance: 16 units in the last place. Slab distances and triangle distances round
/// differently, and a box must never be skipped when a triangle in it would be hit.
const WIDEN: f32 = 1.0 + 1.0 / 524_288.0;

/// Smallest magnitude of a direction component in the slab test, so that its reciprocal stays finite and no NaN arises.
const TINY: f32 = 1.0e-18;

/// A node laid out for the two-box test: lanes are left minimum, right minimum, left maximum, right maximum.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct TwoBoxes {
    x: Vec4,
    y: Vec4,
    z: Vec4,
    children: [Child; 2],
}

/// A [`Bvh`] laid out for traversal.
#[derive(Debug)]
pub struct TraversalBvh {
    nodes: Vec<TwoBoxes>,
    padding: Padding,
    corners: Vec<[Vec3; 3]>,
}

/// Where a ray hits a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Triangle in leaf order.
    pub triangle: u32,
    /// Ray parameter.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
}

impl TraversalBvh {
    /// Lays out a tree.
    pub fn new(bvh: &Bvh) -> Self {
        let padding = Padding::new(bvh);
        let nodes = bvh
            .nodes
            .iter()
            .map(|node| {
                let [a, b] = node.bounds.map(|bounds| padding.grown(bounds));
                TwoBoxes {
                    x: Vec4::new(a.min.x, b.min.x, a.max.x, b.max.x),
                    y: Vec4::new(a.min.y, b.min.y, a.max.y, b.max.y),
                    z: Vec4::new(a.min.z, b.min.z, a.max.z, b.max.z),
                    children: node.children,
                }
            })
            .collect();
        Self { nodes, padding, corners: (0..bvh.triangles.len()).map(|t| bvh.corners(t)).collect() }
    }

    /// The corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.corners[triangle as usize]
    }
}
