//! Local shading: what a hit contributes without its secondary rays.
//!
//! Emission, ambient light from the mean sky, and for each light that is not blocked Lambert diffuse and a Phong
//! highlight. The Phong exponent is an integer and the sky a polynomial: without `pow` and libm the colours are the same
//! on every machine.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays::{self, Surface};
use rayreel_formats::scene::Light;
use rayreel_formats::tile::ShadowState;
use rayreel_scenes as scenes;

use crate::convert::vec3 as from_glam;

/// The gradient of the sky, in the arithmetic of the trace.
#[derive(Debug)]
pub struct SkyGradient {
    zenith: Vec3,
    horizon: Vec3,
    ground: Vec3,
    /// Ambient light on diffuse surfaces.
    pub ambient: Vec3,
}

impl SkyGradient {
    /// Prepares a scene's sky. Ambient light is its mean colour times the scene's fraction.
    pub fn new(sky: &scenes::Sky) -> Self {
        let (zenith, horizon, ground) = (from_glam(sky.zenith), from_glam(sky.horizon), from_glam(sky.ground));
        let mean = (zenith * 0.35 + horizon * 0.4) + ground * 0.25;
        Self { zenith, horizon, ground, ambient: mean * sky.ambient }
    }

    /// The colour seen along unit direction `d`; the y axis points up.
    pub fn colour(&self, d: Vec3) -> Vec3 {
        let end = if d.y >= 0.0 { self.zenith } else { self.ground };
        // Falls off fast at the horizon, slowly above: 1 - (1 - |y|)^2.
        let rest = 1.0 - d.y.abs().min(1.0);
        let blend = 1.0 - rest * rest;
        self.horizon * (1.0 - blend) + end * blend
    }
}

/// What local shading needs of the material at a hit.
#[derive(Clone, Copy, Debug)]
pub struct ShadingInputs {
    /// Diffuse colour, texture included.
    pub diffuse: Vec3,
    /// Highlight colour.
    pub specular: Vec3,
    /// Phong exponent.
    pub shininess: u32,
    /// Emitted light.
    pub emission: Vec3,
}

/// Whether `light` is on the side of `surface` that is seen. Only then is a shadow ray cast.
pub fn faces(surface: &Surface, light: &Light) -> bool {
    let to_light = rays::to_light(surface, light);
    to_light.dot(surface.face) > 0.0 && to_light.dot(surface.normal) > 0.0
}

/// The light that one visible light adds, reflected to a ray that came along `direction`.
pub fn lit(surface: &Surface, direction: Vec3, inputs: &ShadingInputs, light: &Light) -> Vec3 {
    let (Light::Point { colour, .. } | Light::Directional { colour, .. }) = *light;
    let to_light = rays::to_light(surface, light).normalized();
    let cosine = to_light.dot(surface.normal);
    let mirrored = surface.normal * (2.0 * cosine) - to_light;
    let highlight = (-mirrored.dot(direction)).max(0.0);
    let specular = if highlight > 0.0 { inputs.specular * power(highlight, inputs.shininess) } else { Vec3::ZERO };
    colour.times(inputs.diffuse * cosine + specular)
}

/// The state of a shadow ray that was `blocked` or not, and that `passed` a dielectric surface or not.
pub fn shadow_state(blocked: bool, passed: bool) -> ShadowState {
    match (blocked, passed) {
        (true, _) => ShadowState::Blocked,
        (false, true) => ShadowState::Tinted,
        (false, false) => ShadowState::Lit,
    }
}

/// `base` to a whole power, by squaring.
fn power(base: f32, exponent: u32) -> f32 {
    let (mut result, mut square, mut rest) = (1.0, base, exponent);
    while rest > 0 {
        if rest & 1 == 1 {
            result *= square;
        }
        square *= square;
        rest >>= 1;
    }
    result
}
