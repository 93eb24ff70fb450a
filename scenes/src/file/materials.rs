//! `[materials.NAME]` of a scene file: changes to the materials of the model.

use std::{collections::BTreeMap, path::Path};

use glam::Vec3;
use serde::Deserialize;

use crate::{
    error::{Location, SceneError},
    file::value::{Triple, amount, colour},
    names::hint,
    scene::{Material, Optics},
};

/// `[materials.NAME]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialTable {
    diffuse: Option<Triple>,
    specular: Option<Triple>,
    shininess: Option<u32>,
    emission: Option<Triple>,
    ior: Option<f32>,
    transmission: Option<Triple>,
    reflect: Option<f32>,
    optics: Option<OpticsName>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum OpticsName {
    Opaque,
    Mirror,
    FresnelMirror,
    Dielectric,
}

/// Applies the `[materials]` tables; `text` is searched for the line of a table that fits no material.
pub(crate) fn change_materials(
    path: &Path,
    text: &str,
    materials: &mut [Material],
    changes: &BTreeMap<String, MaterialTable>,
) -> Result<(), SceneError> {
    for (name, change) in changes {
        let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        if !known.contains(&name.as_str()) {
            let line =
                text.lines().position(|l| l.contains("materials") && l.contains(name.as_str())).map_or(1, |l| l + 1);
            let what = format!("the model has no material `{name}`");
            return Err(SceneError::input(Location::line(path, line), what, hint(name, &known, "materials")));
        }
        // glTF lets several have one name.
        for material in materials.iter_mut().filter(|material| material.name == *name) {
            change_material(path, material, change)?;
        }
    }
    Ok(())
}

/// Applies one table. `reflect` is applied first, so that the other keys can change the mirror it makes.
fn change_material(path: &Path, material: &mut Material, changes: &MaterialTable) -> Result<(), SceneError> {
    let key = |what: &str| format!("materials.{}.{what}", material.name);
    let get = |what: &str, triple: Option<Triple>| triple.map(|t| colour(path, &key(what), t)).transpose();
    let (diffuse, specular) = (get("diffuse", changes.diffuse)?, get("specular", changes.specular)?);
    let (emission, transmission) = (get("emission", changes.emission)?, get("transmission", changes.transmission)?);
    let ior = changes.ior.map(|n| amount(path, &key("ior"), n, 1.0, 1000.0)).transpose()?;
    let reflect = changes.reflect.map(|w| amount(path, &key("reflect"), w, 0.0, 1.0)).transpose()?;
    let shininess = changes.shininess;
    if let Some(n) = shininess {
        amount(path, &key("shininess"), n as f32, 1.0, 1e6)?;
    }
    if let Some(weight) = reflect {
        material.optics = if weight > 0.0 { Optics::Mirror } else { Optics::Opaque };
        material.specular = Vec3::splat(weight);
    }
    if let Some(optics) = changes.optics {
        set_optics(material, optics);
    }
    material.diffuse = diffuse.unwrap_or(material.diffuse);
    material.specular = specular.unwrap_or(material.specular);
    material.emission = emission.unwrap_or(material.emission);
    material.transmission = transmission.unwrap_or(material.transmission);
    material.ior = ior.unwrap_or(material.ior);
    material.shininess = shininess.unwrap_or(material.shininess);
    Ok(())
}

/// Changes the kind. A material that becomes glass gets an index and a specular colour with which it bends and
/// reflects.
fn set_optics(material: &mut Material, optics: OpticsName) {
    material.optics = match optics {
        OpticsName::Opaque => Optics::Opaque,
        OpticsName::Mirror => Optics::Mirror,
        OpticsName::FresnelMirror => Optics::FresnelMirror,
        OpticsName::Dielectric => {
            if material.optics != Optics::Dielectric {
                material.ior = material.ior.max(1.5);
                material.specular = Vec3::ONE;
            }
            Optics::Dielectric
        }
    };
}
