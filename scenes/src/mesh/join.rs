//! Builds a mesh corner by corner, sharing vertices that agree in everything.

use glam::{Vec2, Vec3};

use crate::scene::Mesh;

/// No vertex.
const NONE: u32 = u32::MAX;

/// A mesh under construction. A source vertex becomes one vertex for each different normal that its corners have.
pub(crate) struct MeshJoin {
    /// The result so far.
    pub mesh: Mesh,
    /// Per source vertex the first copy.
    first: Vec<u32>,
    /// Per copy the next copy of the same source vertex.
    next: Vec<u32>,
}

impl MeshJoin {
    /// For a source with this many vertices.
    pub fn new(sources: usize) -> Self {
        Self { mesh: Mesh::default(), first: vec![NONE; sources], next: Vec::new() }
    }

    /// The index of the copy of `source` that has this normal.
    pub fn vertex(&mut self, source: u32, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        let mut at = self.first[source as usize];
        while at != NONE {
            if self.mesh.normals[at as usize].to_array().map(f32::to_bits) == normal.to_array().map(f32::to_bits) {
                return at;
            }
            at = self.next[at as usize];
        }
        let new = self.mesh.positions.len() as u32;
        self.mesh.positions.push(position);
        self.mesh.normals.push(normal);
        self.mesh.uvs.push(uv);
        self.next.push(self.first[source as usize]);
        self.first[source as usize] = new;
        new
    }
}
