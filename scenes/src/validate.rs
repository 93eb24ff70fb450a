//! The promises that every [`Scene`] keeps. Each loader checks them once, so that no later stage has to.

use glam::{Vec2, Vec3};

use crate::{
    error::{Location, SceneError},
    scene::{Camera, Light, MAX_LIGHTS, MAX_TEXTURE_SIDE, Material, Scene, Texture},
};

impl Scene {
    /// Checks that indices are in range, arrays are equally long, numbers are finite and cameras
    /// can look.
    ///
    /// # Errors
    /// The first promise that is broken.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.validate_mesh()?;
        for (index, material) in self.materials.iter().enumerate() {
            self.validate_material(index, material)?;
        }
        self.textures.iter().try_for_each(|texture| self.validate_texture(texture))?;
        self.validate_lights()?;
        let sky = [self.sky.zenith, self.sky.horizon, self.sky.ground, Vec3::splat(self.sky.ambient)];
        if sky.iter().any(|colour| !is_colour(*colour)) {
            return self.broken("a sky colour is negative or not finite".into());
        }
        if self.cameras.is_empty() {
            return self.broken("it has no camera".into());
        }
        for (frame, camera) in self.cameras.iter().enumerate() {
            check_camera(camera, || Location::Scene { name: self.name.clone(), camera: Some(frame) })?;
        }
        Ok(())
    }

    fn validate_mesh(&self) -> Result<(), SceneError> {
        let mesh = &self.mesh;
        let count = mesh.positions.len();
        if mesh.normals.len() != count || mesh.uvs.len() != count {
            return self.broken(format!(
                "{count} positions, {} normals, {} texture coordinates",
                mesh.normals.len(),
                mesh.uvs.len()
            ));
        }
        if mesh.triangles.is_empty() {
            return self.broken("it has no triangle".into());
        }
        if let Some(at) = mesh.positions.iter().position(|p: &Vec3| !p.is_finite()) {
            return self.broken(format!("vertex {at} is not finite"));
        }
        if let Some(at) = mesh.normals.iter().position(|n| !n.is_finite() || (n.length_squared() - 1.0).abs() > 1e-3) {
            return self.broken(format!("the normal of vertex {at} has not length one"));
        }
        if let Some(at) = mesh.uvs.iter().position(|uv: &Vec2| !uv.is_finite()) {
            return self.broken(format!("the texture coordinate of vertex {at} is not finite"));
        }
        for (at, triangle) in mesh.triangles.iter().enumerate() {
            let fits = triangle.vertices.iter().all(|v| (*v as usize) < count)
                && (triangle.object as usize) < self.objects.len()
                && (triangle.material as usize) < self.materials.len();
            if !fits {
                return self.broken(format!("triangle {at} has an index out of range: {triangle:?}"));
            }
        }
        Ok(())
    }

    fn validate_material(&self, index: usize, material: &Material) -> Result<(), SceneError> {
        let colours = [material.diffuse, material.specular, material.emission, material.transmission];
        if colours.iter().any(|c| !is_colour(*c)) {
            return self.broken(format!("material {index} `{}` has a negative or non-finite colour", material.name));
        }
        if material.shininess < 1 || !(material.ior >= 1.0 && material.ior.is_finite()) {
            return self
                .broken(format!("material {index} `{}` has shininess or index of refraction below 1", material.name));
        }
        let maps = [material.diffuse_map, material.alpha_map];
        if maps.iter().flatten().any(|map| *map >= self.textures.len()) {
            return self.broken(format!("material {index} `{}` has a texture index out of range", material.name));
        }
        Ok(())
    }

    fn validate_texture(&self, texture: &Texture) -> Result<(), SceneError> {
        let (w, h, texels) = (texture.width, texture.height, texture.texels.len());
        let fits = (1..=MAX_TEXTURE_SIDE).contains(&w) && (1..=MAX_TEXTURE_SIDE).contains(&h);
        if !fits || texels as u64 != u64::from(w) * u64::from(h) {
            return self.broken(format!("texture `{}` is {w} x {h} with {texels} texels", texture.name));
        }
        Ok(())
    }

    fn validate_lights(&self) -> Result<(), SceneError> {
        check_light_count(self.lights.len(), || Location::Scene { name: self.name.clone(), camera: None })?;
        let mut lights = self.lights.iter().enumerate();
        lights.try_for_each(|(index, light)| self.validate_light(index, light))
    }

    fn validate_light(&self, index: usize, light: &Light) -> Result<(), SceneError> {
        let (vector, colour) = match light {
            Light::Point { position, colour } => (*position, *colour),
            Light::Directional { to_light, colour } => (*to_light, *colour),
        };
        if !vector.is_finite() || !is_colour(colour) {
            return self.broken(format!("light {index} has a negative or non-finite value"));
        }
        if matches!(light, Light::Point { .. }) && !is_near(vector) {
            let far = format!(
                "light {index} stands so far away that single precision knows no direction to it; make it directional"
            );
            return self.broken(far);
        }
        if matches!(light, Light::Directional { .. }) && !is_direction(vector) {
            return self.broken(format!("light {index} shines from no direction"));
        }
        Ok(())
    }

    fn broken(&self, what: String) -> Result<(), SceneError> {
        Err(SceneError::Inconsistent { scene: self.name.clone(), what })
    }
}

/// What a point light needs that is not [near](is_near).
pub(crate) const NEAR_LIGHTS: &str = "coordinates of point lights are at most 1e18, or single precision knows no direction to \
    them; make it directional, or move it nearer";

/// Whether a point light at a place is so near that single precision knows a direction to it.
pub(crate) fn is_near(place: Vec3) -> bool {
    place.is_finite() && place.abs().max_element() <= 1e18
}

/// Whether every channel is finite and not negative.
pub(crate) fn is_colour(colour: Vec3) -> bool {
    colour.is_finite() && colour.min_element() >= 0.0
}

/// Whether a vector is long enough, and short enough, to be normalised in `f32`.
pub(crate) fn is_direction(v: Vec3) -> bool {
    v.is_finite() && (1e-30..1e30).contains(&v.length_squared())
}

/// Checks that the trace can hold so many lights; `at` says where they are listed.
pub(crate) fn check_light_count(count: usize, at: impl Fn() -> Location) -> Result<(), SceneError> {
    if count <= MAX_LIGHTS {
        return Ok(());
    }
    let what = format!("{count} lights are too many: at most {MAX_LIGHTS} fit the trace");
    Err(SceneError::Limit { at: at(), what, fix: "remove some".into() })
}

/// Checks that a camera can look; `at` says where it is described.
pub(crate) fn check_camera(camera: &Camera, at: impl Fn() -> Location) -> Result<(), SceneError> {
    let fail = |what: String, fix: &str| Err(SceneError::input(at(), what, fix));
    if !(camera.eye.is_finite() && camera.target.is_finite() && camera.up.is_finite()) {
        return fail("the camera has a coordinate that is not finite".into(), "use finite numbers");
    }
    let view = camera.target - camera.eye;
    if view.length_squared() >= 1e30 {
        return fail("the camera's eye and target are too far apart".into(), "move one of them nearer to the other");
    }
    if !is_direction(view) {
        return fail("the camera's eye and target are the same point".into(), "move one of them");
    }
    if !is_direction(camera.up) {
        return fail("the camera's up vector has no direction".into(), "use for example [0.0, 1.0, 0.0]");
    }
    let (view, up) = (view.as_dvec3().normalize(), camera.up.as_dvec3().normalize());
    if view.cross(up).length_squared() < 1e-10 {
        return fail("the camera's up vector is parallel to its view axis".into(), "choose another up");
    }
    if !(camera.vfov_deg > 0.0 && camera.vfov_deg < 180.0) {
        let what = format!("the camera's vertical field of view is {} degrees", camera.vfov_deg);
        return fail(what, "use a value between 0 and 180");
    }
    Ok(())
}
