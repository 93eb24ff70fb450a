//! Builds the BVH of a scene with obvhs and puts it into the order of the trace.
//!
//! obvhs is used behind this module and `tree.rs` only. Its `parallel` feature must stay off: it builds another tree.

use std::collections::HashMap;

use glam::Vec3A;
use obvhs::bvh2::Bvh2;
use obvhs::triangle::Triangle as BuildTriangle;
use rayreel_formats::bvh::{Bvh, MAX_LEAF_TRIANGLES, MAX_TREE_DEPTH, Shape, Triangle, Vertex};
use rayreel_formats::math::Vec3;
use rayreel_formats::oct::Oct;
use rayreel_scenes::Scene;

use crate::coincident::Crowds;
use crate::tree::tree;
use crate::{coincident, convert};

/// A scene that the trace format cannot hold: it is too large, or too degenerate for a tree of bounded depth.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot build the BVH of scene {scene}: {what}")]
pub struct BuildError {
    /// The scene's name.
    pub scene: String,
    /// What the format cannot hold.
    pub what: String,
}

/// A BVH and where its triangles come from.
#[derive(Debug)]
pub struct Built {
    /// The tree, in the order of the trace.
    pub bvh: Bvh,
    /// Per triangle in leaf order, its index in the scene's mesh.
    pub source: Vec<u32>,
    /// Triangles of the mesh that were left out, because they are copies of others in the same place.
    pub left_out: usize,
}

/// Builds the BVH of a scene: obvhs' medium preset but for flat scenes (`tree.rs`), at most [`MAX_LEAF_TRIANGLES`] triangles a leaf. The builder runs in
/// one thread, so it gives the same tree on every run.
///
/// # Errors
/// When the trace format cannot hold the scene.
pub fn build(scene: &Scene) -> Result<Built, BuildError> {
    let mesh = &scene.mesh;
    let corner = |v: u32| Vec3A::from(mesh.positions[v as usize]);
    let kept = coincident::kept(scene);
    let triangles: Vec<BuildTriangle> = kept
        .iter()
        .map(|&t| mesh.triangles[t as usize])
        .map(|t| BuildTriangle { v0: corner(t.vertices[0]), v1: corner(t.vertices[1]), v2: corner(t.vertices[2]) })
        .collect();
    let crowds = Crowds::of(&triangles);
    let (shape, mut source) = depth_first(&tree(&crowds.seen(&triangles)), &crowds);
    source.iter_mut().for_each(|at| *at = kept[*at as usize]);
    let (triangles, vertices) = leaf_order(scene, &source);
    let materials = scene.materials.iter().map(convert::material).collect();
    let bvh = Bvh::new(&shape, triangles, vertices, scene.objects.clone(), materials)
        .map_err(|what| BuildError { scene: scene.name.clone(), what })?;
    Ok(Built { bvh, source, left_out: mesh.triangles.len() - kept.len() })
}

/// Depth from which on a tree that is too deep is split in halves.
const DEEP: u32 = 64;

/// The shape of the tree and the triangle order of a depth-first walk, left child first.
fn depth_first(bvh: &Bvh2, crowds: &Crowds) -> (Vec<[Shape; 2]>, Vec<u32>) {
    let mut walk =
        DepthFirst { bvh, crowds, shape: Vec::new(), source: Vec::with_capacity(bvh.primitive_indices.len()) };
    if bvh.nodes[0].prim_count > 0 && walk.triangles(0).len() <= MAX_LEAF_TRIANGLES as usize {
        // The whole scene is one leaf: it stands left below a root whose right child is empty.
        let leaf = walk.leaf(walk.triangles(0));
        walk.shape.push([leaf, Shape::Leaf(0)]);
    } else {
        walk.walk(walk.is_too_deep());
    }
    (walk.shape, walk.source)
}

/// What a depth-first walk still has to visit.
enum Part {
    /// A node.
    Node(usize),
    /// Triangles that are split in halves until they fit into leaves.
    Halves(Vec<u32>),
}

struct DepthFirst<'a> {
    bvh: &'a Bvh2,
    crowds: &'a Crowds,
    shape: Vec<[Shape; 2]>,
    source: Vec<u32>,
}

impl DepthFirst<'_> {
    /// Whether a branch has more inner nodes than a trace may have, halves of crowds included.
    fn is_too_deep(&self) -> bool {
        let mut open = vec![(0, 1)];
        while let Some((node, depth)) = open.pop() {
            let first = self.bvh.nodes[node].first_index as usize;
            // Inner nodes of the branch from here on.
            let levels = if self.bvh.nodes[node].prim_count == 0 {
                open.extend([0, 1].map(|side| (first + side, depth + 1)));
                1
            } else {
                let leaves = self.triangles(node).len().div_ceil(MAX_LEAF_TRIANGLES as usize);
                leaves.next_power_of_two().ilog2() as usize
            };
            if depth + levels > MAX_TREE_DEPTH + 1 {
                return true;
            }
        }
        false
    }

    /// The triangles of a leaf; none of an inner node.
    fn triangles(&self, node: usize) -> Vec<u32> {
        let node = &self.bvh.nodes[node];
        let first = node.first_index as usize;
        let seen = &self.bvh.primitive_indices[first..first + node.prim_count as usize];
        seen.iter().flat_map(|&number| self.crowds.behind(number)).collect()
    }

    /// All triangles below a node, in the order of a depth-first walk.
    fn below(&self, node: usize) -> Vec<u32> {
        let (mut all, mut open) = (Vec::new(), vec![node]);
        while let Some(node) = open.pop() {
            let left = self.bvh.nodes[node].first_index as usize;
            match self.bvh.nodes[node].prim_count {
                0 => open.extend([left + 1, left]),
                _ => all.extend(self.triangles(node)),
            }
        }
        all
    }

    fn leaf(&mut self, triangles: Vec<u32>) -> Shape {
        let count = triangles.len() as u8;
        self.source.extend(triangles);
        Shape::Leaf(count)
    }

    /// Walks the tree; `halve` splits what lies deep in it in halves.
    fn walk(&mut self, halve: bool) {
        let mut open = vec![(Part::Node(0), None, 0)];
        while let Some((part, above, depth)) = open.pop() {
            let part = match part {
                Part::Node(node) if halve && depth == DEEP => Part::Halves(self.below(node)),
                Part::Node(node) if self.bvh.nodes[node].prim_count > 0 => Part::Halves(self.triangles(node)),
                part => part,
            };
            let (left, right) = match part {
                Part::Halves(triangles) if triangles.len() <= MAX_LEAF_TRIANGLES as usize => {
                    let leaf = self.leaf(triangles);
                    self.set(above, leaf);
                    continue;
                }
                Part::Node(node) => {
                    let left = self.bvh.nodes[node].first_index as usize;
                    (Part::Node(left), Part::Node(left + 1))
                }
                Part::Halves(mut triangles) => {
                    let right = triangles.split_off(triangles.len() / 2);
                    (Part::Halves(triangles), Part::Halves(right))
                }
            };
            let pair = self.shape.len();
            self.shape.push([Shape::Inner; 2]);
            open.extend([(right, Some((pair, 1)), depth + 1), (left, Some((pair, 0)), depth + 1)]);
        }
    }

    /// Says what a child is; the root is no child.
    fn set(&mut self, above: Option<(usize, usize)>, child: Shape) {
        if let Some((pair, side)) = above {
            self.shape[pair][side] = child;
        }
    }
}

/// Triangles in leaf order over vertices that are quantised, merged, and numbered as the triangles first name them.
fn leaf_order(scene: &Scene, source: &[u32]) -> (Vec<Triangle>, Vec<Vertex>) {
    let mesh = &scene.mesh;
    let mut numbers: HashMap<[u32; 4], u32> = HashMap::new();
    let mut vertices = Vec::new();
    let mut number = |v: u32| {
        let position = Vec3::from(mesh.positions[v as usize].to_array());
        let normal = Oct::encode(mesh.normals[v as usize].to_array().into());
        let [x, y, z] = position.to_array().map(f32::to_bits);
        *numbers.entry([x, y, z, normal.to_bits()]).or_insert_with(|| {
            vertices.push(Vertex { position, normal });
            vertices.len() as u32 - 1
        })
    };
    let triangles = source
        .iter()
        .map(|&t| {
            let t = mesh.triangles[t as usize];
            Triangle { vertices: t.vertices.map(&mut number), object: t.object, material: t.material }
        })
        .collect();
    (triangles, vertices)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of one box, each with another tip.
    fn crowd(count: u32, corner: Vec3A) -> impl Iterator<Item = BuildTriangle> {
        (1..=count).map(move |i| BuildTriangle {
            v0: corner,
            v1: corner + Vec3A::X,
            v2: corner + Vec3A::new(i as f32 / (count + 1) as f32, 1.0, 0.0),
        })
    }

    #[test]
    fn crowds_are_halved_below_the_one_that_the_builder_sees() {
        let single = |at: u32| crowd(1, Vec3A::new(3.0 * at as f32, 0.0, 1.0));
        for (crowded, others) in [(65, 0), (64, 9), (1000, 0), (1000, 1), (5000, 40)] {
            let triangles: Vec<_> =
                (0..others).flat_map(single).chain(crowd(crowded, Vec3A::new(0.5, 0.0, 0.0))).collect();
            let crowds = Crowds::of(&triangles);
            let seen = crowds.seen(&triangles);
            assert_eq!(seen.len() as u32, others + if crowded > 64 { 1 } else { crowded });
            let (shape, mut source) = depth_first(&tree(&seen), &crowds);
            let leaves = shape.iter().flatten().filter_map(|child| match child {
                Shape::Leaf(count) => Some(u32::from(*count)),
                Shape::Inner => None,
            });
            assert_eq!(leaves.clone().sum::<u32>(), crowded + others);
            assert!(leaves.max() <= Some(MAX_LEAF_TRIANGLES));
            source.sort_unstable();
            assert_eq!(source, (0..crowded + others).collect::<Vec<_>>());
        }
    }
}
