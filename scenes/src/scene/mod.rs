//! The scene in memory, as every loader and generator makes it.

mod hash;

use std::path::PathBuf;

use glam::{Vec2, Vec3};

use crate::warnings::Warning;

/// Lights that a trace can hold: two bits each in a 32-bit word.
pub const MAX_LIGHTS: usize = 16;
/// Longest side of a texture, in texels.
pub const MAX_TEXTURE_SIDE: u32 = 16_384;

/// A complete scene: everything that capture needs.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Short name, such as `teapot`; stands in the trace.
    pub name: String,
    /// The triangles.
    pub mesh: Mesh,
    /// Object names; the index is the object id that similarity tests compare.
    pub objects: Vec<String>,
    /// Materials; [`Triangle::material`] indexes them.
    pub materials: Vec<Material>,
    /// Textures; materials index them.
    pub textures: Vec<Texture>,
    /// Lights, at most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// What a ray sees that hits nothing.
    pub sky: Sky,
    /// One camera per frame; at least one.
    pub cameras: Vec<Camera>,
    /// Oddities of the input that were handled, each with a count.
    pub warnings: Vec<Warning>,
    /// The files that it is made of: scene file, model, materials, buffers, pictures, camera path. None of a built-in scene.
    pub files: Vec<PathBuf>,
}

/// An indexed triangle mesh. `positions`, `normals` and `uvs` have the same length.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions, scene units, all finite.
    pub positions: Vec<Vec3>,
    /// Unit shading normals per vertex (on flat faces the face normal).
    pub normals: Vec<Vec3>,
    /// Texture coordinates per vertex; zero where the source has none. `v` points up, as in OBJ.
    pub uvs: Vec<Vec2>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<Triangle>,
}

/// One triangle of a [`Mesh`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Vertex indices.
    pub vertices: [u32; 3],
    /// Index into [`Scene::objects`].
    pub object: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// How a surface sends light on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Optics {
    /// Diffuse with a Phong highlight; spawns no secondary ray (MTL illum 0 to 2).
    Opaque,
    /// Mirror reflection with the constant weight `specular` (MTL illum 3).
    Mirror,
    /// Mirror reflection by Schlick's Fresnel with `specular` at normal incidence (MTL illum 5).
    FresnelMirror,
    /// Dielectric: reflection by the exact Fresnel equations times `specular`, refraction by the rest times
    /// `transmission` (MTL illum 4, 6, 7, 9).
    Dielectric,
}

/// A surface material. Colours are linear RGB.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name, as in the MTL file.
    pub name: String,
    /// Diffuse colour (`Kd`), multiplied by the texture.
    pub diffuse: Vec3,
    /// Specular colour (`Ks`): the Phong highlight and the weight of reflections.
    pub specular: Vec3,
    /// Phong exponent (`Ns`), rounded to an integer so that no `pow` enters a result; at least 1.
    pub shininess: u32,
    /// Emitted radiance (`Ke`).
    pub emission: Vec3,
    /// Kind of secondary rays.
    pub optics: Optics,
    /// Index of refraction (`Ni`) of the inside against the outside, at least 1.
    pub ior: f32,
    /// Tint of a refracted ray per surface crossed (`Tf`, 1 = clear).
    pub transmission: Vec3,
    /// Diffuse texture (`map_Kd`).
    pub diffuse_map: Option<usize>,
    /// Cut-out texture (`map_d`): a ray passes where its alpha is below one half.
    pub alpha_map: Option<usize>,
}

/// An 8-bit image, decoded. The first row is the top one.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Where it came from, for messages.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// RGBA, sRGB-encoded colour, linear alpha; `width * height` texels, row by row. A one-channel image that is used
    /// as `map_d` has its value in alpha.
    pub texels: Vec<[u8; 4]>,
    /// What lies beyond its edges, along `u` and along `v`.
    pub wrap: [Wrap; 2],
}

/// What lies beyond the edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture again, every other time mirrored.
    Mirror,
    /// The texels of the edge.
    Clamp,
}

/// A light without extent: one shadow ray each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines from a point, without distance fall-off (the colour is the irradiance scale at any distance).
    Point {
        /// Position in scene units.
        position: Vec3,
        /// Linear RGB, intensity included.
        colour: Vec3,
    },
    /// Shines from infinity.
    Directional {
        /// Direction towards the light, any length but zero.
        to_light: Vec3,
        /// Linear RGB, intensity included.
        colour: Vec3,
    },
}

/// Gradient behind everything, along +y whatever a camera's `up` is; also the source of ambient light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Linear RGB straight up: along +y.
    pub zenith: Vec3,
    /// Linear RGB at the horizon.
    pub horizon: Vec3,
    /// Linear RGB straight down.
    pub ground: Vec3,
    /// Fraction of the mean sky colour added as ambient light to diffuse surfaces.
    pub ambient: f32,
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub eye: Vec3,
    /// A point on the view axis.
    pub target: Vec3,
    /// Up in the picture, not parallel to the view axis. It does not turn the [`Sky`].
    pub up: Vec3,
    /// Vertical field of view in degrees, between 0 and 180 exclusive.
    pub vfov_deg: f32,
}
