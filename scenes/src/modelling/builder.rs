//! Puts parts, materials and lights together into a [`Scene`].

use glam::{Vec2, Vec3};

use crate::{
    defaults,
    error::SceneError,
    mesh::{MeshJoin, normals},
    modelling::{part::Part, scatter::Cluster},
    scene::{Camera, Light, Material, Mesh, Optics, Scene, Sky, Texture, Triangle},
};

/// A scene under construction.
#[derive(Debug)]
pub struct SceneBuilder {
    scene: Scene,
}

impl SceneBuilder {
    /// An empty scene with the default sky.
    #[must_use]
    pub fn new(name: &str) -> Self {
        let scene = Scene {
            name: name.to_owned(),
            mesh: Mesh::default(),
            objects: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            lights: Vec::new(),
            sky: defaults::soft_sky(),
            cameras: Vec::new(),
            warnings: Vec::new(),
            files: Vec::new(),
        };
        Self { scene }
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Material) -> u32 {
        self.scene.materials.push(material);
        (self.scene.materials.len() - 1) as u32
    }

    /// Adds a texture and returns its index.
    pub fn texture(&mut self, texture: Texture) -> usize {
        self.scene.textures.push(texture);
        self.scene.textures.len() - 1
    }

    /// Adds an object made of one part.
    pub fn object(&mut self, name: &str, part: &Part, material: u32) {
        self.scene.objects.push(name.to_owned());
        self.extend(part, material);
    }

    /// Adds a part to the last object. Normals are not smoothed from part to part.
    pub fn extend(&mut self, part: &Part, material: u32) {
        let positions: Vec<Vec3> = part.positions.iter().map(|p| p.as_vec3()).collect();
        let triangles: Vec<[u32; 3]> =
            part.triangles.iter().copied().filter(|t| !normals::is_degenerate(&positions, *t)).collect();
        let normals = normals::corner_normals(&positions, &triangles, &vec![0; triangles.len()], part.crease_cos);
        let mut join = MeshJoin::new(positions.len());
        let mesh = &mut self.scene.mesh;
        let base = mesh.positions.len() as u32;
        let object = self.scene.objects.len().saturating_sub(1) as u32;
        for (triangle, normals) in triangles.iter().zip(&normals) {
            let mut corner = normals.iter();
            let vertices = triangle.map(|v| {
                let normal = corner.next().copied().unwrap_or(Vec3::Y);
                base + join.vertex(v, positions[v as usize], normal, part.uvs[v as usize].as_vec2())
            });
            mesh.triangles.push(Triangle { vertices, object, material });
        }
        mesh.positions.append(&mut join.mesh.positions);
        mesh.normals.append(&mut join.mesh.normals);
        mesh.uvs.extend(join.mesh.uvs.drain(..).map(|uv: Vec2| uv));
    }

    /// Adds an object made of a cluster, whose normals stay as they are.
    pub(crate) fn cluster(&mut self, name: &str, cluster: &Cluster, material: u32) {
        self.scene.objects.push(name.to_owned());
        self.scatter(cluster, material);
    }

    /// Adds a cluster to the last object.
    pub(crate) fn scatter(&mut self, cluster: &Cluster, material: u32) {
        let mesh = &mut self.scene.mesh;
        let base = mesh.positions.len() as u32;
        let object = self.scene.objects.len().saturating_sub(1) as u32;
        let first = mesh.positions.len();
        mesh.positions.extend(cluster.positions.iter().map(|p| p.as_vec3()));
        mesh.normals.extend(cluster.normals.iter().map(|n| n.as_vec3()));
        mesh.uvs.extend(cluster.uvs.iter().map(|uv| uv.as_vec2()));
        let placed = &mesh.positions[first..];
        let sound = cluster.triangles.iter().filter(|t| !normals::is_degenerate(placed, **t));
        mesh.triangles.extend(sound.map(|t| Triangle { vertices: t.map(|v| base + v), object, material }));
    }

    /// Adds a light that shines from infinity.
    pub fn sun(&mut self, to_light: [f32; 3], colour: [f32; 3]) {
        self.scene.lights.push(Light::Directional { to_light: to_light.into(), colour: colour.into() });
    }

    /// Adds a point light.
    pub fn point_light(&mut self, position: [f32; 3], colour: [f32; 3]) {
        self.scene.lights.push(Light::Point { position: position.into(), colour: colour.into() });
    }

    /// Sets the sky from zenith, horizon and ground colours.
    pub fn sky(&mut self, zenith: [f32; 3], horizon: [f32; 3], ground: [f32; 3], ambient: f32) {
        self.scene.sky = Sky { zenith: zenith.into(), horizon: horizon.into(), ground: ground.into(), ambient };
    }

    /// Finishes the scene with its cameras.
    ///
    /// # Errors
    /// When the parts do not make a valid scene.
    pub fn finish(mut self, cameras: Vec<Camera>) -> Result<Scene, SceneError> {
        self.scene.cameras = cameras;
        self.scene.validate()?;
        Ok(self.scene)
    }
}

/// A dull material.
#[must_use]
pub fn matte(name: &str, diffuse: [f32; 3]) -> Material {
    Material { diffuse: diffuse.into(), ..defaults::default_material(name) }
}

/// A polished material that mirrors by Fresnel with `f0` head-on.
#[must_use]
pub fn polished(name: &str, diffuse: [f32; 3], f0: f32, shininess: u32) -> Material {
    Material { optics: Optics::FresnelMirror, specular: Vec3::splat(f0), shininess, ior: 1.5, ..matte(name, diffuse) }
}

/// A mirror with a constant weight.
#[must_use]
pub fn mirror(name: &str, diffuse: [f32; 3], weight: [f32; 3], shininess: u32) -> Material {
    Material { optics: Optics::Mirror, specular: weight.into(), shininess, ..matte(name, diffuse) }
}

/// Glass with a tint per surface.
#[must_use]
pub fn glass(name: &str, tint: [f32; 3], ior: f32) -> Material {
    let clear = matte(name, [0.0; 3]);
    Material {
        optics: Optics::Dielectric,
        specular: Vec3::ONE,
        shininess: 1000,
        ior,
        transmission: tint.into(),
        ..clear
    }
}
