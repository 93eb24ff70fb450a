//! Whitted ray trees: from a sample to its nodes, hits, colours and paths.

use rayreel_formats::half::Half3;
use rayreel_formats::math::Vec3;
use rayreel_formats::rays::{self, Ray, Surface};
use rayreel_formats::scene::{Camera, Light, Optics, Rect};
use rayreel_formats::tile::{Hit, Paths, Radiance, RayClass, RayNode, Shadows, Tile, Tree, composite};
use rayreel_scenes::Scene;

use crate::accel::Built;
use crate::convert;
use crate::shade::{self, Finish, Sky};
use crate::texture::{Texture, approximate_log2};
use crate::traverse::{Accel, RayHit, Scratch};

/// Transmittance of an unpolarised dielectric surface at normal incidence for an index of 1.5: what a shadow ray keeps, beside
/// the tint, at each surface that it passes.
const SHADOW_TRANSMITTANCE: f32 = 0.96;

/// How deep a ray tree grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Secondary bounces allowed.
    pub max_depth: u32,
    /// Largest weight component below which no child is spawned.
    pub min_weight: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { max_depth: 4, min_weight: 0.01 }
    }
}

/// Texture coordinates of a triangle and how many texture areas it covers per unit of its own area.
#[derive(Debug)]
struct TextureMap {
    uv: [[f32; 2]; 3],
    density: f32,
}

/// A scene ready to be traced.
#[derive(Debug)]
pub struct Tracer<'a> {
    scene: &'a Scene,
    built: &'a Built,
    accel: Accel,
    textures: Vec<Texture>,
    maps: Vec<TextureMap>,
    sky: Sky,
    lights: Vec<Light>,
    settings: Settings,
}

/// The growing columns of a tile and the memory to fill them.
#[derive(Debug, Default)]
struct Growing {
    nodes: Vec<RayNode>,
    hits: Vec<Hit>,
    radiance: Vec<Radiance>,
    spans: Vec<(u32, u32)>,
    scratch: Scratch,
}

/// A ray on its way, with what its tree needs to know of it.
#[derive(Clone, Copy)]
struct Traveller {
    ray: Ray,
    class: RayClass,
    /// Product of the weights from the eye.
    weight: Vec3,
    /// Length of the path from the eye to the ray's origin.
    travelled: f32,
    /// Width of the ray cone per unit of length.
    spread: f32,
}

impl<'a> Tracer<'a> {
    /// Prepares a scene and its BVH.
    pub fn new(scene: &'a Scene, built: &'a Built, settings: Settings) -> Self {
        Self {
            scene,
            built,
            accel: Accel::new(&built.bvh),
            textures: scene.textures.iter().map(Texture::new).collect(),
            maps: built.source.iter().map(|&t| texture_map(scene, t as usize)).collect(),
            sky: Sky::new(&scene.sky),
            lights: scene.lights.iter().map(convert::light).collect(),
            settings,
        }
    }

    /// The traversal structure.
    pub fn accel(&self) -> &Accel {
        &self.accel
    }

    /// Traces the samples of `rect`; with `RECORD`, the paths too.
    pub fn tile<const RECORD: bool>(&self, camera: &Camera, rect: Rect, frame: u32, index: u32) -> Tile {
        let mut growing = Growing::default();
        let mut first = Vec::with_capacity(rect.len() + 1);
        let spread = (camera.down.length() / camera.corner.length()).max(0.0);
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                first.push(growing.nodes.len() as u32);
                let ray = rays::primary(camera, x, y);
                let class = RayClass::PRIMARY;
                let traveller = Traveller { ray, class, weight: Vec3::ONE, travelled: 0.0, spread };
                self.grow::<RECORD>(traveller, &mut growing);
            }
        }
        first.push(growing.nodes.len() as u32);
        let Growing { nodes, hits, radiance, spans, scratch } = growing;
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
    fn grow<const RECORD: bool>(&self, traveller: Traveller, growing: &mut Growing) {
        let Traveller { ray, class, .. } = traveller;
        let hit = self.recorded::<RECORD, _>(growing, |scratch| {
            self.accel.closest::<RECORD>(&ray, scratch, |triangle, u, v| self.cut_out(triangle, u, v))
        });
        let mut node = RayNode { class, hit: hit.is_some(), reflect: false, refract: false, shadows: Shadows(0) };
        let Some(hit) = hit else {
            let local = Half3::from_vec3(self.sky.colour(ray.direction));
            growing.nodes.push(node);
            growing.hits.push(Hit::MISS);
            growing.radiance.push(Radiance { local, ..Radiance::default() });
            return;
        };
        let normal = self.built.bvh.shading_normal(hit.triangle as usize, hit.u, hit.v);
        let surface = rays::surface(&ray, hit.t, self.accel.corners(hit.triangle), normal);
        let mut local = self.local::<RECORD>(&traveller, &hit, &surface, &mut node.shadows, growing);
        let children = rays::children(&surface, ray.direction, self.built.bvh.material(hit.triangle as usize));
        let reflection = self.child(&traveller, children.reflect, class.reflection(), hit.t, || {
            Some(rays::reflection(&surface, ray.direction))
        });
        let ior = self.built.bvh.material(hit.triangle as usize).ior;
        let refraction = self.child(&traveller, children.refract, class.refraction(), hit.t, || {
            rays::refraction(&surface, ray.direction, ior)
        });
        // A child that the limits cut off shows the sky: darker than true in a bright room, but no black speckles.
        for (weight, child) in [(children.reflect, &reflection), (children.refract, &refraction)] {
            if let (Some(weight), Some(Cut::Off(ray))) = (weight, child) {
                local = local + weight.to_vec3().times(self.sky.colour(ray.direction));
            }
        }
        let grown = |child: &Option<Cut>| matches!(child, Some(Cut::Grows(_)));
        (node.reflect, node.refract) = (grown(&reflection), grown(&refraction));
        let kept = |weight: Option<Half3>, grows| if grows { weight.unwrap_or_default() } else { Half3::ZERO };
        growing.nodes.push(node);
        growing.hits.push(Hit { triangle: hit.triangle, t: hit.t, normal });
        growing.radiance.push(Radiance {
            local: Half3::from_vec3(local),
            reflect: kept(children.reflect, node.reflect),
            refract: kept(children.refract, node.refract),
        });
        for child in [reflection, refraction] {
            if let Some(Cut::Grows(child)) = child {
                self.grow::<RECORD>(child, growing);
            }
        }
    }

    /// Runs one traversal and notes where its steps stand.
    #[inline(always)]
    fn recorded<const RECORD: bool, T>(&self, growing: &mut Growing, walk: impl FnOnce(&mut Scratch) -> T) -> T {
        let start = growing.scratch.steps.len() as u32;
        let result = walk(&mut growing.scratch);
        if RECORD {
            growing.spans.push((start, growing.scratch.steps.len() as u32 - start));
        }
        result
    }

    /// A child ray, grown or cut off by depth or weight.
    fn child(
        &self,
        parent: &Traveller,
        weight: Option<Half3>,
        class: RayClass,
        t: f32,
        ray: impl FnOnce() -> Option<Ray>,
    ) -> Option<Cut> {
        let (weight, ray) = (parent.weight.times(weight?.to_vec3()), ray()?);
        let deeper = parent.class.depth() < self.settings.max_depth;
        if !deeper || weight.max_component() <= self.settings.min_weight {
            return Some(Cut::Off(ray));
        }
        let travelled = parent.travelled + t;
        Some(Cut::Grows(Traveller { ray, class, weight, travelled, spread: parent.spread }))
    }

    /// Local colour of a hit, with its shadow rays traced and their states noted.
    fn local<const RECORD: bool>(
        &self,
        traveller: &Traveller,
        hit: &RayHit,
        surface: &Surface,
        shadows: &mut Shadows,
        growing: &mut Growing,
    ) -> Vec3 {
        let finish = self.finish(traveller, hit, surface);
        let mut colour = finish.emission + self.sky.ambient.times(finish.diffuse);
        if finish.diffuse == Vec3::ZERO && finish.specular == Vec3::ZERO {
            return colour;
        }
        for (index, light) in self.lights.iter().enumerate() {
            if !shade::faces(surface, light) {
                continue;
            }
            let ray = rays::shadow(surface, light);
            let (mut tint, mut passed) = (Vec3::ONE, false);
            let blocked = self.recorded::<RECORD, _>(growing, |scratch| {
                self.accel.any::<RECORD>(&ray, scratch, |triangle, u, v| {
                    self.lets_light_through(triangle, u, v, &mut tint, &mut passed)
                })
            });
            shadows.set(index, shade::shadow_state(blocked, passed));
            if !blocked {
                colour = colour + tint.times(shade::lit(surface, traveller.ray.direction, &finish, light));
            }
        }
        colour
    }

    /// Whether the cut-out texture of a triangle lets every ray pass at these barycentric weights.
    #[inline]
    fn cut_out(&self, triangle: u32, u: f32, v: f32) -> bool {
        let material = &self.scene.materials[self.built.bvh.triangles[triangle as usize].material as usize];
        let Some(map) = material.alpha_map else { return false };
        self.textures[map].is_transparent(self.uv(triangle, u, v))
    }

    /// Whether a shadow ray passes a triangle; a dielectric does not stop it, and tints the light where it is not cut out.
    fn lets_light_through(&self, triangle: u32, u: f32, v: f32, tint: &mut Vec3, passed: &mut bool) -> bool {
        let cut_out = self.cut_out(triangle, u, v);
        let material = self.built.bvh.material(triangle as usize);
        if material.optics != Optics::Dielectric {
            return cut_out;
        }
        *passed = true;
        if !cut_out {
            *tint = tint.times(material.transmission * SHADOW_TRANSMITTANCE);
        }
        true
    }

    fn uv(&self, triangle: u32, u: f32, v: f32) -> [f32; 2] {
        let [a, b, c] = self.maps[triangle as usize].uv;
        std::array::from_fn(|i| (a[i] * ((1.0 - u) - v) + b[i] * u) + c[i] * v)
    }

    /// The material at a hit, with its texture looked up at the width of the ray cone.
    fn finish(&self, traveller: &Traveller, hit: &RayHit, surface: &Surface) -> Finish {
        let material = &self.scene.materials[self.built.bvh.triangles[hit.triangle as usize].material as usize];
        let mut diffuse = convert::vec3(material.diffuse);
        if let Some(map) = material.diffuse_map {
            let texture = &self.textures[map];
            let width = (traveller.travelled + hit.t) * traveller.spread;
            let texels = self.maps[hit.triangle as usize].density * texture.area();
            let lod = 0.5 * approximate_log2(texels * (width * width) / surface.cosine.max(0.05));
            diffuse = diffuse.times(texture.colour(self.uv(hit.triangle, hit.u, hit.v), lod));
        }
        Finish {
            diffuse,
            specular: convert::vec3(material.specular),
            shininess: material.shininess,
            emission: convert::vec3(material.emission),
        }
    }
}

/// What became of a child ray.
enum Cut {
    /// It is traced.
    Grows(Traveller),
    /// A limit cut it off.
    Off(Ray),
}

fn texture_map(scene: &Scene, triangle: usize) -> TextureMap {
    let vertices = scene.mesh.triangles[triangle].vertices.map(|v| v as usize);
    let uv = vertices.map(|v| scene.mesh.uvs[v].to_array());
    let [p, q, r] = vertices.map(|v| convert::vec3(scene.mesh.positions[v]));
    let area = (q - p).cross(r - p).length();
    let uv_area = (uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) - (uv[2][0] - uv[0][0]) * (uv[1][1] - uv[0][1]);
    TextureMap { uv, density: if area > 0.0 { uv_area.abs() / area } else { 0.0 } }
}
