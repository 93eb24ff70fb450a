//! `[[lights]]` and `[sky]` of a scene file.

use std::path::Path;

use glam::Vec3;
use serde::Deserialize;

use crate::{
    defaults,
    error::{Location, SceneError},
    file::value::{Triple, amount, bad_value, colour},
    scene::{Light, Sky},
    validate::{NEAR_LIGHTS, check_light_count, is_direction, is_near},
};

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum LightKind {
    Point,
    Directional,
}

/// `[[lights]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LightTable {
    kind: LightKind,
    position: Option<Triple>,
    to_light: Option<Triple>,
    colour: Option<Triple>,
    intensity: Option<f32>,
}

/// `[sky]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SkyTable {
    colour: Option<Triple>,
    zenith: Option<Triple>,
    horizon: Option<Triple>,
    ground: Option<Triple>,
    ambient: Option<f32>,
}

/// The lights of the file.
pub(crate) fn light_list(path: &Path, tables: &[LightTable]) -> Result<Vec<Light>, SceneError> {
    check_light_count(tables.len(), || Location::File(path.to_owned()))?;
    let lights = tables.iter().enumerate();
    lights.map(|(index, table)| light(path, index, table)).collect()
}

fn light(path: &Path, index: usize, table: &LightTable) -> Result<Light, SceneError> {
    let key = |what: &str| format!("lights[{index}].{what}");
    let tint = table.colour.map_or(Ok(Vec3::ONE), |c| colour(path, &key("colour"), c))?;
    let intensity = amount(path, &key("intensity"), table.intensity.unwrap_or(0.7), 0.0, 1e6)?;
    let colour = tint * intensity;
    if !colour.is_finite() {
        let what =
            format!("{} is {:?}, and times its intensity of {intensity} above 3.4e38", key("colour"), tint.to_array());
        return Err(bad_value(path, what, "use smaller ones"));
    }
    if let (LightKind::Point, Some(Triple(place))) = (table.kind, table.position)
        && place.is_finite()
        && !is_near(place)
    {
        return Err(bad_value(path, format!("{} is {:?}", key("position"), place.to_array()), NEAR_LIGHTS));
    }
    match (table.kind, table.position, table.to_light) {
        (LightKind::Point, Some(p), None) if p.0.is_finite() => Ok(Light::Point { position: p.0, colour }),
        (LightKind::Directional, None, Some(d)) if is_direction(d.0) => {
            Ok(Light::Directional { to_light: d.0, colour })
        }
        (LightKind::Point, ..) => Err(bad_value(
            path,
            format!("lights[{index}] is a point light without a usable place"),
            "give it `position` (finite) and no `to_light`",
        )),
        (LightKind::Directional, ..) => Err(bad_value(
            path,
            format!("lights[{index}] is a directional light without a usable direction"),
            "give it `to_light` (not zero) and no `position`",
        )),
    }
}

/// The sky of the file; colours that are not given come from `colour`, else from the default sky.
pub(crate) fn sky(path: &Path, table: &SkyTable) -> Result<Sky, SceneError> {
    let get = |key: &str, triple: Option<Triple>| triple.map(|t| colour(path, &format!("sky.{key}"), t)).transpose();
    let base = get("colour", table.colour)?.map_or_else(defaults::soft_sky, defaults::sky_around);
    Ok(Sky {
        zenith: get("zenith", table.zenith)?.unwrap_or(base.zenith),
        horizon: get("horizon", table.horizon)?.unwrap_or(base.horizon),
        ground: get("ground", table.ground)?.unwrap_or(base.ground),
        ambient: amount(path, "sky.ambient", table.ambient.unwrap_or(base.ambient), 0.0, 100.0)?,
    })
}
