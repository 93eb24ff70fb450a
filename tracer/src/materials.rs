//! The materials of a scene, as rays meet them: textures at a hit, cut-outs, light through dielectrics.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayreel_formats::math::Vec3;
use rayreel_formats::rays::Surface;
use rayreel_formats::scene::Optics;
use rayreel_scenes::{Material, Scene};

use crate::accel::Built;
use crate::convert;
use crate::shading::ShadingInputs;
use crate::texture::{CutOut, MipTexture, approximate_log2};
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
    /// Of each material its texture of colour. Those that share one and cut it out in the same way share it here.
    colours: Vec<Option<Arc<MipTexture>>>,
    /// Of each material the texture that cuts it out.
    holes: Vec<Option<Arc<CutOut>>>,
    uvs: Vec<TriangleUv>,
}

impl<'a> SceneMaterials<'a> {
    pub(crate) fn new(scene: &'a Scene, built: &'a Built) -> Self {
        let (mut colours, mut holes) = (BTreeMap::new(), BTreeMap::new());
        let mut colour = |material: &Material| {
            let (map, alpha) = (material.diffuse_map?, material.alpha_map);
            let make = || Arc::new(MipTexture::new(&scene.textures[map], alpha.map(|alpha| &scene.textures[alpha])));
            Some(Arc::clone(colours.entry((map, alpha)).or_insert_with(make)))
        };
        let mut hole = |material: &Material| {
            let make = |map: usize| Arc::new(CutOut::new(&scene.textures[map]));
            material.alpha_map.map(|map| Arc::clone(holes.entry(map).or_insert_with(|| make(map))))
        };
        Self {
            scene,
            built,
            colours: scene.materials.iter().map(&mut colour).collect(),
            holes: scene.materials.iter().map(&mut hole).collect(),
            uvs: built.source.iter().map(|&t| triangle_uv(scene, t as usize)).collect(),
        }
    }

    #[inline]
    fn number(&self, triangle: u32) -> usize {
        self.built.bvh.triangles[triangle as usize].material as usize
    }

    #[inline]
    fn material(&self, triangle: u32) -> &Material {
        &self.scene.materials[self.number(triangle)]
    }

    /// Whether the cut-out texture of a triangle lets every ray pass at these barycentric weights.
    #[inline]
    pub(crate) fn cut_out(&self, triangle: u32, u: f32, v: f32) -> bool {
        let holes = &self.holes[self.number(triangle)];
        holes.as_ref().is_some_and(|holes| holes.is_transparent(self.uv(triangle, u, v)))
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
        if let Some(texture) = &self.colours[self.number(hit.triangle)] {
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

fn triangle_uv(scene: &Scene, triangle: usize) -> TriangleUv {
    let vertices = scene.mesh.triangles[triangle].vertices.map(|v| v as usize);
    let corners = vertices.map(|v| scene.mesh.uvs[v].to_array());
    let [p, q, r] = vertices.map(|v| convert::vec3(scene.mesh.positions[v]));
    let area = (q - p).cross(r - p).length();
    let [a, b, c] = corners;
    let uv_area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    TriangleUv { corners, density: if area > 0.0 { uv_area.abs() / area } else { 0.0 } }
}

#[cfg(test)]
mod tests {
    use rayreel_scenes::builtin;

    use super::*;
    use crate::accel::build;

    /// An atlas of leaves and bark: what is a hole for the one is seen of the other.
    #[test]
    fn each_use_of_a_texture_has_the_means_of_what_it_shows() {
        let mut scene = builtin("cornell").unwrap();
        let half = |x: usize| if x < 4 { [255, 0, 0, 255] } else { [0, 0, 255, 0] };
        let texels = (0..64).map(|at| half(at % 8)).collect();
        let atlas =
            rayreel_scenes::Texture { name: "atlas".into(), width: 8, height: 8, texels, wrap: Default::default() };
        scene.textures = vec![atlas];
        scene.materials.iter_mut().for_each(|material| (material.diffuse_map, material.alpha_map) = (Some(0), None));
        scene.materials[1].alpha_map = Some(0);
        let built = build(&scene).unwrap();
        let found = SceneMaterials::new(&scene, &built);
        let far = |material: usize| found.colours[material].as_ref().unwrap().colour([0.5, 0.5], 9.0);
        assert!((far(0) - rayreel_formats::math::vec3(0.5, 0.0, 0.5)).max_abs() < 1e-3);
        assert!((far(1) - rayreel_formats::math::vec3(1.0, 0.0, 0.0)).max_abs() < 1e-3);
        assert!(Arc::ptr_eq(found.colours[0].as_ref().unwrap(), found.colours[2].as_ref().unwrap()));
        assert!(found.holes[0].is_none() && found.holes[1].is_some());
    }

    #[test]
    fn a_shadow_loses_nothing_to_a_surface_that_reflects_nothing() {
        let mut scene = builtin("cornell").unwrap();
        let glass = scene.materials.iter().position(|material| material.optics == rayreel_scenes::Optics::Dielectric);
        let glass = glass.unwrap();
        for (ior, kept) in [(1.0, 1.0), (1.5, 0.96)] {
            scene.materials[glass].ior = ior;
            let built = build(&scene).unwrap();
            let triangle = (0..).find(|&t| built.bvh.triangles[t].material as usize == glass).unwrap();
            let (mut tint, mut passed) = (Vec3::ONE, false);
            let found = SceneMaterials::new(&scene, &built);
            assert!(found.lets_light_through(triangle as u32, 0.3, 0.3, &mut tint, &mut passed) && passed);
            assert_eq!(tint, convert::vec3(scene.materials[glass].transmission) * kept);
        }
    }
}
