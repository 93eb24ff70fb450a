//! Scene files (TOML): a model with camera, lights, sky and changed materials.

mod camera;
mod lights;
mod materials;
mod model;
mod value;

pub use model::BOX_PADDING;

use std::{
    collections::BTreeMap,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use rayreel_settings::files;
use serde::Deserialize;

use self::{
    camera::{CameraTable, Placed},
    lights::{LightTable, SkyTable},
    materials::MaterialTable,
    model::Model,
    value::bad_value,
};
use crate::{
    error::{Location, SceneError},
    names::of_toml,
    options::{LoadOptions, MAX_FPS},
    scene::Scene,
};

pub(crate) use model::{from_model, is_model, unknown_format};

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneTable {
    name: Option<String>,
    model: PathBuf,
    camera: Option<CameraTable>,
    lights: Option<Vec<LightTable>>,
    sky: Option<SkyTable>,
    animation: Option<AnimationTable>,
    #[serde(default)]
    materials: BTreeMap<String, MaterialTable>,
}

/// `[animation]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct AnimationTable {
    fps: f64,
}

/// Loads a scene file.
///
/// # Errors
/// Whatever is wrong with it or with a file that it names; with line and column where the file itself is at fault.
pub fn load_scene_file(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    if path.is_dir() {
        return Err(SceneError::folder(path, "scene file (.toml)"));
    }
    let text = files::read_text(path, files::TEXT_MAX).map_err(|source| SceneError::Io {
        path: path.to_owned(),
        what: "scene file",
        source,
    })?;
    if let Some(error) = doubled(path, &text) {
        return Err(error);
    }
    let table: SceneTable = toml::from_str(&text).map_err(|error| toml_error(path, &text, &error))?;
    if !is_model(&table.model) {
        return Err(bad_value(
            path,
            format!("model `{}` is no model that is read", table.model.display()),
            "name a file that ends in .obj, .gltf or .glb",
        ));
    }
    let model = model_of(path, &text, &table, &with_fps(path, &table, options)?)?;
    let (mut scene, frames) = (model.scene, model.frames);
    let (view, has_cameras) = (model.view, model.has_cameras);
    if let Some(name) = table.name.or_else(|| stem(path)) {
        scene.name = name;
    }
    materials::change_materials(path, &text, &mut scene.materials, &table.materials)?;
    match &table.lights {
        Some(lights) => scene.lights = lights::light_list(path, lights)?,
        // Materials may have begun or ceased to emit.
        None if !model.has_lights && !table.materials.is_empty() => scene.lights = view.lights(&scene),
        None => {}
    }
    if let Some(table) = &table.sky {
        scene.sky = lights::sky(path, table)?;
    }
    if let Some(table) = &table.camera {
        let placed = if has_cameras { Placed::Model(&scene.cameras) } else { Placed::View(&view) };
        scene.cameras = camera::cameras(path, table, placed, &mut scene.warnings)
            .map_err(|error| named_by(line_of(path, &text, "path"), error))?;
        // A still camera before a model that moves stands there for all of its frames.
        if let [camera] = scene.cameras[..] {
            scene.cameras = vec![camera; frames as usize];
        }
    }
    scene.files.push(path.to_owned());
    scene.files.extend(table.camera.as_ref().and_then(|camera| camera.path_file(path)));
    scene.validate()?;
    Ok(scene)
}

/// The model that the file names.
fn model_of(path: &Path, text: &str, table: &SceneTable, options: &LoadOptions) -> Result<Model, SceneError> {
    let model = path.parent().unwrap_or(Path::new("")).join(&table.model);
    let at = line_of(path, text, "model");
    if model.is_dir() {
        return Err(SceneError::missing(at, "model", &model, ErrorKind::IsADirectory.into()));
    }
    model::read(&model, options).map_err(|error| named_by(at, error))
}

/// The line of a key, where it has one of its own.
fn line_of(path: &Path, text: &str, key: &str) -> Location {
    let states =
        |line: &str| line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='));
    match text.lines().position(states) {
        Some(index) => Location::line(path, index + 1),
        None => Location::File(path.to_owned()),
    }
}

/// A file that cannot be read is the fault of the file that names it at `at`.
fn named_by(at: Location, error: SceneError) -> SceneError {
    match error {
        SceneError::Io { path, what, source } => SceneError::missing(at, what, &path, source),
        other => other,
    }
}

/// The options with the frames a second of the file, where the caller asks for none.
fn with_fps(path: &Path, table: &SceneTable, options: &LoadOptions) -> Result<LoadOptions, SceneError> {
    let of_file = table.animation.as_ref().map(|animation| animation.fps);
    if let Some(fps) = of_file
        && !(fps > 0.0 && fps <= MAX_FPS)
    {
        let fix = format!("use a value above 0, at most {MAX_FPS}");
        return Err(bad_value(path, format!("animation.fps is {fps}"), &fix));
    }
    Ok(LoadOptions { fps: options.fps.or(of_file), ..*options })
}

/// A table of which there is one, written as one of several. (The reader would take its values by their order.)
fn doubled(path: &Path, text: &str) -> Option<SceneError> {
    let file: toml::Table = toml::from_str(text).ok()?;
    let of_materials = file.get("materials").and_then(toml::Value::as_table).into_iter().flatten();
    let tables = file.iter().filter(|(name, _)| ["camera", "sky", "animation", "materials"].contains(&name.as_str()));
    let tables = tables.map(|(name, value)| (name.clone(), value));
    let all = tables.chain(of_materials.map(|(name, value)| (format!("materials.{name}"), value)));
    let name = all.into_iter().find_map(|(name, value)| value.is_array().then_some(name))?;
    let begins = |line: &str| line.trim_start().trim_start_matches('[').trim_start().starts_with(&name);
    let line = text.lines().position(begins).map_or(1, |line| line + 1);
    Some(SceneError::Input {
        at: Location::Line { path: path.to_owned(), line, column: None },
        what: format!("{name} is a list, and a scene has one"),
        fix: Some(format!("write its name in one bracket, `[{name}]`, and once")),
        source: None,
    })
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
