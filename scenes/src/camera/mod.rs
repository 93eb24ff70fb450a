//! Camera paths: from a CSV file, from keyframes, and round an object.

mod keyframes;
mod path_file;

use glam::DVec3;

use crate::scene::Camera;

pub(crate) use keyframes::{Interpolation, Keyframe, MAX_FRAMES, interpolate};
pub(crate) use path_file::read_numbered;
pub use path_file::{PATH_HEADER, read_path};

/// A full turn round the vertical axis through the hero camera's target; frame 0 is the hero camera
/// itself.
pub(crate) fn orbit(hero: Camera, frames: u32, lift: f64) -> Vec<Camera> {
    let arm = (hero.eye - hero.target).as_dvec3();
    (0..frames)
        .map(|frame| {
            let angle = std::f64::consts::TAU * f64::from(frame) / f64::from(frames);
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            // The camera rises by `lift` until it is half way round: from low down, the far side would be all
            // shadow and table edge.
            let y = arm.y + lift * (1.0 - cos) / 2.0;
            let turned = DVec3::new(arm.x * cos + arm.z * sin, y, arm.z * cos - arm.x * sin);
            let eye = if frame == 0 { hero.eye } else { (hero.target.as_dvec3() + turned).as_vec3() };
            Camera { eye, ..hero }
        })
        .collect()
}
