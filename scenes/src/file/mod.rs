//! Scene files (TOML): a model with camera, lights, sky and changed materials.

mod camera;
mod lights;
mod materials;
mod value;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde::Deserialize;

use self::{
    camera::CameraTable,
    lights::{LightTable, SkyTable},
    materials::MaterialTable,
    value::bad_value,
};
use crate::{
    defaults,
    error::{Location, SceneError},
    names::of_toml,
    obj,
    scene::Scene,
};

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

/// Loads a scene file.
///
/// # Errors
/// Whatever is wrong with it or with a file that it names; with line and column where the file itself is at fault.
pub fn load_scene_file(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    if path.is_dir() {
        return Err(SceneError::folder(path, "scene file (.toml)"));
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
        return Err(bad_value(
            path,
            format!("model `{}` is no OBJ file", table.model.display()),
            "name a file that ends in .obj",
        ));
    }
    let mut scene = from_obj(&folder.join(&table.model))?;
    if let Some(name) = table.name.or_else(|| stem(path)) {
        scene.name = name;
    }
    materials::change_materials(path, &text, &mut scene.materials, &table.materials)?;
    if let Some(lights) = &table.lights {
        scene.lights = lights::light_list(path, lights)?;
    }
    if let Some(table) = &table.sky {
        scene.sky = lights::sky(path, table)?;
    }
    if let Some(table) = &table.camera {
        scene.cameras = camera::cameras(path, table, defaults::main_bounds(&scene.mesh.positions))?;
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

/// Turns the byte span of a TOML error into line and column.
fn toml_error(path: &Path, text: &str, error: &toml::de::Error) -> SceneError {
    let start = error.span().map_or(0, |span| span.start).min(text.len());
    let before = text.get(..start).unwrap_or("");
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    let (what, fix) = of_toml(&error.message().trim().replace('\n', "; "));
    SceneError::Input {
        at: Location::Line { path: path.to_owned(), line, column: Some(column) },
        what,
        fix,
        source: None,
    }
}
