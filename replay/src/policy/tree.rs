//! The ray tree of a sample, as far as a policy looks into it.
//!
//! A tree is a slice of hits in depth-first order: the primary hit, then its reflection's subtree, then its refraction's. A
//! policy that looks at primary hits only sees every sample as a tree of one hit that holds the colour and the rays of all.

use std::ops::Range;

use rayreel_formats::math::Vec3;

use super::interpolate::{mix, surface};
use super::view::SurfacePoint;

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
    /// Rays of this hit: the one that met it and its shadow rays.
    pub own_rays: u32,
    /// Rays of the whole subtree.
    pub rays: u32,
    /// Hits of the whole subtree.
    pub len: u32,
}

impl Node {
    /// The same hits hang below both.
    pub fn branches_as(&self, other: &Self) -> bool {
        self.reflect.is_some() == other.reflect.is_some() && self.refract.is_some() == other.refract.is_some()
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
    let (mut colour, mut rays, mut len) = (tree[0].local, tree[0].own_rays, 1);
    for (weight, child) in children(tree) {
        colour = colour + weight.times(child[0].colour);
        rays += child[0].rays;
        len += child[0].len;
    }
    (tree[0].colour, tree[0].rays, tree[0].len) = (colour, rays, len);
}

/// Appends the tree between two trees of similar samples, `s` of the way from `near` to `far` (at most a half). Hits that
/// both have are interpolated one by one; where one has a child that the other lacks, the subtree becomes a single hit with
/// the interpolated colour. The local colour of every hit is interpolated for itself: texture tests look at it.
pub fn interpolate_tree(near: &[Node], far: &[Node], s: f32, out: &mut Vec<Node>) {
    let at = out.len();
    let (a, b) = (&near[0], &far[0]);
    let mut node = interpolate_node(a, b, s);
    node.colour = mix(a.colour, b.colour, s);
    if !a.branches_as(b) {
        (node.reflect, node.refract) = (None, None);
        out.push(node);
        return;
    }
    out.push(node);
    for ((_, near), (_, far)) in children(near).zip(children(far)) {
        interpolate_tree(near, far, s, out);
    }
    out[at].len = (out.len() - at) as u32;
}

/// The hit between two: local colour, weights and surface; its subtree is still to come.
pub fn interpolate_node(near: &Node, far: &Node, s: f32) -> Node {
    let weight = |a: Option<Vec3>, b: Option<Vec3>| a.zip(b).map(|(a, b)| mix(a, b, s));
    Node {
        surface: match (&near.surface, &far.surface) {
            (Some(near), Some(far)) => Some(surface(near, far, s)),
            (near, _) => *near,
        },
        local: mix(near.local, far.local, s),
        reflect: weight(near.reflect, far.reflect),
        refract: weight(near.refract, far.refract),
        len: 1,
        ..*near
    }
}

/// The trees of many samples, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Forest {
    nodes: Vec<Node>,
    spans: Vec<(u32, u32)>,
}

impl Forest {
    /// Room for `samples` samples, all without a tree.
    pub fn new(samples: usize) -> Self {
        Self { nodes: Vec::with_capacity(samples), spans: vec![(0, 0); samples] }
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
