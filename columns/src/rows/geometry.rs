//! The tree and the triangles: one row a node, one row a triangle.

use std::ops::Range;

use rayreel_formats::bvh::{Bvh, Child};
use rayreel_formats::scene::Optics;

use crate::schema::table;
use crate::value::{Names, Words, WordsOf, word};

word! {
    /// What a child is.
    pub enum ChildKind {
        /// An inner node.
        Inner = "inner",
        /// Triangles.
        Leaf = "leaf",
    }
}

table! {
    /// The nodes of a tree.
    pub struct NodeRows = "nodes", "an inner node, depth-first; the root is node 0" {
        node: Vec<u32>, "", "number of the node";
        parent: Vec<i32>, "", "its parent; -1 for the root";
        depth: Vec<u8>, "nodes", "inner nodes above it";
        left_kind: WordsOf<ChildKind>, "", "what the left child is";
        left: Vec<u32>, "", "left child: its number, or its first triangle";
        left_triangles: Vec<u8>, "triangles", "triangles of the left child; 0 for an inner node";
        left_min_x: Vec<f32>, "scene units", "box of the left child, lower corner; above the upper one if it is empty";
        left_min_y: Vec<f32>, "scene units", "box of the left child, lower corner";
        left_min_z: Vec<f32>, "scene units", "box of the left child, lower corner";
        left_max_x: Vec<f32>, "scene units", "box of the left child, upper corner";
        left_max_y: Vec<f32>, "scene units", "box of the left child, upper corner";
        left_max_z: Vec<f32>, "scene units", "box of the left child, upper corner";
        right_kind: WordsOf<ChildKind>, "", "what the right child is";
        right: Vec<u32>, "", "right child: its number, or its first triangle";
        right_triangles: Vec<u8>, "triangles", "triangles of the right child; 0 for an inner node";
        right_min_x: Vec<f32>, "scene units", "box of the right child, lower corner; above the upper one if it is empty";
        right_min_y: Vec<f32>, "scene units", "box of the right child, lower corner";
        right_min_z: Vec<f32>, "scene units", "box of the right child, lower corner";
        right_max_x: Vec<f32>, "scene units", "box of the right child, upper corner";
        right_max_y: Vec<f32>, "scene units", "box of the right child, upper corner";
        right_max_z: Vec<f32>, "scene units", "box of the right child, upper corner";
    }
}

/// A child as its kind, its number and its triangles.
fn child(child: Child) -> (ChildKind, u32, u8) {
    if child.is_leaf() {
        (ChildKind::Leaf, child.first() as u32, child.count() as u8)
    } else {
        (ChildKind::Inner, child.node() as u32, 0)
    }
}

/// Per node its parent and how many nodes stand above it.
pub fn ancestors(bvh: &Bvh) -> Vec<(i32, u8)> {
    let mut found = vec![(-1, 0); bvh.nodes.len()];
    for (number, node) in (0..).zip(&bvh.nodes) {
        let depth: u8 = found[number as usize].1;
        // A tree is not deeper than a byte counts: `MAX_TREE_DEPTH`.
        for child in node.children.iter().filter(|child| !child.is_leaf()) {
            found[child.node()] = (number, depth + 1);
        }
    }
    found
}

/// Some nodes of a tree, of which `above` are the [`ancestors`].
pub fn nodes(bvh: &Bvh, above: &[(i32, u8)], range: Range<usize>) -> NodeRows {
    let mut rows = NodeRows::default();
    for number in range {
        let (node, (parent, depth)) = (&bvh.nodes[number], above[number]);
        let [left, right] = node.bounds;
        rows.node.push(number as u32);
        rows.parent.push(parent);
        rows.depth.push(depth);
        let (kind, first, triangles) = child(node.children[0]);
        rows.left_kind.push(kind);
        rows.left.push(first);
        rows.left_triangles.push(triangles);
        rows.left_min_x.push(left.min.x);
        rows.left_min_y.push(left.min.y);
        rows.left_min_z.push(left.min.z);
        rows.left_max_x.push(left.max.x);
        rows.left_max_y.push(left.max.y);
        rows.left_max_z.push(left.max.z);
        let (kind, first, triangles) = child(node.children[1]);
        rows.right_kind.push(kind);
        rows.right.push(first);
        rows.right_triangles.push(triangles);
        rows.right_min_x.push(right.min.x);
        rows.right_min_y.push(right.min.y);
        rows.right_min_z.push(right.min.z);
        rows.right_max_x.push(right.max.x);
        rows.right_max_y.push(right.max.y);
        rows.right_max_z.push(right.max.z);
    }
    rows
}

word! {
    /// Secondary rays of a material.
    pub enum OpticsWord {
        /// None.
        Opaque = "opaque",
        /// A reflection of constant weight.
        Mirror = "mirror",
        /// A reflection weighted by Schlick's approximation.
        FresnelMirror = "fresnel_mirror",
        /// A reflection and a refraction.
        Dielectric = "dielectric",
    }
}

impl From<Optics> for OpticsWord {
    fn from(optics: Optics) -> Self {
        match optics {
            Optics::Opaque => Self::Opaque,
            Optics::Mirror => Self::Mirror,
            Optics::FresnelMirror => Self::FresnelMirror,
            Optics::Dielectric => Self::Dielectric,
        }
    }
}

table! {
    /// The triangles of a scene.
    pub struct TriangleRows = "triangles", "a triangle, in leaf order" {
        triangle: Vec<u32>, "", "number of the triangle";
        object: Vec<u32>, "", "number of its object";
        object_name: Words, "", "name of its object";
        material: Vec<u32>, "", "number of its material";
        material_name: Words, "", "name of its material";
        optics: WordsOf<OpticsWord>, "", "secondary rays of its material";
        cutout: Vec<bool>, "", "a texture of its material decides where the surface is";
        a_x: Vec<f32>, "scene units", "first corner";
        a_y: Vec<f32>, "scene units", "first corner";
        a_z: Vec<f32>, "scene units", "first corner";
        b_x: Vec<f32>, "scene units", "second corner";
        b_y: Vec<f32>, "scene units", "second corner";
        b_z: Vec<f32>, "scene units", "second corner";
        c_x: Vec<f32>, "scene units", "third corner";
        c_y: Vec<f32>, "scene units", "third corner";
        c_z: Vec<f32>, "scene units", "third corner";
        vertex_a: Vec<u32>, "", "vertex of the first corner; triangles that share a vertex have the same number";
        vertex_b: Vec<u32>, "", "vertex of the second corner";
        vertex_c: Vec<u32>, "", "vertex of the third corner";
    }
}

/// Names of objects and of materials.
pub fn triangle_words(bvh: &Bvh) -> [Names; 2] {
    let materials = bvh.materials.iter().map(|material| material.name.clone());
    [Names::shared(bvh.objects.iter().cloned()), Names::shared(materials)]
}

/// Some triangles of a scene; `words` are its [`triangle_words`].
pub fn triangles(bvh: &Bvh, [objects, materials]: [Names; 2], range: Range<usize>) -> TriangleRows {
    let mut rows = TriangleRows {
        object_name: Words { codes: Vec::new(), names: objects },
        material_name: Words { codes: Vec::new(), names: materials },
        ..TriangleRows::default()
    };
    for number in range {
        let (triangle, material) = (&bvh.triangles[number], bvh.material(number));
        let [a, b, c] = bvh.corners(number);
        rows.triangle.push(number as u32);
        rows.object.push(triangle.object);
        rows.object_name.codes.push(triangle.object);
        rows.material.push(triangle.material);
        rows.material_name.codes.push(triangle.material);
        rows.optics.push(material.optics.into());
        rows.cutout.push(material.cutout);
        rows.a_x.push(a.x);
        rows.a_y.push(a.y);
        rows.a_z.push(a.z);
        rows.b_x.push(b.x);
        rows.b_y.push(b.y);
        rows.b_z.push(b.z);
        rows.c_x.push(c.x);
        rows.c_y.push(c.y);
        rows.c_z.push(c.z);
        rows.vertex_a.push(triangle.vertices[0]);
        rows.vertex_b.push(triangle.vertices[1]);
        rows.vertex_c.push(triangle.vertices[2]);
    }
    rows
}
