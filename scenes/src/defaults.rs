//! What a scene gets when its file says nothing: camera, lights, sky and material.

use glam::{DVec3, Vec3};

use crate::{
    mesh::{meet, normals},
    options::DEFAULT_ASPECT,
    scene::{Camera, Light, Material, Optics, Scene, Sky, Triangle},
};

/// Vertical field of view where none is given, degrees.
pub(crate) const DEFAULT_VFOV_DEG: f32 = 35.0;
/// Ambient fraction where none is given.
pub(crate) const DEFAULT_AMBIENT: f32 = 0.35;

/// Centre and radius of the sphere around a box. A box without extent gets the radius one, so that a camera stands back
/// from it.
fn sphere((low, high): (Vec3, Vec3)) -> (DVec3, f64) {
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let radius = (high - low).length() / 2.0;
    ((low + high) / 2.0, if radius > 0.0 { radius } else { 1.0 })
}

/// The box that a camera should frame. One vertex in a hundred may lie outside at either end of each axis, so that a
/// wide floor of few triangles does not make the model on it small.
pub(crate) fn main_bounds(positions: &[Vec3]) -> (Vec3, Vec3) {
    let (mut low, mut high) = (Vec3::ZERO, Vec3::ZERO);
    // In a small model every vertex counts.
    let outside = if positions.len() < 200 { 0 } else { positions.len() / 100 };
    for axis in 0..3 {
        let mut values: Vec<f32> = positions.iter().map(|p| p[axis]).collect();
        values.sort_by(f32::total_cmp);
        if let Some(&first) = values.get(outside) {
            low[axis] = first;
            high[axis] = values[values.len() - 1 - outside];
        }
    }
    (low, high)
}

/// A camera from the front, the right and above that has the whole box in view at 2:1, and at `aspect` where that is narrower. Y is up.
pub(crate) fn framing_camera(bounds: (Vec3, Vec3), vfov_deg: f32, aspect: f64) -> Camera {
    let aspect = aspect.min(DEFAULT_ASPECT);
    let (centre, radius) = sphere(bounds);
    let (low, high) = (bounds.0.as_dvec3(), bounds.1.as_dvec3());
    // However narrow the view: what it is divided by is not zero.
    let slope = libm::tan((f64::from(vfov_deg).to_radians() / 2.0).clamp(1e-6, 1.5));
    let towards = DVec3::new(0.5, 0.42, 0.76).normalize();
    let right = DVec3::Y.cross(towards).normalize();
    let up = towards.cross(right);
    // Far enough for each corner to be inside the picture, and never inside the box.
    let mut distance = radius * 1.2;
    for corner in 0..8 {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 { low[axis] } else { high[axis] }
        };
        let arm = DVec3::new(pick(0), pick(1), pick(2)) - centre;
        let aside = arm.dot(up).abs().max(arm.dot(right).abs() / aspect);
        distance = distance.max(arm.dot(towards) + 1.08 * aside / slope);
    }
    Camera { eye: (centre + towards * distance).as_vec3(), target: centre.as_vec3(), up: Vec3::Y, vfov_deg }
}

/// A warm key light from the right and a cool fill light from the left, as strong together as one.
pub(crate) fn two_lights(bounds: (Vec3, Vec3)) -> Vec<Light> {
    let (centre, radius) = sphere(bounds);
    let point = |x, y, z, colour| Light::Point { position: (centre + DVec3::new(x, y, z) * radius).as_vec3(), colour };
    vec![point(1.8, 2.6, 1.6, Vec3::new(0.82, 0.79, 0.74)), point(-2.2, 1.9, 0.9, Vec3::new(0.31, 0.34, 0.38))]
}

/// Lights for a scene whose file names none. Lamps of the model (objects that emit) become point
/// lights just in front of them, at most four: rooms are closed, and nothing from outside would
/// light them. What shines to all sides, such as a bulb, gets its light below it, or above where something is in the
/// way; the light comes nearer where nothing is clear. Lamps that stand around all else have it within. A model without lamps gets [`two_lights`].
pub(crate) fn lights(scene: &Scene, bounds: (Vec3, Vec3)) -> Vec<Light> {
    let mut lamps = lamps(scene);
    lamps.retain(|lamp| lamp.area > 0.0);
    // The largest first; the sort is stable, so equal lamps keep the order of the file.
    lamps.sort_by(|a, b| b.area.total_cmp(&a.area));
    lamps.truncate(4);
    if lamps.is_empty() {
        return two_lights(bounds);
    }
    let gap = sphere(bounds).1 * 0.03;
    let intensity = 1.1 / lamps.len() as f32;
    let dark = dark_bounds(scene);
    let position = |lamp: &Lamp| {
        if dark.is_some_and(|dark| lamp.surrounds(dark)) { lamp.inside() } else { in_front(scene, lamp, gap) }
    };
    let light = |lamp: &Lamp| Light::Point {
        position: position(lamp).as_vec3(),
        colour: lamp.emission / lamp.emission.max_element() * intensity,
    };
    lamps.iter().map(light).collect()
}

/// Parts of the gap that are tried, the widest first: above a panel that looks up there may be a ceiling.
const NEARER: [f64; 4] = [1.0, 0.25, 0.0625, 0.015625];

/// The place `gap` in front of a lamp. What looks up, or to all sides, has it nearer where something is in the way.
fn in_front(scene: &Scene, lamp: &Lamp, gap: f64) -> DVec3 {
    let (low, high) = (lamp.low.as_dvec3(), lamp.high.as_dvec3());
    let middle = (low + high) / 2.0;
    let below = |gap: f64| DVec3::new(middle.x, low.y - gap, middle.z);
    let above = |gap: f64| DVec3::new(middle.x, high.y + gap, middle.z);
    let clear = |place: &DVec3| is_clear(scene, middle, *place);
    let mut gaps = NEARER.into_iter().map(|part| gap * part);
    let facing = lamp.facing / lamp.area;
    if facing.y > 0.5 {
        gaps.map(above).find(clear).unwrap_or_else(|| above(gap))
    } else if facing.y < -0.5 {
        below(gap)
    } else if facing.length() > 0.5 {
        let ahead = facing.normalize();
        middle + ahead * ((high - low).dot(ahead.abs()) / 2.0 + gap)
    } else {
        gaps.find_map(|gap| [below(gap), above(gap)].into_iter().find(clear)).unwrap_or_else(|| above(gap))
    }
}

/// Whether nothing lies between two points but what emits.
fn is_clear(scene: &Scene, from: DVec3, to: DVec3) -> bool {
    let (way, mesh) = (to - from, &scene.mesh);
    !mesh.triangles.iter().any(|triangle| {
        let corners = triangle.vertices.map(|v| mesh.positions[v as usize].as_dvec3());
        scene.materials[triangle.material as usize].emission.max_element() <= 0.0
            && meet(corners, from, way).is_some_and(|at| at <= 1.0)
    })
}

/// Whether something in the model emits light.
pub(crate) fn has_lamps(scene: &Scene) -> bool {
    lamps(scene).iter().any(|lamp| lamp.area > 0.0)
}

/// What an object's emitting triangles add up to.
struct Lamp {
    /// Twice the area.
    area: f64,
    /// Sum of twice the area vectors.
    facing: DVec3,
    low: Vec3,
    high: Vec3,
    emission: Vec3,
}

impl Lamp {
    /// Whether it stands around a box, nearly or wholly, as a dome of sky or shining walls do.
    fn surrounds(&self, (low, high): (Vec3, Vec3)) -> bool {
        let middle = (low + high) / 2.0;
        let is_in = middle.cmpge(self.low).all() && middle.cmple(self.high).all();
        is_in && (self.high - self.low).cmpge((high - low) * 0.9).all()
    }

    /// A place in it, well above its middle, where there may be a floor.
    fn inside(&self) -> DVec3 {
        let (low, high) = (self.low.as_dvec3(), self.high.as_dvec3());
        low.lerp(high, 0.5).with_y(low.y + 0.75 * (high.y - low.y))
    }
}

/// The box of what does not emit, if there is anything.
fn dark_bounds(scene: &Scene) -> Option<(Vec3, Vec3)> {
    let is_dark = |triangle: &&Triangle| scene.materials[triangle.material as usize].emission.max_element() <= 0.0;
    let dark = scene.mesh.triangles.iter().filter(is_dark);
    let corners = dark.flat_map(|triangle| triangle.vertices).map(|vertex| scene.mesh.positions[vertex as usize]);
    corners.map(|p| (p, p)).reduce(|(low, high), (p, _)| (low.min(p), high.max(p)))
}

/// One lamp per object; those that emit nothing have no area.
fn lamps(scene: &Scene) -> Vec<Lamp> {
    let dark =
        || Lamp { area: 0.0, facing: DVec3::ZERO, low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, emission: Vec3::ZERO };
    let mut lamps: Vec<Lamp> = scene.objects.iter().map(|_| dark()).collect();
    for triangle in &scene.mesh.triangles {
        let emission = scene.materials[triangle.material as usize].emission;
        if emission.max_element() <= 0.0 {
            continue;
        }
        let lamp = &mut lamps[triangle.object as usize];
        let area = normals::area_vector(&scene.mesh.positions, triangle.vertices);
        lamp.area += area.length();
        lamp.facing += area;
        lamp.emission = lamp.emission.max(emission);
        for vertex in triangle.vertices {
            let p = scene.mesh.positions[vertex as usize];
            (lamp.low, lamp.high) = (lamp.low.min(p), lamp.high.max(p));
        }
    }
    lamps
}

/// A soft blue sky over pale ground.
pub(crate) fn soft_sky() -> Sky {
    Sky {
        zenith: Vec3::new(0.25, 0.42, 0.72),
        horizon: Vec3::new(0.78, 0.84, 0.9),
        ground: Vec3::new(0.3, 0.28, 0.26),
        ambient: DEFAULT_AMBIENT,
    }
}

/// A gentle gradient around one colour: deeper above, paler at the horizon, darker below.
pub(crate) fn sky_around(colour: Vec3) -> Sky {
    Sky {
        zenith: colour * 0.75,
        horizon: colour * 0.6 + Vec3::splat(colour.max_element() * 0.4),
        ground: colour * 0.4,
        ambient: DEFAULT_AMBIENT,
    }
}

/// The material of faces without one, and of faces whose material is unknown.
pub(crate) fn default_material(name: &str) -> Material {
    Material {
        name: name.to_owned(),
        diffuse: Vec3::splat(0.6),
        specular: Vec3::ZERO,
        shininess: 1,
        emission: Vec3::ZERO,
        optics: Optics::Opaque,
        ior: 1.0,
        transmission: Vec3::ONE,
        diffuse_map: None,
        alpha_map: None,
    }
}
