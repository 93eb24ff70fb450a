//! All rays of a tile, in order.

use super::formulas::{Ray, shadow};
use super::rebuild::{Geometry, RayRebuilder};
use crate::scene::Light;
use crate::tile::{Hit, RayClass, RayKind, RayNode, ShadowState, Tile};

/// A ray that was traced, and where it ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedRay {
    /// Sample in the tile, counted row by row: its column is `sample % rect.width`.
    pub sample: u32,
    /// Index of its node in [`Tree::nodes`](crate::tile::Tree::nodes); of a shadow ray, the node whose hit it leaves.
    pub node: u32,
    /// Class of that node.
    pub class: RayClass,
    /// Its number in ray order: the index of its path in [`Tile::paths`].
    pub index: u32,
    /// The ray itself.
    pub ray: Ray,
    /// Where it ended.
    pub end: RayEnd,
}

/// Where a ray ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayEnd {
    /// A closest-hit ray met nothing: it sees the sky.
    Sky,
    /// A closest-hit ray met a triangle.
    Hit(Hit),
    /// A shadow ray: which light it was sent to, and what it found.
    Light {
        /// Index into [`Meta::lights`](crate::scene::Meta::lights).
        light: usize,
        /// What it found on the way; never [`ShadowState::NotCast`].
        state: ShadowState,
    },
}

impl RecordedRay {
    /// What the ray is.
    pub fn kind(&self) -> RayKind {
        match self.end {
            RayEnd::Light { .. } => RayKind::Shadow,
            RayEnd::Sky | RayEnd::Hit(_) => self.class.kind(),
        }
    }
}

/// Walks all rays of a tile in ray order: sample by sample, the nodes of its tree depth first, and after each node's
/// closest-hit ray its shadow rays by light.
#[derive(Debug)]
pub struct TileRays<'a> {
    tile: Tile,
    lights: &'a [Light],
    rebuilder: RayRebuilder<'a>,
    /// The next node and its sample.
    node: u32,
    sample: u32,
    /// The number of the next ray.
    index: u32,
    /// Shadow rays of the last node, still to be given; the next one last.
    shadows: Vec<RecordedRay>,
}

impl<'a> TileRays<'a> {
    /// Walks `tile`. `lights` are those of its trace. [`Trace::rays`](crate::Trace::rays) reads a tile and walks it.
    ///
    /// # Panics
    /// When the hits of the tile were not read.
    pub fn new(tile: Tile, geometry: Geometry<'a>, lights: &'a [Light]) -> Self {
        assert_eq!(tile.hits.len(), tile.tree.nodes.len(), "rays follow from hits: read the column first");
        let rebuilder = RayRebuilder::new(&tile.tree, tile.rect, geometry);
        Self { tile, lights, rebuilder, node: 0, sample: 0, index: 0, shadows: Vec::new() }
    }

    /// The tile that is walked.
    pub fn tile(&self) -> &Tile {
        &self.tile
    }

    fn number(&mut self) -> u32 {
        self.index += 1;
        self.index - 1
    }

    /// Puts the shadow rays of a hit aside.
    fn cast(&mut self, from: &RecordedRay, hit: &Hit) {
        let Some(surface) = self.rebuilder.hit(from.node, hit) else { return };
        let states = self.tile.tree.nodes[from.node as usize].shadows;
        for (light, source) in self.lights.iter().enumerate() {
            let state = states.get(light);
            if state != ShadowState::NotCast {
                let (index, ray) = (self.number(), shadow(&surface, source));
                self.shadows.push(RecordedRay { index, ray, end: RayEnd::Light { light, state }, ..*from });
            }
        }
        self.shadows.reverse();
    }
}

impl Iterator for TileRays<'_> {
    type Item = RecordedRay;

    fn next(&mut self) -> Option<RecordedRay> {
        if let Some(shadow) = self.shadows.pop() {
            return Some(shadow);
        }
        let node = self.node;
        let RayNode { class, hit, .. } = *self.tile.tree.nodes.get(node as usize)?;
        while self.tile.tree.sample(self.sample as usize).end <= node as usize {
            self.sample += 1;
        }
        let ray = self.rebuilder.ray(self.sample, class, node);
        let end = if hit { RayEnd::Hit(self.tile.hits[node as usize]) } else { RayEnd::Sky };
        let recorded = RecordedRay { sample: self.sample, node, class, index: self.number(), ray, end };
        if let RayEnd::Hit(hit) = end {
            self.cast(&recorded, &hit);
        }
        self.node += 1;
        Some(recorded)
    }
}
