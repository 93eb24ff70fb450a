//! The rays of a tile while they are traced, and the tile that comes of them.
//!
//! Rays are traced class by class, so that neighbours in the image walk together. A tile holds them sample by sample,
//! depth first.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays::Ray;
use rayreel_formats::scene::Rect;
use rayreel_formats::tile::{Hit, Paths, Radiance, RayClass, RayNode, Shadows, Tile, Tree, composite};

use crate::traverse::PacketScratch;

/// A closest-hit ray to be traced, with what it must know of the path so far.
#[derive(Clone, Copy)]
pub(crate) struct WaitingRay {
    pub ray: Ray,
    /// Its entry in [`Waves::nodes`].
    pub node: u32,
    /// Product of the weights from the eye.
    pub weight: Vec3,
    /// Length of the path from the eye to the ray's origin.
    pub travelled: f32,
}

/// A closest-hit ray that was traced, or is waiting.
#[derive(Clone, Copy)]
pub(crate) struct TracedNode {
    pub node: RayNode,
    pub hit: Hit,
    pub radiance: Radiance,
    /// Entries of the reflection and the refraction, where there are any.
    pub children: [u32; 2],
    /// The first of its spans in [`Waves::spans`]: its own, then one a shadow ray.
    pub spans: u32,
}

impl TracedNode {
    fn waiting(class: RayClass) -> Self {
        let node = RayNode { class, hit: false, reflect: false, refract: false, shadows: Shadows(0) };
        Self { node, hit: Hit::MISS, radiance: Radiance::default(), children: [0; 2], spans: 0 }
    }
}

/// All rays of a tile, and the memory to trace them.
pub(crate) struct Waves {
    /// The primary rays by sample, then the others as they come.
    pub nodes: Vec<TracedNode>,
    pub steps: Vec<u8>,
    pub spans: Vec<(u32, u32)>,
    pub packets: PacketScratch,
    samples: usize,
}

impl Waves {
    /// A tile of which only the samples are known.
    pub fn new(samples: usize) -> Self {
        let nodes = vec![TracedNode::waiting(RayClass::PRIMARY); samples];
        Self { nodes, steps: Vec::new(), spans: Vec::new(), packets: PacketScratch::default(), samples }
    }

    /// An entry for a ray that is still to be traced.
    pub fn wait(&mut self, class: RayClass) -> u32 {
        self.nodes.push(TracedNode::waiting(class));
        self.nodes.len() as u32 - 1
    }

    /// Keeps the steps of a lane of the last packet, and gives their span.
    pub fn keep(&mut self, lane: usize) -> (u32, u32) {
        let steps = self.packets.steps(lane);
        let start = self.steps.len() as u32;
        self.steps.extend_from_slice(steps);
        (start, steps.len() as u32)
    }

    /// Calls `take` with the nodes of a sample, depth first, reflections before refractions.
    fn depth_first(&self, sample: usize, open: &mut Vec<u32>, mut take: impl FnMut(&TracedNode)) {
        open.push(sample as u32);
        while let Some(index) = open.pop() {
            let traced = &self.nodes[index as usize];
            take(traced);
            let [reflection, refraction] = traced.children;
            open.extend(traced.node.refract.then_some(refraction));
            open.extend(traced.node.reflect.then_some(reflection));
        }
    }

    /// The tile of all rays.
    pub fn into_tile(self, rect: Rect, frame: u32, index: u32) -> Tile {
        let mut tree =
            Tree { first: Vec::with_capacity(self.samples + 1), nodes: Vec::with_capacity(self.nodes.len()) };
        let (mut hits, mut radiance) = (Vec::with_capacity(self.nodes.len()), Vec::with_capacity(self.nodes.len()));
        let (mut spans, mut open) = (Vec::with_capacity(self.spans.len()), Vec::new());
        for sample in 0..self.samples {
            tree.first.push(tree.nodes.len() as u32);
            self.depth_first(sample, &mut open, |traced| {
                tree.nodes.push(traced.node);
                hits.push(traced.hit);
                radiance.push(traced.radiance);
                if !self.spans.is_empty() {
                    let rays = 1 + traced.node.shadows.count() as usize;
                    spans.extend_from_slice(&self.spans[traced.spans as usize..][..rays]);
                }
            });
        }
        tree.first.push(tree.nodes.len() as u32);
        Tile { frame, index, rect, tree, hits, radiance, paths: Paths { steps: self.steps, spans } }
    }

    /// The colours of the samples.
    pub fn colours(&self) -> Vec<Vec3> {
        let (mut nodes, mut radiance, mut open) = (Vec::new(), Vec::new(), Vec::new());
        let colour = |sample| {
            nodes.clear();
            radiance.clear();
            self.depth_first(sample, &mut open, |traced| {
                nodes.push(traced.node);
                radiance.push(traced.radiance);
            });
            composite(&nodes, &radiance)
        };
        (0..self.samples).map(colour).collect()
    }
}
