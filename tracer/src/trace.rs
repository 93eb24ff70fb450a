//! Whitted ray trees: from a sample to its nodes, hits, colours and paths.

use rayreel_formats::half::Half3;
use rayreel_formats::math::Vec3;
use rayreel_formats::rays::{self, Ray, Surface};
use rayreel_formats::scene::{Camera, Light, Rect};
use rayreel_formats::tile::{Hit, Paths, Radiance, RayClass, RayNode, Shadows, Tile, Tree, composite};
use rayreel_scenes::Scene;

use crate::accel::Built;
use crate::convert;
use crate::grid::TraceSettings;
use crate::materials::SceneMaterials;
use crate::shading::{self, SkyGradient};
use crate::traverse::{RayHit, TraversalBvh, TraversalScratch};

/// A scene ready to be traced.
#[derive(Debug)]
pub struct Tracer<'a> {
    built: &'a Built,
    traversal: TraversalBvh,
    materials: SceneMaterials<'a>,
    sky: SkyGradient,
    lights: Vec<Light>,
    settings: TraceSettings,
}

/// The columns of a tile so far, and the memory to fill them.
#[derive(Debug, Default)]
struct TileBuilder {
    nodes: Vec<RayNode>,
    hits: Vec<Hit>,
    radiance: Vec<Radiance>,
    spans: Vec<(u32, u32)>,
    scratch: TraversalScratch,
}

impl TileBuilder {
    fn push(&mut self, node: RayNode, hit: Hit, radiance: Radiance) {
        self.nodes.push(node);
        self.hits.push(hit);
        self.radiance.push(radiance);
    }
}

/// A ray, with what its children need to know of the path so far.
#[derive(Clone, Copy)]
struct RayState {
    ray: Ray,
    class: RayClass,
    /// Product of the weights from the eye.
    weight: Vec3,
    /// Length of the path from the eye to the ray's origin.
    travelled: f32,
    /// Width of the ray cone per unit of length.
    spread: f32,
}

/// A child ray that the material asks for.
enum ChildRay {
    /// It is traced.
    Traced(RayState),
    /// It is not: the limit of depth or weight ends the path here.
    Truncated(Ray),
}

impl<'a> Tracer<'a> {
    /// Prepares a scene and its BVH.
    pub fn new(scene: &'a Scene, built: &'a Built, settings: TraceSettings) -> Self {
        Self {
            built,
            traversal: TraversalBvh::new(&built.bvh),
            materials: SceneMaterials::new(scene, built),
            sky: SkyGradient::new(&scene.sky),
            lights: scene.lights.iter().map(convert::light).collect(),
            settings,
        }
    }

    /// The BVH that rays traverse.
    pub fn traversal(&self) -> &TraversalBvh {
        &self.traversal
    }

    /// Traces the samples of `rect`; with `RECORD`, the paths too.
    pub fn tile<const RECORD: bool>(&self, camera: &Camera, rect: Rect, frame: u32, index: u32) -> Tile {
        let mut out = TileBuilder::default();
        let mut first = Vec::with_capacity(rect.len() + 1);
        let spread = (camera.down.length() / camera.corner.length()).max(0.0);
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                first.push(out.nodes.len() as u32);
                let ray = rays::primary(camera, x, y);
                let class = RayClass::PRIMARY;
                let state = RayState { ray, class, weight: Vec3::ONE, travelled: 0.0, spread };
                self.trace::<RECORD>(state, &mut out);
            }
        }
        first.push(out.nodes.len() as u32);
        let TileBuilder { nodes, hits, radiance, spans, scratch } = out;
        let paths = Paths { steps: scratch.steps, spans };
        Tile { frame, index, rect, tree: Tree { first, nodes }, hits, radiance, paths }
    }

    /// The colours of the samples of `rect`, row by row: what a render needs and no more.
    pub fn colours(&self, camera: &Camera, rect: Rect) -> Vec<Vec3> {
        let tile = self.tile::<false>(camera, rect, 0, 0);
        let colour = |sample| {
            let nodes = tile.tree.sample(sample);
            composite(&tile.tree.nodes[nodes.clone()], &tile.radiance[nodes])
        };
        (0..tile.tree.samples()).map(colour).collect()
    }

    /// Traces a ray, its shadow rays and, depth first, its children.
    fn trace<const RECORD: bool>(&self, state: RayState, out: &mut TileBuilder) {
        let RayState { ray, class, .. } = state;
        let hit = self.recorded::<RECORD, _>(out, |scratch| {
            self.traversal.closest_hit::<RECORD>(&ray, scratch, |triangle, u, v| self.materials.cut_out(triangle, u, v))
        });
        let mut node = RayNode { class, hit: hit.is_some(), reflect: false, refract: false, shadows: Shadows(0) };
        let Some(hit) = hit else {
            let local = Half3::from_vec3(self.sky.colour(ray.direction));
            out.push(node, Hit::MISS, Radiance { local, ..Radiance::default() });
            return;
        };
        let normal = self.built.bvh.shading_normal(hit.triangle as usize, hit.u, hit.v);
        let surface = rays::surface(&ray, hit.t, self.traversal.corners(hit.triangle), normal);
        let mut local = self.local::<RECORD>(&state, &hit, &surface, &mut node.shadows, out);
        let material = self.built.bvh.material(hit.triangle as usize);
        let children = rays::children(&surface, ray.direction, material);
        let reflection = self.child(&state, children.reflect, class.reflection(), hit.t, || {
            Some(rays::reflection(&surface, ray.direction))
        });
        let refraction = self.child(&state, children.refract, class.refraction(), hit.t, || {
            rays::refraction(&surface, ray.direction, material.ior)
        });
        // A truncated child shows the sky. In a bright room that is darker than the truth, but leaves no black
        // speckles.
        for (weight, child) in [(children.reflect, &reflection), (children.refract, &refraction)] {
            if let (Some(weight), Some(ChildRay::Truncated(ray))) = (weight, child) {
                local = local + weight.to_vec3().times(self.sky.colour(ray.direction));
            }
        }
        let traced = |child: &Option<ChildRay>| matches!(child, Some(ChildRay::Traced(_)));
        (node.reflect, node.refract) = (traced(&reflection), traced(&refraction));
        let kept = |weight: Option<Half3>, traced| if traced { weight.unwrap_or_default() } else { Half3::ZERO };
        let radiance = Radiance {
            local: Half3::from_vec3(local),
            reflect: kept(children.reflect, node.reflect),
            refract: kept(children.refract, node.refract),
        };
        out.push(node, Hit { triangle: hit.triangle, t: hit.t, normal }, radiance);
        for child in [reflection, refraction] {
            if let Some(ChildRay::Traced(child)) = child {
                self.trace::<RECORD>(child, out);
            }
        }
    }

    /// Runs one traversal and, with `RECORD`, keeps the span of its steps.
    #[inline(always)]
    fn recorded<const RECORD: bool, T>(
        &self,
        out: &mut TileBuilder,
        walk: impl FnOnce(&mut TraversalScratch) -> T,
    ) -> T {
        let start = out.scratch.steps.len() as u32;
        let result = walk(&mut out.scratch);
        if RECORD {
            out.spans.push((start, out.scratch.steps.len() as u32 - start));
        }
        result
    }

    /// A child ray, traced or truncated; none where the material sends none.
    fn child(
        &self,
        parent: &RayState,
        weight: Option<Half3>,
        class: RayClass,
        t: f32,
        ray: impl FnOnce() -> Option<Ray>,
    ) -> Option<ChildRay> {
        let (weight, ray) = (parent.weight.times(weight?.to_vec3()), ray()?);
        let deeper = parent.class.depth() < self.settings.max_depth;
        if !deeper || weight.max_component() <= self.settings.min_weight {
            return Some(ChildRay::Truncated(ray));
        }
        let travelled = parent.travelled + t;
        Some(ChildRay::Traced(RayState { ray, class, weight, travelled, spread: parent.spread }))
    }

    /// The local colour of a hit. Traces its shadow rays and notes their states in `shadows`.
    fn local<const RECORD: bool>(
        &self,
        state: &RayState,
        hit: &RayHit,
        surface: &Surface,
        shadows: &mut Shadows,
        out: &mut TileBuilder,
    ) -> Vec3 {
        let cone_width = (state.travelled + hit.t) * state.spread;
        let inputs = self.materials.at(hit, surface, cone_width);
        let mut colour = inputs.emission + self.sky.ambient.times(inputs.diffuse);
        if inputs.diffuse == Vec3::ZERO && inputs.specular == Vec3::ZERO {
            return colour;
        }
        for (index, light) in self.lights.iter().enumerate() {
            if !shading::faces(surface, light) {
                continue;
            }
            let ray = rays::shadow(surface, light);
            let (mut tint, mut passed) = (Vec3::ONE, false);
            let blocked = self.recorded::<RECORD, _>(out, |scratch| {
                let pass = |triangle, u, v| self.materials.lets_light_through(triangle, u, v, &mut tint, &mut passed);
                self.traversal.any_hit::<RECORD>(&ray, scratch, pass).is_some()
            });
            shadows.set(index, shading::shadow_state(blocked, passed));
            if !blocked {
                colour = colour + tint.times(shading::lit(surface, state.ray.direction, &inputs, light));
            }
        }
        colour
    }
}
