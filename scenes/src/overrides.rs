//! Camera, lights and sky that a caller gives instead of those of the scene.

use glam::Vec3;

use crate::{
    defaults::sky_around,
    error::{Location, SceneError},
    scene::{Camera, Light, Scene},
    validate::{NEAR_LIGHTS, check_camera, check_light_count, is_colour, is_direction, is_near},
};

/// What to replace of a scene. What is not given stays as the scene has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Where the camera stands, in every frame.
    pub eye: Option<Vec3>,
    /// Where it looks at, in every frame.
    pub target: Option<Vec3>,
    /// What is up in the picture; the sky stays along +y.
    pub up: Option<Vec3>,
    /// Vertical field of view in degrees.
    pub vfov_deg: Option<f32>,
    /// Lights instead of all lights of the scene; none keeps those.
    pub lights: Vec<Light>,
    /// The colour of a sky instead of the scene's.
    pub sky: Option<Vec3>,
}

impl Overrides {
    /// A point light at a place, of a linear colour.
    #[must_use]
    pub fn point_light(position: [f32; 3], colour: [f32; 3]) -> Light {
        Light::Point { position: position.into(), colour: colour.into() }
    }

    /// Replaces what is given. Each part of a camera is replaced in every frame: with an eye and a target, a camera that
    /// moved stands still; with only one of them, the other keeps moving.
    ///
    /// # Errors
    /// A camera that cannot look, a light or sky that is negative or not finite, a light too far away, more lights than a trace holds.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), SceneError> {
        self.change_cameras(scene)?;
        let at = |camera| Location::Scene { name: scene.name.clone(), camera };
        self.lights.iter().try_for_each(check_light)?;
        check_light_count(self.lights.len(), || at(None)).map_err(asked)?;
        if !self.sky.is_none_or(is_colour) {
            return Err(usage("the sky that was asked for is negative or not finite", COLOURS));
        }
        if !self.lights.is_empty() {
            scene.lights.clone_from(&self.lights);
        }
        if let Some(colour) = self.sky {
            scene.sky = sky_around(colour);
        }
        scene.validate()
    }

    fn change_cameras(&self, scene: &mut Scene) -> Result<(), SceneError> {
        let change = |camera: &Camera| Camera {
            eye: self.eye.unwrap_or(camera.eye),
            target: self.target.unwrap_or(camera.target),
            up: self.up.unwrap_or(camera.up),
            vfov_deg: self.vfov_deg.unwrap_or(camera.vfov_deg),
        };
        let cameras: Vec<Camera> = scene.cameras.iter().map(change).collect();
        for (frame, camera) in cameras.iter().enumerate() {
            let at = || Location::Scene { name: scene.name.clone(), camera: Some(frame) };
            check_camera(camera, at).map_err(asked)?;
        }
        scene.cameras = cameras;
        Ok(())
    }
}

/// What colours must be.
const COLOURS: &str = "colours are finite and not negative";

fn usage(what: impl Into<String>, fix: &str) -> SceneError {
    SceneError::Usage { what: what.into(), fix: fix.into() }
}

/// Refuses a light that cannot be drawn.
fn check_light(light: &Light) -> Result<(), SceneError> {
    let (Light::Point { colour, .. } | Light::Directional { colour, .. }) = light;
    match light {
        _ if !is_colour(*colour) => Err(usage("a light that was asked for is negative or not finite", COLOURS)),
        Light::Point { position, .. } if !is_near(*position) => {
            Err(usage(format!("a light that was asked for is at {:?}", position.to_array()), NEAR_LIGHTS))
        }
        Light::Directional { to_light, .. } if !is_direction(*to_light) => {
            Err(usage("a light that was asked for shines from no direction", "give one that is not zero"))
        }
        _ => Ok(()),
    }
}

/// The error of what the caller asked for: no file is at fault.
fn asked(error: SceneError) -> SceneError {
    match error {
        SceneError::Input { at, what, fix, .. } => {
            let fix = fix.unwrap_or_default();
            SceneError::Usage { what: format!("{at}, with what was asked for: {what}"), fix }
        }
        SceneError::Limit { at, what, fix } => {
            SceneError::Usage { what: format!("{at}, with what was asked for: {what}"), fix }
        }
        other => other,
    }
}
