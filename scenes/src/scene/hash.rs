//! Content hash and bounds of a scene.

use glam::{Vec2, Vec3};

use super::{Light, Material, Optics, Scene, Wrap};

/// Bumped when the written order below changes, so that old and new hashes never meet.
const LAYOUT: &[u8] = b"rayreel scene content 1\n";

impl Scene {
    /// Smallest and largest corner of all vertices; both zero for a mesh without vertices.
    #[must_use]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let mut positions = self.mesh.positions.iter();
        let Some(&first) = positions.next() else {
            return (Vec3::ZERO, Vec3::ZERO);
        };
        positions.fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)))
    }

    /// BLAKE3 over everything that can change a picture, in a fixed order; floats as their bits,
    /// little-endian.
    ///
    /// Names and warnings are left out: renaming a material changes no ray.
    #[must_use]
    pub fn content_hash(&self) -> [u8; 32] {
        let mut out = SceneHasher::default();
        out.bytes(LAYOUT);
        out.count(self.mesh.positions.len());
        self.mesh.positions.iter().for_each(|p| out.vec3(*p));
        self.mesh.normals.iter().for_each(|n| out.vec3(*n));
        self.mesh.uvs.iter().for_each(|uv| out.vec2(*uv));
        out.count(self.mesh.triangles.len());
        for t in &self.mesh.triangles {
            t.vertices.iter().chain([&t.object, &t.material]).for_each(|v| out.u32(*v));
        }
        out.count(self.objects.len());
        out.count(self.materials.len());
        self.materials.iter().for_each(|m| out.material(m));
        out.count(self.textures.len());
        for texture in &self.textures {
            out.u32(texture.width);
            out.u32(texture.height);
            out.count(texture.texels.len());
            texture.texels.chunks(1024).for_each(|row| out.bytes(row.as_flattened()));
            // Nothing of textures that repeat: scenes without others keep their hash.
            if texture.wrap != [Wrap::Repeat; 2] {
                texture.wrap.into_iter().for_each(|wrap| out.u32(wrap as u32));
            }
        }
        out.count(self.lights.len());
        self.lights.iter().for_each(|l| out.light(l));
        for colour in [self.sky.zenith, self.sky.horizon, self.sky.ground] {
            out.vec3(colour);
        }
        out.f32(self.sky.ambient);
        out.count(self.cameras.len());
        for c in &self.cameras {
            [c.eye, c.target, c.up].into_iter().for_each(|v| out.vec3(v));
            out.f32(c.vfov_deg);
        }
        out.finish()
    }
}

/// Bytes that are hashed at a time: BLAKE3 hashes many of its chunks side by side, but not what comes in fours of bytes.
const BLOCK: usize = 1 << 16;

/// Feeds the hasher in one defined way per type.
#[derive(Default)]
struct SceneHasher {
    hasher: blake3::Hasher,
    /// What waits for a block to be full.
    waiting: Vec<u8>,
}

impl SceneHasher {
    fn bytes(&mut self, bytes: &[u8]) {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= BLOCK {
            self.hasher.update(&self.waiting);
            self.waiting.clear();
        }
    }

    fn finish(mut self) -> [u8; 32] {
        *self.hasher.update(&self.waiting).finalize().as_bytes()
    }

    fn count(&mut self, count: usize) {
        self.bytes(&(count as u64).to_le_bytes());
    }

    fn u32(&mut self, value: u32) {
        self.bytes(&value.to_le_bytes());
    }

    fn f32(&mut self, value: f32) {
        self.u32(value.to_bits());
    }

    fn vec2(&mut self, v: Vec2) {
        self.f32(v.x);
        self.f32(v.y);
    }

    fn vec3(&mut self, v: Vec3) {
        [v.x, v.y, v.z].into_iter().for_each(|c| self.f32(c));
    }

    fn map(&mut self, map: Option<usize>) {
        self.bytes(&map.map_or(u64::MAX, |index| index as u64).to_le_bytes());
    }

    fn material(&mut self, m: &Material) {
        [m.diffuse, m.specular, m.emission, m.transmission].into_iter().for_each(|c| self.vec3(c));
        self.u32(m.shininess);
        self.f32(m.ior);
        self.u32(match m.optics {
            Optics::Opaque => 0,
            Optics::Mirror => 1,
            Optics::FresnelMirror => 2,
            Optics::Dielectric => 3,
        });
        self.map(m.diffuse_map);
        self.map(m.alpha_map);
    }

    fn light(&mut self, light: &Light) {
        let (kind, place, colour) = match *light {
            Light::Point { position, colour } => (0, position, colour),
            Light::Directional { to_light, colour } => (1, to_light, colour),
        };
        self.u32(kind);
        self.vec3(place);
        self.vec3(colour);
    }
}
