//! Values of a scene file with their checks.

use std::path::Path;

use glam::Vec3;
use serde::{Deserialize, Deserializer, de::Error as _};

use crate::{
    error::{Location, SceneError},
    validate::is_colour,
};

/// A vector or colour: a list of three numbers, and no more.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triple(pub Vec3);

impl<'de> Deserialize<'de> for Triple {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let numbers = Vec::<f32>::deserialize(deserializer)?;
        let given = numbers.len();
        let three: [f32; 3] = numbers
            .try_into()
            .map_err(|_| D::Error::custom(format!("three numbers are needed, and {given} are given")))?;
        Ok(Self(three.into()))
    }
}

/// An error about a value, naming the file.
pub(crate) fn bad_value(path: &Path, what: impl Into<String>, fix: &str) -> SceneError {
    SceneError::input(Location::File(path.to_owned()), what, fix)
}

/// Checks a colour.
pub(crate) fn colour(path: &Path, key: &str, triple: Triple) -> Result<Vec3, SceneError> {
    let colour = triple.0;
    if is_colour(colour) {
        Ok(colour)
    } else {
        Err(bad_value(path, format!("{key} is {:?}", colour.to_array()), "colours are finite and not negative"))
    }
}

/// Checks a number against its bounds.
pub(crate) fn amount(path: &Path, key: &str, number: f32, low: f32, high: f32) -> Result<f32, SceneError> {
    if number >= low && number <= high {
        return Ok(number);
    }
    Err(bad_value(path, format!("{key} is {number}"), &format!("use a value between {low} and {high}")))
}
