//! Scene files (TOML): a model with camera, lights, sky and changed materials.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use glam::Vec3;
use serde::Deserialize;

use crate::{
    defaults,
    error::{SceneError, hint},
    file_camera::{self, CameraTable},
    obj,
    scene::{Light, Material, Optics, Scene, Sky},
    validate::{MAX_LIGHTS, is_colour, is_direction},
};

/// Three numbers as TOML has them.
pub(crate) type Triple = [f32; 3];

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneTable {
    name: Option<String>,
    model: PathBuf,
    camera: Option<CameraTable>,
    lights: Option<Vec<LightTable>>,
    sky: Option<SkyTable>,
    #[serde(default)]
    materials: BTreeMap<String, MaterialTable>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum LightKind {
    Point,
    Directional,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LightTable {
    kind: LightKind,
    position: Option<Triple>,
    to_light: Option<Triple>,
    colour: Option<Triple>,
    intensity: Option<f32>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SkyTable {
    colour: Option<Triple>,
    zenith: Option<Triple>,
    horizon: Option<Triple>,
    ground: Option<Triple>,
    ambient: Option<f32>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialTable {
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

/// Loads a scene file.
///
/// # Errors Whatever is wrong with it or with a file that it names; with line and column where the
/// file itself is at fault.
pub fn load_scene_file(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    if path.is_dir() {
        return Err(SceneError::IsFolder { path: path.to_owned(), expected: "scene file (.toml)" });
    }
    let text = std::fs::read_to_string(path).map_err(|source| SceneError::Io {
        path: path.to_owned(),
        what: "scene file",
        source,
    })?;
    let table: SceneTable = toml::from_str(&text).map_err(|error| toml_error(path, &text, &error))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let is_obj = table.model.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    if !is_obj {
        return Err(value(
            path,
            format!("model `{}` is no OBJ file", table.model.display()),
            "name a file that ends in .obj",
        ));
    }
    let mut scene = from_obj(&folder.join(&table.model))?;
    if let Some(name) = table.name.or_else(|| stem(path)) {
        scene.name = name;
    }
    change_materials(path, &text, &mut scene.materials, &table.materials)?;
    if let Some(lights) = &table.lights {
        scene.lights = light_list(path, lights)?;
    }
    if let Some(table) = &table.sky {
        scene.sky = sky(path, table)?;
    }
    if let Some(table) = &table.camera {
        scene.cameras = file_camera::cameras(path, table, defaults::main_bounds(&scene.mesh.positions))?;
    }
    scene.validate()?;
    Ok(scene)
}

/// A scene of an OBJ model alone: camera, lights and sky are the default ones.
pub(crate) fn from_obj(path: &Path) -> Result<Scene, SceneError> {
    let model = obj::load_obj(path)?;
    let mut scene = Scene {
        name: stem(path).unwrap_or_else(|| "model".into()),
        mesh: model.mesh,
        objects: model.objects,
        materials: model.materials,
        textures: model.textures,
        lights: Vec::new(),
        sky: defaults::soft_sky(),
        cameras: Vec::new(),
        warnings: model.warnings,
    };
    let bounds = defaults::main_bounds(&scene.mesh.positions);
    scene.lights = defaults::lights(&scene, bounds);
    scene.cameras = vec![defaults::framing_camera(bounds, defaults::DEFAULT_VFOV_DEG)];
    scene.validate()?;
    Ok(scene)
}

fn stem(path: &Path) -> Option<String> {
    path.file_stem().map(|s| s.to_string_lossy().into_owned())
}

/// An error about a value, naming the file.
pub(crate) fn value(path: &Path, what: String, fix: &str) -> SceneError {
    SceneError::Value { path: path.to_owned(), what, fix: fix.into() }
}

/// toml gives a byte span; people want line and column.
fn toml_error(path: &Path, text: &str, error: &toml::de::Error) -> SceneError {
    let start = error.span().map_or(0, |span| span.start).min(text.len());
    let before = text.get(..start).unwrap_or("");
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    SceneError::Toml { path: path.to_owned(), line, column, message: error.message().trim().replace('\n', "; ") }
}

fn colour(path: &Path, key: &str, triple: Triple) -> Result<Vec3, SceneError> {
    let colour = Vec3::from(triple);
    if is_colour(colour) {
        Ok(colour)
    } else {
        Err(value(path, format!("{key} is {triple:?}"), "colours are finite and not negative"))
    }
}

fn amount(path: &Path, key: &str, number: f32, low: f32, high: f32) -> Result<f32, SceneError> {
    if number >= low && number <= high {
        return Ok(number);
    }
    Err(value(path, format!("{key} is {number}"), &format!("use a value between {low} and {high}")))
}

fn light_list(path: &Path, tables: &[LightTable]) -> Result<Vec<Light>, SceneError> {
    if tables.len() > MAX_LIGHTS {
        let (place, count) = (path.display().to_string(), tables.len());
        return Err(SceneError::TooManyLights { place, count });
    }
    let lights = tables.iter().enumerate();
    lights.map(|(index, table)| light(path, index, table)).collect()
}

fn light(path: &Path, index: usize, table: &LightTable) -> Result<Light, SceneError> {
    let key = |what: &str| format!("lights[{index}].{what}");
    let tint = table.colour.map_or(Ok(Vec3::ONE), |c| colour(path, &key("colour"), c))?;
    let intensity = amount(path, &key("intensity"), table.intensity.unwrap_or(0.7), 0.0, 1e6)?;
    let colour = tint * intensity;
    match (table.kind, table.position, table.to_light) {
        (LightKind::Point, Some(p), None) if Vec3::from(p).is_finite() => {
            Ok(Light::Point { position: p.into(), colour })
        }
        (LightKind::Directional, None, Some(d)) if is_direction(d.into()) => {
            Ok(Light::Directional { to_light: d.into(), colour })
        }
        (LightKind::Point, ..) => Err(value(
            path,
            format!("lights[{index}] is a point light without a usable place"),
            "give it `position` (finite) and no `to_light`",
        )),
        (LightKind::Directional, ..) => Err(value(
            path,
            format!("lights[{index}] is a directional light without a usable direction"),
            "give it `to_light` (not zero) and no `position`",
        )),
    }
}

fn sky(path: &Path, table: &SkyTable) -> Result<Sky, SceneError> {
    let get = |key: &str, triple: Option<Triple>| triple.map(|t| colour(path, &format!("sky.{key}"), t)).transpose();
    let base = get("colour", table.colour)?.map_or_else(defaults::soft_sky, defaults::sky_around);
    Ok(Sky {
        zenith: get("zenith", table.zenith)?.unwrap_or(base.zenith),
        horizon: get("horizon", table.horizon)?.unwrap_or(base.horizon),
        ground: get("ground", table.ground)?.unwrap_or(base.ground),
        ambient: amount(path, "sky.ambient", table.ambient.unwrap_or(base.ambient), 0.0, 100.0)?,
    })
}

/// Applies the `[materials]` tables; `text` is searched for the line of a table that fits no material.
fn change_materials(
    path: &Path,
    text: &str,
    materials: &mut [Material],
    changes: &BTreeMap<String, MaterialTable>,
) -> Result<(), SceneError> {
    for (name, change) in changes {
        let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        let Some(at) = known.iter().position(|k| k == name) else {
            let line =
                text.lines().position(|l| l.contains("materials") && l.contains(name.as_str())).map_or(1, |l| l + 1);
            return Err(SceneError::UnknownMaterial {
                path: path.to_owned(),
                line,
                name: name.clone(),
                hint: hint(name, &known, "materials"),
            });
        };
        change_material(path, &mut materials[at], change)?;
    }
    Ok(())
}

/// `reflect` first makes a mirror; the other keys then count as written.
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

/// Changing the kind brings the defaults that the kind needs to show: glass bends and reflects.
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
