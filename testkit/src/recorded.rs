//! A recorded frame as trees of boxes, for the slow second implementation.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays;
use rayreel_formats::scene::{Camera, Light};
use rayreel_formats::tile::{RayKind, RayNode, Tile, composite};
use rayreel_replay::TileSource;

use crate::rules::{Hit, Surface};

/// Number of rays: primary, reflection, refraction, shadow.
pub type Rays = [u64; 4];

/// All recorded samples of a frame, row by row.
pub struct Frame {
    pub width: usize,
    pub height: usize,
    pub recorded: Vec<Hit>,
    /// Per sample the rays of each of its hits.
    pub rays: Vec<Vec<Rays>>,
    pub camera: Camera,
    pub lights: Vec<Light>,
}

/// Reads a frame. Unless `deep`, a sample is its primary hit with the rays of all.
pub fn read<S: TileSource>(source: &S, frame: u32, deep: bool) -> Frame {
    let meta = source.meta();
    let (width, height) = (meta.grid().0 as usize, meta.grid().1 as usize);
    let camera = source.camera(frame).unwrap();
    let mut recorded = vec![None; width * height];
    let mut rays = vec![Vec::new(); width * height];
    for index in 0..meta.tile_count() {
        let tile = source.tile(frame, index).unwrap();
        for sample in 0..tile.rect.len() {
            let x = tile.rect.x as usize + sample % tile.rect.width as usize;
            let y = tile.rect.y as usize + sample / tile.rect.width as usize;
            let range = tile.tree.sample(sample);
            rays[y * width + x] = tile.tree.nodes[range.clone()].iter().map(rays_of).collect();
            let mut next = range.start;
            let mut hit = tree(source, &tile, &mut next, range.start);
            assert_eq!(next, range.end, "the tree is the sample");
            let ray = rays::primary(&camera, x as u32, y as u32);
            if let Some(surface) = &mut hit.surface {
                surface.position = (ray.origin + ray.direction * tile.hits[range.start].t).to_array();
            }
            if !deep {
                hit.colour = composite(&tile.tree.nodes[range.clone()], &tile.radiance[range]).to_array();
                hit.below = [None, None];
                hit.own_rays = hit.rays;
            }
            recorded[y * width + x] = Some(hit);
        }
    }
    let recorded = recorded.into_iter().map(|k| k.expect("tiles cover the frame")).collect();
    Frame { width, height, recorded, rays, camera, lights: meta.lights.clone() }
}

/// The tree whose root is recorded as hit `next`, which moves past it.
fn tree<S: TileSource>(source: &S, tile: &Tile, next: &mut usize, first: usize) -> Hit {
    let at = *next;
    *next += 1;
    let (node, hit, radiance) = (&tile.tree.nodes[at], &tile.hits[at], &tile.radiance[at]);
    let surface = node.hit.then(|| Surface {
        object: source.object_of(hit.triangle),
        shadows: node.shadows.0,
        normal: hit.normal.decode().to_array(),
        position: Vec3::ZERO.to_array(),
        t: hit.t,
    });
    let mut child = |on: bool, weight: Vec3| on.then(|| (weight.to_array(), Box::new(tree(source, tile, next, first))));
    let below = [child(node.reflect, radiance.reflect.to_vec3()), child(node.refract, radiance.refract.to_vec3())];
    let own_rays = rays_of(node).iter().sum::<u64>() as u32;
    Hit::new(at - first, surface, radiance.local.to_vec3().to_array(), own_rays, below)
}

/// The rays of a recorded hit.
fn rays_of(node: &RayNode) -> Rays {
    let mut rays = [0; 4];
    rays[node.class.kind() as usize] += 1;
    rays[RayKind::Shadow as usize] += node.shadows.cast().count() as u64;
    rays
}
