//! What a caller may ask of a loader beside the file.

use crate::error::SceneError;

/// Frames a second of an animation, where nothing else is asked for.
pub const DEFAULT_FPS: f64 = 30.0;
/// Most frames a second.
pub const MAX_FPS: f64 = 1000.0;

/// Width over height of the pictures that a camera is placed for, where nothing else is asked for.
pub const DEFAULT_ASPECT: f64 = 2.0;

/// How a scene is loaded. Only animated models (glTF), and cameras that no file places, depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOptions {
    /// Frames a second of an animation; none takes what the scene file says, else [`DEFAULT_FPS`].
    pub fps: Option<f64>,
    /// The frame at whose time moving meshes stand. A scene has one geometry.
    pub frame: u32,
    /// How many frames from there will be used; with several, a loader tells that meshes stand still.
    pub frames: u32,
    /// Width over height of the picture. A camera that no file places has the model in view at it, and at [`DEFAULT_ASPECT`].
    pub aspect: f64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { fps: None, frame: 0, frames: 1, aspect: DEFAULT_ASPECT }
    }
}

impl LoadOptions {
    /// Refuses frames a second of a model that cannot move.
    pub(crate) fn check_still(&self, model: &str) -> Result<(), SceneError> {
        match self.fps {
            None => Ok(()),
            Some(_) => Err(SceneError::Usage {
                what: format!("frames a second are of a glTF model, and {model} is none"),
                fix: "leave --fps, or [animation] of the scene file, out".into(),
            }),
        }
    }

    /// Frames a second, above zero and at most [`MAX_FPS`].
    pub(crate) fn fps(&self) -> f64 {
        let fps = self.fps.filter(|fps| *fps > 0.0 && fps.is_finite());
        fps.unwrap_or(DEFAULT_FPS).min(MAX_FPS)
    }
}
