//! Whitted ray trees: from a sample to its nodes, hits, colours and paths.

use rayreel_formats::half::Half3;
use rayreel_formats::math::Vec3;
use rayreel_formats::oct::Oct;
use rayreel_formats::rays::{self, Ray, Surface};
use rayreel_formats::scene::{Camera, Light, MAX_LIGHTS, Rect};
use rayreel_formats::tile::{Hit, Radiance, RayClass, RayNode, Shadows, Tile};
use rayreel_scenes::Scene;

use crate::accel::Built;
use crate::convert;
use crate::grid::TraceSettings;
use crate::materials::SceneMaterials;
use crate::shading::{self, ShadingInputs, SkyGradient};
use crate::traverse::{LANES, LaneHits, PacketRays, RayHit, TraversalBvh};
use crate::waves::{WaitingRay, Waves};

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

/// Primary rays walk together in blocks of so many columns and rows of samples.
const BLOCK: (u32, u32) = (4, 2);

/// A child ray that the material asks for.
enum ChildRay {
    /// It is traced.
    Traced(WaitingRay),
    /// It is not: the limit of depth or weight ends the path here.
    Truncated(Ray),
}

/// A packet of rays of one class.
struct Packet<'p> {
    class: RayClass,
    rays: &'p [WaitingRay],
    /// Width of the ray cones per unit of length.
    spread: f32,
}

/// A hit that is being shaded.
#[derive(Clone, Copy)]
struct Shaded {
    hit: RayHit,
    normal: Oct,
    surface: Surface,
    inputs: ShadingInputs,
    /// Light so far.
    colour: Vec3,
    shadows: Shadows,
}

/// The children of a wave, class by class.
#[derive(Default)]
struct NextWaves {
    reflections: Vec<WaitingRay>,
    refractions: Vec<WaitingRay>,
}

/// Spans of the paths of one packet: per lane the closest-hit ray's and those of its shadow rays.
struct LaneSpans {
    spans: [[(u32, u32); 1 + MAX_LIGHTS]; LANES],
    counts: [usize; LANES],
}

impl LaneSpans {
    fn push(&mut self, lane: usize, span: (u32, u32)) {
        self.spans[lane][self.counts[lane]] = span;
        self.counts[lane] += 1;
    }
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
        self.samples::<RECORD>(camera, rect).into_tile(rect, frame, index)
    }

    /// The colours of the samples of `rect`, row by row: what a render needs and no more.
    pub fn colours(&self, camera: &Camera, rect: Rect) -> Vec<Vec3> {
        self.samples::<false>(camera, rect).colours()
    }

    fn samples<const RECORD: bool>(&self, camera: &Camera, rect: Rect) -> Waves {
        let mut waves = Waves::new(rect.len());
        let spread = (camera.down.length() / camera.corner.length()).max(0.0);
        let mut primaries = Vec::with_capacity(rect.len());
        for top in (0..rect.height).step_by(BLOCK.1 as usize) {
            for left in (0..rect.width).step_by(BLOCK.0 as usize) {
                for y in top..(top + BLOCK.1).min(rect.height) {
                    for x in left..(left + BLOCK.0).min(rect.width) {
                        let ray = rays::primary(camera, rect.x + x, rect.y + y);
                        let node = y * rect.width + x;
                        primaries.push(WaitingRay { ray, node, weight: Vec3::ONE, travelled: 0.0 });
                    }
                }
            }
        }
        self.wave::<RECORD>(RayClass::PRIMARY, &primaries, spread, &mut waves);
        waves
    }

    /// Traces the rays of one class, then those of the classes that hang on it.
    fn wave<const RECORD: bool>(&self, class: RayClass, rays: &[WaitingRay], spread: f32, waves: &mut Waves) {
        let mut next = NextWaves::default();
        for rays in rays.chunks(LANES) {
            self.packet::<RECORD>(&Packet { class, rays, spread }, waves, &mut next);
        }
        for (class, rays) in [(class.reflection(), next.reflections), (class.refraction(), next.refractions)] {
            if !rays.is_empty() {
                self.wave::<RECORD>(class, &rays, spread, waves);
            }
        }
    }

    /// Traces a packet and its shadow rays.
    fn packet<const RECORD: bool>(&self, packet: &Packet<'_>, waves: &mut Waves, next: &mut NextWaves) {
        let lanes = packet.rays.len();
        let rays = std::array::from_fn(|lane| packet.rays[lane.min(lanes - 1)].ray);
        let together = PacketRays { rays, mask: u8::MAX >> (LANES - lanes) };
        let hits = self.traversal.packet::<RECORD, false>(&together, &mut waves.packets, |_, triangle, u, v| {
            self.materials.cut_out(triangle, u, v)
        });
        let mut spans = LaneSpans { spans: [[(0, 0); 1 + MAX_LIGHTS]; LANES], counts: [0; LANES] };
        if RECORD {
            (0..lanes).for_each(|lane| spans.push(lane, waves.keep(lane)));
        }
        let mut shaded = self.shade(packet, &hits);
        self.light::<RECORD>(packet, &mut shaded, waves, &mut spans);
        for (lane, (state, shaded)) in packet.rays.iter().zip(&shaded).enumerate() {
            if RECORD {
                waves.nodes[state.node as usize].spans = waves.spans.len() as u32;
                waves.spans.extend_from_slice(&spans.spans[lane][..spans.counts[lane]]);
            }
            match shaded {
                Some(shaded) => self.finish(packet.class, state, shaded, waves, next),
                None => {
                    let local = Half3::from_vec3(self.sky.colour(state.ray.direction));
                    waves.nodes[state.node as usize].radiance = Radiance { local, ..Radiance::default() };
                }
            }
        }
    }

    /// Surfaces and materials where rays hit.
    fn shade(&self, packet: &Packet<'_>, hits: &LaneHits) -> [Option<Shaded>; LANES] {
        let mut shaded = [None; LANES];
        for ((state, hit), shaded) in packet.rays.iter().zip(hits).zip(&mut shaded) {
            let Some(hit) = *hit else { continue };
            let normal = self.built.bvh.shading_normal(hit.triangle as usize, hit.u, hit.v);
            let surface = rays::surface(&state.ray, hit.t, self.traversal.corners(hit.triangle), normal);
            let cone_width = (state.travelled + hit.t) * packet.spread;
            let inputs = self.materials.at(&hit, &surface, cone_width);
            let colour = inputs.emission + self.sky.ambient.times(inputs.diffuse);
            *shaded = Some(Shaded { hit, normal, surface, inputs, colour, shadows: Shadows(0) });
        }
        shaded
    }

    /// Traces the shadow rays of a packet, light by light, notes their states, and adds the light that arrives.
    fn light<const RECORD: bool>(
        &self,
        packet: &Packet<'_>,
        shaded: &mut [Option<Shaded>; LANES],
        waves: &mut Waves,
        spans: &mut LaneSpans,
    ) {
        for (index, light) in self.lights.iter().enumerate() {
            let (mut rays, mut mask) = ([packet.rays[0].ray; LANES], 0);
            for (lane, shaded) in shaded.iter().enumerate() {
                let Some(shaded) = shaded else { continue };
                let dark = shaded.inputs.diffuse == Vec3::ZERO && shaded.inputs.specular == Vec3::ZERO;
                if !dark && shading::faces(&shaded.surface, light) {
                    rays[lane] = rays::shadow(&shaded.surface, light);
                    mask |= 1 << lane;
                }
            }
            if mask == 0 {
                continue;
            }
            let (mut tints, mut passed) = ([Vec3::ONE; LANES], [false; LANES]);
            let pass = |lane: usize, triangle, u, v| {
                self.materials.lets_light_through(triangle, u, v, &mut tints[lane], &mut passed[lane])
            };
            let met = self.traversal.packet::<RECORD, true>(&PacketRays { rays, mask }, &mut waves.packets, pass);
            for (lane, shaded) in shaded.iter_mut().enumerate() {
                let Some(shaded) = shaded.as_mut().filter(|_| mask >> lane & 1 != 0) else { continue };
                let blocked = met[lane].is_some();
                shaded.shadows.set(index, shading::shadow_state(blocked, passed[lane]));
                if !blocked {
                    let direction = packet.rays[lane].ray.direction;
                    let lit = shading::lit(&shaded.surface, direction, &shaded.inputs, light);
                    shaded.colour = shaded.colour + tints[lane].times(lit);
                }
                if RECORD {
                    spans.push(lane, waves.keep(lane));
                }
            }
        }
    }

    /// Notes a shaded hit, and puts its children into the next waves.
    fn finish(&self, class: RayClass, state: &WaitingRay, shaded: &Shaded, waves: &mut Waves, next: &mut NextWaves) {
        let Shaded { hit, surface, mut colour, shadows, .. } = *shaded;
        let direction = state.ray.direction;
        let material = self.built.bvh.material(hit.triangle as usize);
        let weights = rays::children(&surface, direction, material);
        let reflect = || Some(rays::reflection(&surface, direction));
        let reflection = self.child(class, state, weights.reflect, hit.t, reflect);
        let refract = || rays::refraction(&surface, direction, material.ior);
        let refraction = self.child(class, state, weights.refract, hit.t, refract);
        // A truncated child shows the sky. In a bright room that is darker than the truth, but leaves no black
        // speckles.
        for (weight, child) in [(weights.reflect, &reflection), (weights.refract, &refraction)] {
            if let (Some(weight), Some(ChildRay::Truncated(ray))) = (weight, child) {
                colour = colour + weight.to_vec3().times(self.sky.colour(ray.direction));
            }
        }
        let mut queue = |child, class, queue: &mut Vec<WaitingRay>| match child {
            Some(ChildRay::Traced(ray)) => {
                let node = waves.wait(class);
                queue.push(WaitingRay { node, ..ray });
                Some(node)
            }
            _ => None,
        };
        let reflection = queue(reflection, class.reflection(), &mut next.reflections);
        let refraction = queue(refraction, class.refraction(), &mut next.refractions);
        let (reflect, refract) = (reflection.is_some(), refraction.is_some());
        let kept = |weight: Option<Half3>, traced| if traced { weight.unwrap_or_default() } else { Half3::ZERO };
        let traced = &mut waves.nodes[state.node as usize];
        traced.node = RayNode { class, hit: true, reflect, refract, shadows };
        traced.hit = Hit { triangle: hit.triangle, t: hit.t, normal: shaded.normal };
        traced.radiance = Radiance {
            local: Half3::from_vec3(colour),
            reflect: kept(weights.reflect, reflect),
            refract: kept(weights.refract, refract),
        };
        traced.children = [reflection.unwrap_or(0), refraction.unwrap_or(0)];
    }

    /// A child ray, traced or truncated; none where the material sends none.
    fn child(
        &self,
        class: RayClass,
        parent: &WaitingRay,
        weight: Option<Half3>,
        t: f32,
        ray: impl FnOnce() -> Option<Ray>,
    ) -> Option<ChildRay> {
        let (weight, ray) = (parent.weight.times(weight?.to_vec3()), ray()?);
        let deeper = class.depth() < self.settings.max_depth;
        if !deeper || weight.max_component() <= self.settings.min_weight {
            return Some(ChildRay::Truncated(ray));
        }
        Some(ChildRay::Traced(WaitingRay { ray, node: 0, weight, travelled: parent.travelled + t }))
    }
}
