//! Values of a scene file with their checks.

use std::path::Path;

use glam::Vec3;

use crate::{
    error::{Location, SceneError},
    validate::is_colour,
};

/// A vector or colour, as TOML writes it.
pub(crate) type Triple = [f32; 3];

/// An error about a value, naming the file.
pub(crate) fn bad_value(path: &Path, what: impl Into<String>, fix: &str) -> SceneError {
    SceneError::input(Location::File(path.to_owned()), what, fix)
}

/// Checks a colour.
pub(crate) fn colour(path: &Path, key: &str, triple: Triple) -> Result<Vec3, SceneError> {
    let colour = Vec3::from(triple);
    if is_colour(colour) {
        Ok(colour)
    } else {
        Err(bad_value(path, format!("{key} is {triple:?}"), "colours are finite and not negative"))
    }
}

/// Checks a number against its bounds.
pub(crate) fn amount(path: &Path, key: &str, number: f32, low: f32, high: f32) -> Result<f32, SceneError> {
    if number >= low && number <= high {
        return Ok(number);
    }
    Err(bad_value(path, format!("{key} is {number}"), &format!("use a value between {low} and {high}")))
}
