//! Closest-hit rays, rebuilt one by one from the hits that they hang on.

use super::formulas::{Ray, Surface, primary, reflection, refraction, surface as surface_at};
use crate::bvh::Bvh;
use crate::math::Vec3;
use crate::scene::{Camera, Rect};
use crate::tile::{Hit, RayClass, RayNode, Tree};

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
    /// Per node its place in `known`, if rays hang on its hit.
    places: Vec<u32>,
    /// The hits that rays hang on, as far as they are known.
    known: Vec<Option<KnownHit>>,
    /// The ray that was given last, and its node.
    last: Option<(u32, Ray)>,
}

/// A hit with the ray that met it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownHit {
    /// Direction of the ray.
    pub direction: Vec3,
    /// Where it met what.
    pub surface: Surface,
    /// The triangle that it met.
    pub triangle: u32,
}

/// The place of a node on whose hit no ray hangs.
const NO_PLACE: u32 = u32::MAX;

impl<'a> RayRebuilder<'a> {
    /// Nothing is known yet but the shape of the trees.
    pub fn new(tree: &Tree, rect: Rect, geometry: Geometry<'a>) -> Self {
        let mut count = 0;
        let place = |node: &RayNode| {
            let place = if node.reflect || node.refract { count } else { NO_PLACE };
            count += u32::from(place != NO_PLACE);
            place
        };
        let places = tree.nodes.iter().map(place).collect();
        let (parents, known) = (tree.parents(), vec![None; count as usize]);
        Self { rect, geometry, parents, places, known, last: None }
    }

    /// All hits that rays hang on are known.
    pub fn of(tree: &Tree, rect: Rect, geometry: Geometry<'a>, hits: &[Hit]) -> Self {
        let mut rays = Self::new(tree, rect, geometry);
        for sample in 0..tree.samples() {
            for index in tree.sample(sample) {
                let (node, hit) = (&tree.nodes[index], &hits[index]);
                if node.hit && (node.reflect || node.refract) {
                    rays.ray(sample as u32, node.class, index as u32);
                    rays.hit(index as u32, hit);
                }
            }
        }
        rays
    }

    /// What it rebuilds them from.
    pub fn geometry(&self) -> Geometry<'a> {
        self.geometry
    }

    /// The ray of node `node`, whose parent's hit must be known. A stored tree can ask for a refraction where there is
    /// none; the ray then goes straight on.
    #[inline]
    pub fn ray(&mut self, sample: u32, class: RayClass, node: u32) -> Ray {
        let ray = match self.parent(class, node) {
            None => {
                let (x, y) = (sample % self.rect.width, sample / self.rect.width);
                primary(&self.geometry.camera, self.rect.x + x, self.rect.y + y)
            }
            Some(KnownHit { direction, surface, triangle }) if class.0 % 2 == 1 => {
                let ior = self.geometry.bvh.material(*triangle as usize).ior;
                let straight = Ray { origin: surface.point, direction: *direction, t_max: f32::MAX };
                refraction(surface, *direction, ior).unwrap_or(straight)
            }
            Some(KnownHit { direction, surface, .. }) => reflection(surface, *direction),
        };
        self.last = Some((node, ray));
        ray
    }

    /// The hit that the ray of a node hangs on.
    fn parent(&self, class: RayClass, node: u32) -> Option<&KnownHit> {
        class.parent()?;
        self.known(self.parents[node as usize])
    }

    /// The hit of a node on which rays hang, if it was noted.
    pub fn known(&self, node: u32) -> Option<&KnownHit> {
        self.known.get(self.places[node as usize] as usize)?.as_ref()
    }

    /// Notes where the ray of `node`, the one that was given last, ended, and gives the surface there.
    pub fn hit(&mut self, node: u32, hit: &Hit) -> Option<Surface> {
        let (_, ray) = self.last.filter(|(last, _)| *last == node)?;
        let corners = self.geometry.bvh.corners(hit.triangle as usize);
        let surface = surface_at(&ray, hit.t, corners, hit.normal);
        if let Some(known) = self.known.get_mut(self.places[node as usize] as usize) {
            *known = Some(KnownHit { direction: ray.direction, surface, triangle: hit.triangle });
        }
        Some(surface)
    }
}
