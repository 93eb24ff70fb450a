//! Verification: rebuilds every ray of a trace, traverses the stored BVH again, and checks every path, hit, shadow
//! state, normal and weight, bit for bit. No scene is needed.
//!
//! Three things cannot be checked without the scene: local colours; whether a surface is so dark that it casts no
//! shadow rays; and what a cut-out texture says at a texel. There the recorded outcome is believed, and what follows
//! from it is checked.

use rayon::prelude::*;
use rayreel_formats::Result;
use rayreel_formats::bvh::Bvh;
use rayreel_formats::error::first_error;
use rayreel_formats::half::Half3;
use rayreel_formats::math::Vec3;
use rayreel_formats::rays::{self, Geometry, Ray, RayRebuilder, Surface};
use rayreel_formats::scene::{Light, Optics};
use rayreel_formats::tile::{Column, Hit, Radiance, RayKind, RayNode, ShadowState, Tile, step};
use rayreel_formats::trace::{Scratch as CodecScratch, Trace};

use crate::traverse::{RayHit, TraversalBvh, TraversalScratch};
use crate::{shading, wording};

/// What a verification found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verified {
    /// Tiles checked.
    pub tiles: u64,
    /// Rays traversed again.
    pub rays: u64,
    /// Steps compared.
    pub steps: u64,
    /// Tiles that differ.
    pub tiles_wrong: u64,
    /// Of the tiles checked those that hold no paths: their hits and shadow states were checked, their steps were not.
    pub without_paths: u64,
    /// Tiles that were not checked: they lack another column, or paths where a cut-out says what a ray passes.
    pub unchecked: u64,
    /// The first difference, by frame and tile.
    pub first: Option<Mismatch>,
}

impl Verified {
    /// Adds what was found in a later tile.
    fn add(&mut self, later: Self) {
        self.tiles += later.tiles;
        self.rays += later.rays;
        self.steps += later.steps;
        self.tiles_wrong += later.tiles_wrong;
        self.without_paths += later.without_paths;
        self.unchecked += later.unchecked;
        self.first = self.first.take().or(later.first);
    }
}

/// Something in a trace that does not follow from the rest of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// Frame number.
    pub frame: u32,
    /// Tile number.
    pub tile: u32,
    /// Column of the sample in the frame's grid.
    pub x: u32,
    /// Row of the sample.
    pub y: u32,
    /// What was recorded, and what follows.
    pub detail: String,
}

/// Verifies all tiles that a trace holds. After each batch `progress` is told the number of tiles done, and stops the
/// verification by returning false.
///
/// # Errors
/// When a tile is damaged.
pub fn verify(trace: &Trace, mut progress: impl FnMut(u64) -> bool) -> Result<Verified> {
    let traversal = TraversalBvh::new(trace.bvh());
    // What a cut-out lets pass only the paths say.
    let decided = !trace.bvh().materials.iter().any(|material| material.cutout);
    let missing = trace.missing_tiles();
    let every = |frame| (0..trace.meta().tile_count()).map(move |tile| (frame, tile));
    let tiles: Vec<(u32, u32)> =
        trace.meta().frame_numbers().flat_map(every).filter(|t| missing.binary_search(t).is_err()).collect();
    let mut total = Verified::default();
    for batch in tiles.chunks(64 * rayon::current_num_threads()) {
        let check = |scratch: &mut (CodecScratch, TraversalScratch), &(frame, tile): &(u32, u32)| {
            let readable = trace.readable(frame, tile)?;
            let needed = if decided { &Column::ALL[..3] } else { &Column::ALL[..] };
            if needed.iter().any(|column| !readable.contains(column)) {
                return Ok(Verified { unchecked: 1, ..Verified::default() });
            }
            let content = trace.tile_with(frame, tile, &readable, &mut scratch.0)?;
            TileCheck::new(trace, &traversal, &content, frame).map(|mut check| check.run(&mut scratch.1))
        };
        for one in first_error(batch.par_iter().map_init(Default::default, check))? {
            total.add(one);
        }
        if !progress(total.tiles + total.unchecked) {
            break;
        }
    }
    Ok(total)
}

/// The check of one tile.
struct TileCheck<'a> {
    trace: &'a Trace,
    bvh: &'a Bvh,
    traversal: &'a TraversalBvh,
    tile: &'a Tile,
    rebuilt: RayRebuilder<'a>,
    has_paths: bool,
    parents: Vec<u32>,
    /// Per node the product of the weights from the eye, once its parent was checked.
    weights: Vec<Vec3>,
    counts: Verified,
}

impl<'a> TileCheck<'a> {
    fn new(trace: &'a Trace, traversal: &'a TraversalBvh, tile: &'a Tile, frame: u32) -> Result<TileCheck<'a>> {
        let bvh = trace.bvh();
        let camera = trace.camera(frame)?;
        let geometry = Geometry { bvh, camera };
        let rebuilt = RayRebuilder::new(&tile.tree, tile.rect, geometry);
        let weights = vec![Vec3::ONE; tile.tree.nodes.len()];
        let has_paths = tile.paths.spans.len() == tile.tree.ray_count() as usize;
        let counts = Verified { tiles: 1, without_paths: u64::from(!has_paths), ..Verified::default() };
        Ok(Self { has_paths, trace, bvh, traversal, tile, rebuilt, parents: tile.tree.parents(), weights, counts })
    }

    fn run(&mut self, scratch: &mut TraversalScratch) -> Verified {
        let index = self.tile.tree.ray_index();
        for sample in 0..self.tile.tree.samples() {
            for node in self.tile.tree.sample(sample) {
                if let Err(detail) = self.node(sample as u32, node, index[node] as usize, scratch) {
                    let Tile { frame, index: tile, rect, .. } = *self.tile;
                    let (x, y) = (rect.x + sample as u32 % rect.width, rect.y + sample as u32 / rect.width);
                    self.counts.tiles_wrong = 1;
                    self.counts.first = Some(Mismatch { frame, tile, x, y, detail });
                    return std::mem::take(&mut self.counts);
                }
            }
        }
        std::mem::take(&mut self.counts)
    }

    /// Checks a closest-hit ray, whose number is `ray`, and its shadow rays.
    fn node(&mut self, sample: u32, index: usize, ray: usize, scratch: &mut TraversalScratch) -> Result<(), String> {
        let node = self.tile.tree.nodes[index];
        let hit = self.tile.hits[index];
        let name = format!("{} ray of class {}", node.class.kind().name(), node.class.0);
        let rebuilt = self.rebuilt.ray(sample, node.class, index as u32);
        let found = self.traverse::<false>(&rebuilt, ray, &name, scratch)?.0;
        let found = match found {
            None if !node.hit => return Ok(()),
            Some(found) if node.hit => found,
            _ => return Err(format!("{name}: recorded as {}, is not", if node.hit { "a hit" } else { "a miss" })),
        };
        if (found.triangle, found.t.to_bits()) != (hit.triangle, hit.t.to_bits()) {
            let (a, b) = ((hit.triangle, hit.t), (found.triangle, found.t));
            return Err(format!("{name}: hit recorded as {}, is {}", wording::hit(a), wording::hit(b)));
        }
        let normal = self.bvh.shading_normal(hit.triangle as usize, found.u, found.v);
        if normal != hit.normal {
            let (a, b) = (wording::normal(hit.normal), wording::normal(normal));
            return Err(format!("{name}: code of the normal recorded as {a}, is {b}"));
        }
        let surface = self.rebuilt.hit(index as u32, &hit).ok_or("the hit has no ray")?;
        self.children(index, &node, &hit, &surface, &rebuilt)?;
        self.shadows(&node, &surface, ray, &name, scratch)
    }

    /// Checks which children there are and what they weigh: as many as material, depth and weight limit ask for.
    fn children(
        &mut self,
        index: usize,
        node: &RayNode,
        hit: &Hit,
        surface: &Surface,
        ray: &Ray,
    ) -> Result<(), String> {
        let meta = self.trace.meta();
        if node.class.parent().is_some() {
            let parent = self.parents[index] as usize;
            let Radiance { reflect, refract, .. } = self.tile.radiance[parent];
            let weight = if node.class.kind() == RayKind::Reflection { reflect } else { refract };
            self.weights[index] = self.weights[parent].times(weight.to_vec3());
        }
        let traced = |weight: &Half3| {
            let total = self.weights[index].times(weight.to_vec3()).max_component();
            node.class.depth() < meta.max_depth && total > meta.min_weight
        };
        let expected = rays::children(surface, ray.direction, self.bvh.material(hit.triangle as usize));
        let radiance = self.tile.radiance[index];
        for (name, recorded, expected) in [
            ("reflection", node.reflect.then_some(radiance.reflect), expected.reflect.filter(traced)),
            ("refraction", node.refract.then_some(radiance.refract), expected.refract.filter(traced)),
        ] {
            if recorded != expected {
                let (a, b) = (wording::weight(recorded), wording::weight(expected));
                return Err(format!("the {name}'s weight is recorded as {a}, is {b}"));
            }
        }
        Ok(())
    }

    fn shadows(
        &mut self,
        node: &RayNode,
        surface: &Surface,
        ray: usize,
        name: &str,
        scratch: &mut TraversalScratch,
    ) -> Result<(), String> {
        // A surface that has a shadow ray to one light has them to all lights on its side.
        let faced = |(_, light): &(usize, &Light)| shading::faces(surface, light);
        let missing = |(light, _): &(usize, &Light)| node.shadows.get(*light) == ShadowState::NotCast;
        let lights = || self.trace.meta().lights.iter().enumerate();
        if let Some((light, _)) = lights().filter(faced).find(missing).filter(|_| node.shadows.count() > 0) {
            return Err(format!("{name}: lacks its shadow ray to light {light}"));
        }
        for (rank, light) in node.shadows.cast().enumerate() {
            let source = &self.trace.meta().lights[light];
            let name = format!("{name}, shadow ray to light {light}");
            if !shading::faces(surface, source) {
                return Err(format!("{name}: the light is behind the surface"));
            }
            let shadow = rays::shadow(surface, source);
            let (hit, passed) = self.traverse::<true>(&shadow, ray + 1 + rank, &name, scratch)?;
            let state = shading::shadow_state(hit.is_some(), passed);
            let recorded = node.shadows.get(light);
            if state != recorded {
                let (a, b) = (wording::shadow_name(recorded), wording::shadow_name(state));
                return Err(format!("{name}: recorded as {a}, is {b}"));
            }
        }
        Ok(())
    }

    /// Traverses a ray again and compares its path. Gives what it hit, and whether it passed a dielectric.
    fn traverse<const ANY_HIT: bool>(
        &mut self,
        ray: &Ray,
        number: usize,
        name: &str,
        scratch: &mut TraversalScratch,
    ) -> Result<(Option<RayHit>, bool), String> {
        let recorded = if self.has_paths { self.tile.paths.ray(number) } else { &[] };
        // The recorded outcomes of the triangles that were hit, in order. Only cut-outs are decided by them.
        let mut met = recorded.iter().filter(|&&s| s == step::HIT || s == step::PASS);
        let mut passed = false;
        scratch.steps.clear();
        let pass = |triangle: u32, _, _| {
            let recorded_pass = met.next() == Some(&step::PASS);
            let material = self.bvh.material(triangle as usize);
            let dielectric = ANY_HIT && material.optics == Optics::Dielectric;
            passed |= dielectric;
            dielectric || (material.cutout && recorded_pass)
        };
        let hit = if ANY_HIT {
            self.traversal.any_hit::<true>(ray, scratch, pass)
        } else {
            self.traversal.closest_hit::<true>(ray, scratch, pass)
        };
        self.counts.rays += 1;
        if !self.has_paths {
            return Ok((hit, passed));
        }
        self.counts.steps += scratch.steps.len() as u64;
        if scratch.steps != recorded {
            let at = scratch.steps.iter().zip(recorded).take_while(|(a, b)| a == b).count();
            let (a, b) = (wording::step_name(recorded.get(at)), wording::step_name(scratch.steps.get(at)));
            return Err(format!("{name}: step {at} of the path recorded as {a}, is {b}"));
        }
        Ok((hit, passed))
    }
}
