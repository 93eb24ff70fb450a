//! The ray tree of a sample, as far as a policy looks into it.
//!
//! A tree is a slice of hits in depth-first order: the primary hit, then its reflection's subtree, then its refraction's. A
//! policy that looks at primary hits only sees every sample as a tree of one hit that holds the colour and the rays of all.

use std::ops::Range;

use rayreel_formats::math::Vec3;
use rayreel_formats::tile::{RayClass, Shadows};

/// Where a closest-hit ray met a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Object number.
    pub object: u32,
    /// What the shadow rays of the hit found.
    pub shadows: Shadows,
    /// Unit shading normal as stored, not turned towards the ray.
    pub normal: Vec3,
    /// Hit point of a primary ray, scene units; zero for other rays, whose positions no test looks at.
    pub position: Vec3,
    /// Length of the ray, scene units.
    pub t: f32,
}

/// One hit of a ray tree (or a miss) with the subtree below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// What was hit; `None` for the sky.
    pub surface: Option<SurfacePoint>,
    /// Colour of the hit without its children, linear RGB.
    pub local: Vec3,
    /// Colour with all children, linear RGB.
    pub colour: Vec3,
    /// Weight of the reflection, if there is one.
    pub reflect: Option<Vec3>,
    /// Weight of the refraction, if there is one.
    pub refract: Option<Vec3>,
    /// Rays of this hit alone: the one that met it and its shadow rays.
    pub hit_rays: u32,
    /// Rays of the whole subtree.
    pub rays: u32,
    /// Hits of the whole subtree.
    pub len: u32,
    /// Of a sample's first hit: frames since the lights of the oldest that the sample was made of were looked for.
    pub age: u8,
}

impl Node {
    /// The same hits hang below both.
    pub fn branches_as(&self, other: &Self) -> bool {
        self.reflect.is_some() == other.reflect.is_some() && self.refract.is_some() == other.refract.is_some()
    }

    /// The classes of its children, if it is of class `class`: that of the reflection before that of the refraction.
    pub fn branches(&self, class: RayClass) -> impl Iterator<Item = RayClass> + use<> {
        let reflection = self.reflect.map(|_| class.reflection());
        reflection.into_iter().chain(self.refract.map(|_| class.refraction()))
    }
}

/// The children of the first hit of `tree`: weight and subtree, reflection before refraction.
pub fn children(tree: &[Node]) -> impl Iterator<Item = (Vec3, &[Node])> {
    let mut start = 1;
    [tree[0].reflect, tree[0].refract].into_iter().flatten().map(move |weight| {
        let len = tree[start].len as usize;
        let child = &tree[start..start + len];
        start += len;
        (weight, child)
    })
}

/// Sets colour, rays and length of `tree[0]`, whose subtrees (all that follows in `tree`) are finished. The colour is put
/// together in the order of [`rayreel_formats::tile::composite`], so that a traced tree has the recorded colour to the bit.
pub fn finish(tree: &mut [Node]) {
    let (mut colour, mut rays, mut len) = (tree[0].local, tree[0].hit_rays, 1);
    for (weight, child) in children(tree) {
        colour = colour + weight.times(child[0].colour);
        rays += child[0].rays;
        len += child[0].len;
    }
    (tree[0].colour, tree[0].rays, tree[0].len) = (colour, rays, len);
}

/// The trees of many samples, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Forest {
    nodes: Vec<Node>,
    spans: Vec<(u32, u32)>,
    /// Which samples were interpolated, as far as it was said.
    interpolated: Vec<bool>,
}

impl Forest {
    /// Room for `samples` samples, all without a tree.
    pub fn new(samples: usize) -> Self {
        Self { nodes: Vec::with_capacity(samples), spans: vec![(0, 0); samples], interpolated: Vec::new() }
    }

    /// The tree of a sample; empty if it has none yet.
    #[inline]
    pub fn tree(&self, sample: usize) -> &[Node] {
        let (start, len) = self.spans[sample];
        &self.nodes[start as usize..][..len as usize]
    }

    /// Gives a sample its tree, in place of the one it had.
    pub fn set(&mut self, sample: usize, tree: &[Node]) {
        self.spans[sample] = (self.nodes.len() as u32, tree.len() as u32);
        self.nodes.extend_from_slice(tree);
    }

    /// Appends a sample with its tree.
    pub fn push(&mut self, tree: &[Node]) {
        self.spans.push((0, 0));
        self.set(self.spans.len() - 1, tree);
    }

    /// Says that the sample that was pushed last is interpolated, or not.
    pub(crate) fn last_is_interpolated(&mut self, is_interpolated: bool) {
        self.interpolated.resize(self.spans.len(), false);
        if let Some(last) = self.interpolated.last_mut() {
            *last = is_interpolated;
        }
    }

    /// Whether a sample was interpolated.
    pub(crate) fn is_interpolated(&self, sample: usize) -> bool {
        self.interpolated.get(sample).is_some_and(|interpolated| *interpolated)
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.spans.len()
    }

    /// Hits of all trees beyond one a sample: what secondary tests add to a tile buffer.
    pub fn secondary_hits(&self) -> u32 {
        self.spans.iter().map(|&(_, len)| len.saturating_sub(1)).sum()
    }

    /// Where the tree of a sample stands among [`Forest::nodes`].
    pub fn span(&self, sample: usize) -> Range<usize> {
        let (start, len) = self.spans[sample];
        start as usize..start as usize + len as usize
    }

    /// The hits of all trees.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }
}
