//! The materials of a scene, as rays meet them: textures at a hit, cut-outs, light through dielectrics.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays::Surface;
use rayreel_formats::scene::Optics;
use rayreel_scenes::{Material, Scene, Texture};

use crate::accel::Built;
use crate::convert;
use crate::shading::ShadingInputs;
use crate::texture::{MipTexture, approximate_log2};
use crate::traverse::RayHit;

/// What a shadow ray keeps, beside the tint, at each dielectric surface that it passes and that reflects: the transmittance for
/// unpolarised light at normal incidence and an index of 1.5.
const SHADOW_TRANSMITTANCE: f32 = 0.96;

/// Texture coordinates of a triangle.
#[derive(Debug)]
struct TriangleUv {
    corners: [[f32; 2]; 3],
    /// Area in the texture, whose whole area is one, over area in the scene.
    density: f32,
}

/// The materials and textures of a scene, by triangles in leaf order.
#[derive(Debug)]
pub(crate) struct SceneMaterials<'a> {
    scene: &'a Scene,
    built: &'a Built,
    textures: Vec<MipTexture>,
    uvs: Vec<TriangleUv>,
}

impl<'a> SceneMaterials<'a> {
    pub(crate) fn new(scene: &'a Scene, built: &'a Built) -> Self {
        Self {
            scene,
            built,
            textures: (0..scene.textures.len())
                .map(|map| MipTexture::new(&scene.textures[map], holes(scene, map)))
                .collect(),
            uvs: built.source.iter().map(|&t| triangle_uv(scene, t as usize)).collect(),
        }
    }

    #[inline]
    fn material(&self, triangle: u32) -> &Material {
        &self.scene.materials[self.built.bvh.triangles[triangle as usize].material as usize]
    }

    /// Whether the cut-out texture of a triangle lets every ray pass at these barycentric weights.
    #[inline]
    pub(crate) fn cut_out(&self, triangle: u32, u: f32, v: f32) -> bool {
        let Some(map) = self.material(triangle).alpha_map else { return false };
        self.textures[map].is_transparent(self.uv(triangle, u, v))
    }

    /// Whether a shadow ray passes a triangle. A dielectric does not stop it, sets `passed`, and tints the light
    /// where it is not cut out.
    pub(crate) fn lets_light_through(&self, triangle: u32, u: f32, v: f32, tint: &mut Vec3, passed: &mut bool) -> bool {
        let cut_out = self.cut_out(triangle, u, v);
        let material = self.built.bvh.material(triangle as usize);
        if material.optics != Optics::Dielectric {
            return cut_out;
        }
        *passed = true;
        if !cut_out {
            // Plain transparency, of index 1, reflects nothing.
            let kept = if material.ior == 1.0 { 1.0 } else { SHADOW_TRANSMITTANCE };
            *tint = tint.times(material.transmission * kept);
        }
        true
    }

    /// The material at a hit, with its texture looked up where the ray cone is `cone_width` wide.
    pub(crate) fn at(&self, hit: &RayHit, surface: &Surface, cone_width: f32) -> ShadingInputs {
        let material = self.material(hit.triangle);
        let mut diffuse = convert::vec3(material.diffuse);
        if let Some(map) = material.diffuse_map {
            let texture = &self.textures[map];
            let texels = self.uvs[hit.triangle as usize].density * texture.area();
            let lod = 0.5 * approximate_log2(texels * (cone_width * cone_width) / surface.cosine.max(0.05));
            diffuse = diffuse.times(texture.colour(self.uv(hit.triangle, hit.u, hit.v), lod));
        }
        ShadingInputs {
            diffuse,
            specular: convert::vec3(material.specular),
            shininess: material.shininess,
            emission: convert::vec3(material.emission),
        }
    }

    fn uv(&self, triangle: u32, u: f32, v: f32) -> [f32; 2] {
        let [a, b, c] = self.uvs[triangle as usize].corners;
        std::array::from_fn(|i| (a[i] * ((1.0 - u) - v) + b[i] * u) + c[i] * v)
    }
}

/// The texture that cuts texture `map` out, if all materials that take their colour from it name the same one.
fn holes(scene: &Scene, map: usize) -> Option<&Texture> {
    let mut of = scene.materials.iter().filter(|material| material.diffuse_map == Some(map)).map(|m| m.alpha_map);
    let first = of.next()??;
    // Its own alpha may cut out others.
    let alone = first == map || scene.materials.iter().all(|material| material.alpha_map != Some(map));
    (alone && of.all(|other| other == Some(first))).then(|| &scene.textures[first])
}

fn triangle_uv(scene: &Scene, triangle: usize) -> TriangleUv {
    let vertices = scene.mesh.triangles[triangle].vertices.map(|v| v as usize);
    let corners = vertices.map(|v| scene.mesh.uvs[v].to_array());
    let [p, q, r] = vertices.map(|v| convert::vec3(scene.mesh.positions[v]));
    let area = (q - p).cross(r - p).length();
    let [a, b, c] = corners;
    let uv_area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    TriangleUv { corners, density: if area > 0.0 { uv_area.abs() / area } else { 0.0 } }
}
