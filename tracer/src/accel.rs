//! Builds the BVH of a scene with obvhs and puts it into the order of the trace.
//!
//! obvhs is used behind this module only. Its `parallel` feature must stay off: it builds another tree.

use std::collections::HashMap;
use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::triangle::Triangle as BuildTriangle;
use rayreel_formats::bvh::{Bvh, MAX_LEAF_TRIANGLES, Shape, Triangle, Vertex};
use rayreel_formats::math::Vec3;
use rayreel_formats::oct::Oct;
use rayreel_scenes::Scene;

use crate::convert;

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
}

/// Builds the BVH of a scene: obvhs' medium preset, at most [`MAX_LEAF_TRIANGLES`] triangles a leaf. The builder runs in
/// one thread, so it gives the same tree on every run.
///
/// # Errors
/// When the trace format cannot hold the scene.
pub fn build(scene: &Scene) -> Result<Built, BuildError> {
    let mesh = &scene.mesh;
    let corner = |v: u32| Vec3A::from(mesh.positions[v as usize]);
    let triangles: Vec<BuildTriangle> = mesh
        .triangles
        .iter()
        .map(|t| BuildTriangle { v0: corner(t.vertices[0]), v1: corner(t.vertices[1]), v2: corner(t.vertices[2]) })
        .collect();
    let params = BvhBuildParams { max_prims_per_leaf: MAX_LEAF_TRIANGLES, ..BvhBuildParams::medium_build() };
    let bvh2 = build_bvh2(&triangles, params, &mut Duration::default());
    let (shape, source) = depth_first(&bvh2);
    let (triangles, vertices) = leaf_order(scene, &source);
    let materials = scene.materials.iter().map(convert::material).collect();
    let bvh = Bvh::new(&shape, triangles, vertices, scene.objects.clone(), materials)
        .map_err(|what| BuildError { scene: scene.name.clone(), what })?;
    Ok(Built { bvh, source })
}

/// The shape of the tree and the triangle order of a depth-first walk, left child first.
fn depth_first(bvh: &Bvh2) -> (Vec<[Shape; 2]>, Vec<u32>) {
    let mut source = Vec::with_capacity(bvh.primitive_indices.len());
    let mut take = |node: usize| {
        let node = &bvh.nodes[node];
        let first = node.first_index as usize;
        source.extend_from_slice(&bvh.primitive_indices[first..first + node.prim_count as usize]);
        Shape::Leaf(node.prim_count as u8)
    };
    if bvh.nodes[0].prim_count > 0 {
        // The whole scene is one leaf: it stands left below a root whose right child is empty.
        return (vec![[take(0), Shape::Leaf(0)]], source);
    }
    let mut shape = vec![[Shape::Inner; 2]];
    let left = bvh.nodes[0].first_index as usize;
    let mut open = vec![(left + 1, 0, 1), (left, 0, 0)];
    while let Some((node, parent, side)) = open.pop() {
        if bvh.nodes[node].prim_count > 0 {
            shape[parent][side] = take(node);
            continue;
        }
        let pair: usize = shape.len();
        shape.push([Shape::Inner; 2]);
        let left = bvh.nodes[node].first_index as usize;
        open.extend([(left + 1, pair, 1), (left, pair, 0)]);
    }
    (shape, source)
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
