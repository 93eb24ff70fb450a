//! Closest-hit rays, rebuilt one by one from the hits that they hang on.

use super::formulas::{Ray, Surface, primary, reflection, refraction, surface as surface_at};
use crate::bvh::Bvh;
use crate::math::Vec3;
use crate::scene::{Camera, Rect};
use crate::tile::{Hit, RayClass, Tree};

/// What rebuilding rays needs beside the tile.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    /// The scene's triangles and materials.
    pub bvh: &'a Bvh,
    /// The frame's camera.
    pub camera: Camera,
}

/// Rebuilds the closest-hit rays of a tile as the hits that they hang on become known.
#[derive(Debug)]
pub struct RayRebuilder<'a> {
    rect: Rect,
    geometry: Geometry<'a>,
    parents: Vec<u32>,
    /// Per node its ray, and the surface that it hit.
    rays: Vec<Option<Ray>>,
    surfaces: Vec<Option<(Surface, u32)>>,
}

impl<'a> RayRebuilder<'a> {
    /// Nothing is known yet but the shape of the trees.
    pub fn new(tree: &Tree, rect: Rect, geometry: Geometry<'a>) -> Self {
        let nodes = tree.nodes.len();
        Self { rect, geometry, parents: tree.parents(), rays: vec![None; nodes], surfaces: vec![None; nodes] }
    }

    /// The ray of node `node`, whose parent's hit must be known. A stored tree can ask for a refraction where there is
    /// none; the ray then goes straight on.
    pub fn ray(&mut self, sample: u32, class: RayClass, node: u32) -> Ray {
        let ray = match self.parent_surface(class, node) {
            None => {
                let (x, y) = (sample % self.rect.width, sample / self.rect.width);
                primary(&self.geometry.camera, self.rect.x + x, self.rect.y + y)
            }
            Some((direction, surface, triangle)) if class.0 % 2 == 1 => {
                let ior = self.geometry.bvh.material(triangle as usize).ior;
                let straight = Ray { origin: surface.point, direction, t_max: f32::MAX };
                refraction(&surface, direction, ior).unwrap_or(straight)
            }
            Some((direction, surface, _)) => reflection(&surface, direction),
        };
        self.rays[node as usize] = Some(ray);
        ray
    }

    fn parent_surface(&self, class: RayClass, node: u32) -> Option<(Vec3, Surface, u32)> {
        class.parent()?;
        let parent = self.parents[node as usize] as usize;
        let (surface, triangle) = self.surfaces[parent]?;
        Some((self.rays[parent]?.direction, surface, triangle))
    }

    /// Notes where the ray of `node` ended, and gives the surface there.
    pub fn hit(&mut self, node: u32, hit: &Hit) -> Option<Surface> {
        let ray = self.rays[node as usize]?;
        let corners = self.geometry.bvh.corners(hit.triangle as usize);
        let surface = surface_at(&ray, hit.t, corners, hit.normal);
        self.surfaces[node as usize] = Some((surface, hit.triangle));
        Some(surface)
    }
}
