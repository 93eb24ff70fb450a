//! From the scene's types to the trace's.

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Camera, Light, Material, Optics};
use rayreel_scenes as scenes;

/// A scene vector in the trace's scalar arithmetic.
pub(crate) fn vec3(v: glam::Vec3) -> Vec3 {
    Vec3::from(v.to_array())
}

/// What the trace keeps of a material.
pub(crate) fn material(m: &scenes::Material) -> Material {
    Material {
        name: m.name.clone(),
        optics: match m.optics {
            scenes::Optics::Opaque => Optics::Opaque,
            scenes::Optics::Mirror => Optics::Mirror,
            scenes::Optics::FresnelMirror => Optics::FresnelMirror,
            scenes::Optics::Dielectric => Optics::Dielectric,
        },
        ior: m.ior,
        specular: vec3(m.specular),
        transmission: vec3(m.transmission),
        cutout: m.alpha_map.is_some(),
    }
}

/// A light; a direction is brought to unit length.
pub(crate) fn light(l: &scenes::Light) -> Light {
    match *l {
        scenes::Light::Point { position, colour } => Light::Point { position: vec3(position), colour: vec3(colour) },
        scenes::Light::Directional { to_light, colour } => {
            Light::Directional { to_light: vec3(to_light).normalized(), colour: vec3(colour) }
        }
    }
}

/// The image plane of a camera over a grid of `columns` x `rows` samples. Trigonometry and the basis are computed in
/// `f64` and rounded once.
pub fn camera(c: &scenes::Camera, columns: u32, rows: u32) -> Camera {
    let to_f64 = |v: glam::Vec3| v.as_dvec3().to_array();
    let (eye, target, up) = (to_f64(c.eye), to_f64(c.target), to_f64(c.up));
    let forward = unit(sub(target, eye));
    let right = unit(cross(forward, up));
    let up = cross(right, forward);
    let half_height = libm::tan(f64::from(c.vfov_deg).to_radians() * 0.5);
    let step = 2.0 * half_height / f64::from(rows);
    let half_width = step * f64::from(columns) * 0.5;
    let corner: [f64; 3] = std::array::from_fn(|i| (forward[i] - right[i] * half_width) + up[i] * half_height);
    let round = |v: [f64; 3]| Vec3::from(v.map(|x| x as f32));
    Camera {
        eye: vec3(c.eye),
        corner: round(corner),
        right: round(right.map(|x| x * step)),
        down: round(up.map(|x| -x * step)),
    }
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = ((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]).sqrt();
    v.map(|x| x / length)
}
