//! The formulas: primary, shadow, reflection and refraction rays, and the weights of the latter two.

use crate::half::Half3;
use crate::math::Vec3;
use crate::oct::Oct;
use crate::scene::{Camera, Light, Material, Optics};

/// A ray; hits count from `t` above 0 to below `t_max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, scene units.
    pub origin: Vec3,
    /// Direction; of unit length but for shadow rays to a point light, which end at `t` = 1.
    pub direction: Vec3,
    /// Upper end of the ray, in units of the direction's length.
    pub t_max: f32,
}

/// The primary ray through the centre of sample (`x`, `y`) of the frame's sample grid.
#[inline]
pub fn primary(camera: &Camera, x: u32, y: u32) -> Ray {
    let along = camera.right * (x as f32 + 0.5);
    let across = camera.down * (y as f32 + 0.5);
    let direction = ((camera.corner + along) + across).normalized();
    Ray { origin: camera.eye, direction, t_max: f32::MAX }
}

/// A hit point with its normals turned towards the incoming ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The hit point, `origin + direction * t`.
    pub point: Vec3,
    /// Unit normal of the triangle's plane, on the side that the ray comes from.
    pub face: Vec3,
    /// Unit shading normal, on the same side.
    pub normal: Vec3,
    /// Cosine between `normal` and the reversed ray, above 0.
    pub cosine: f32,
    /// The ray meets the triangle's front (its corners run counter-clockwise): it comes from outside.
    pub front: bool,
    /// Distance by which new rays start off the surface.
    pub offset: f32,
}

/// New rays start this fraction of the largest coordinate (of the hit point, or `t`) off the surface: 64 units in the
/// last place of the position's rounding error.
const OFFSET: f32 = 1.0 / 131_072.0;

/// The surface at parameter `t` of `ray` on the triangle `corners` with shading normal `normal`.
#[inline]
pub fn surface(ray: &Ray, t: f32, corners: [Vec3; 3], normal: Oct) -> Surface {
    let point = ray.origin + ray.direction * t;
    let mut face = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    let mut normal = normal.decode();
    let front = face.dot(ray.direction) < 0.0;
    if !front {
        (face, normal) = (-face, -normal);
    }
    let mut cosine = -normal.dot(ray.direction);
    // A smooth normal can point away from a ray at grazing angles; the face normal then takes its place.
    if cosine <= 0.0 {
        normal = face;
        cosine = -face.dot(ray.direction);
    }
    let reach = point.max_abs();
    let offset = (if reach > t { reach } else { t }) * OFFSET;
    Surface { point, face, normal, cosine, front, offset }
}

/// The vector from the start of a shadow ray to the light: to the light's position, or the unit direction.
#[inline]
pub fn to_light(surface: &Surface, light: &Light) -> Vec3 {
    match *light {
        Light::Point { position, .. } => position - (surface.point + surface.face * surface.offset),
        Light::Directional { to_light, .. } => to_light,
    }
}

/// The shadow ray towards `light`.
#[inline]
pub fn shadow(surface: &Surface, light: &Light) -> Ray {
    let t_max = match light {
        Light::Point { .. } => 1.0,
        Light::Directional { .. } => f32::MAX,
    };
    let origin = surface.point + surface.face * surface.offset;
    Ray { origin, direction: to_light(surface, light), t_max }
}

/// The mirror reflection of `direction`. Where a smooth normal would send it below the face, the face normal mirrors.
#[inline]
pub fn reflection(surface: &Surface, direction: Vec3) -> Ray {
    let mirror = |n: Vec3| direction - n * (2.0 * direction.dot(n));
    let mut reflected = mirror(surface.normal);
    if reflected.dot(surface.face) <= 0.0 {
        reflected = mirror(surface.face);
    }
    let origin = surface.point + surface.face * surface.offset;
    Ray { origin, direction: reflected.normalized(), t_max: f32::MAX }
}

/// Snell's law at a surface: the ratio of the indices and the cosine on the far side.
struct Snell {
    eta: f32,
    cosine: f32,
}

/// `None` at total internal reflection.
#[inline]
fn snell(surface: &Surface, cosine: f32, ior: f32) -> Option<Snell> {
    let eta = if surface.front { 1.0 / ior } else { ior };
    let k = 1.0 - (eta * eta) * (1.0 - cosine * cosine);
    if k > 0.0 { Some(Snell { eta, cosine: k.sqrt() }) } else { None }
}

/// The refraction of `direction` into or out of a body of index `ior`; `None` at total internal reflection. Where a
/// smooth normal would keep it on the near side, the face normal refracts.
#[inline]
pub fn refraction(surface: &Surface, direction: Vec3, ior: f32) -> Option<Ray> {
    let bend = |n: Vec3, cosine: f32| {
        let snell = snell(surface, cosine, ior)?;
        Some(direction * snell.eta + n * (snell.eta * cosine - snell.cosine))
    };
    let mut bent = bend(surface.normal, surface.cosine)?;
    if bent.dot(surface.face) >= 0.0 {
        bent = bend(surface.face, -surface.face.dot(direction))?;
    }
    let origin = surface.point - surface.face * surface.offset;
    Some(Ray { origin, direction: bent.normalized(), t_max: f32::MAX })
}

/// Weights of the secondary rays of a hit; `None` where the material spawns none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Children {
    /// Weight of the reflection.
    pub reflect: Option<Half3>,
    /// Weight of the refraction.
    pub refract: Option<Half3>,
}

/// What `material` sends on from `surface`, before depth limit and weight cut-off.
#[inline]
pub fn children(surface: &Surface, direction: Vec3, material: &Material) -> Children {
    let only = |weight: Vec3| Children { reflect: Some(Half3::from_vec3(weight)), refract: None };
    match material.optics {
        Optics::Opaque => Children::default(),
        Optics::Mirror => only(material.specular),
        Optics::FresnelMirror => only(schlick(material.specular, surface.cosine)),
        Optics::Dielectric => {
            // The ray itself decides: it may exist by the face normal where the shading normal reflects totally.
            let Some(far) = snell(surface, surface.cosine, material.ior) else {
                return only(material.specular);
            };
            if refraction(surface, direction, material.ior).is_none() {
                return only(material.specular);
            }
            let fresnel = fresnel(surface.cosine, &far);
            Children {
                reflect: Some(Half3::from_vec3(material.specular * fresnel)),
                refract: Some(Half3::from_vec3(material.transmission * (1.0 - fresnel))),
            }
        }
    }
}

/// Schlick's approximation per channel, `f0 + (1 - f0) (1 - cosine)^5`.
#[inline]
fn schlick(f0: Vec3, cosine: f32) -> Vec3 {
    let m = 1.0 - cosine;
    let m5 = ((m * m) * (m * m)) * m;
    f0 + (Vec3::ONE - f0) * m5
}

/// Unpolarised Fresnel reflectance of a dielectric.
#[inline]
fn fresnel(cosine: f32, far: &Snell) -> f32 {
    let s = (far.eta * cosine - far.cosine) / (far.eta * cosine + far.cosine);
    let p = (cosine - far.eta * far.cosine) / (cosine + far.eta * far.cosine);
    (s * s + p * p) * 0.5
}
