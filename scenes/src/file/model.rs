//! Models by the ending of their name, as scenes with what the model does not say.

use std::path::Path;

use crate::{
    defaults,
    error::SceneError,
    gltf_model::load_gltf,
    obj::load_obj,
    options::LoadOptions,
    scene::{Camera, Light, Scene},
    view::View,
};

/// A model as a scene, and what a scene file must know of it.
pub(crate) struct Model {
    pub scene: Scene,
    /// Where a camera stands that the scene file does not place.
    pub view: View,
    /// Frames of its animation, for a still camera before it.
    pub frames: u64,
}

/// Whether the name ends as that of a model that is read.
pub(crate) fn is_model(path: &Path) -> bool {
    ["obj", "gltf", "glb"].contains(&extension(path).as_str())
}

fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase())
}

/// What to do about a file whose ending says that it is neither a model nor a scene file that is read.
pub(crate) fn unknown_format(path: &Path) -> SceneError {
    let known = [
        "fbx", "ply", "stl", "usd", "usda", "usdc", "usdz", "blend", "3ds", "dae", "x", "x3d", "wrl", "abc", "lwo",
        "max", "ma", "mb", "c4d", "step", "stp", "iges", "off", "vrm", "ase", "dxf", "3mf", "pbrt", "xml", "mitsuba",
    ];
    let extension = extension(path);
    let kind = if known.contains(&extension.as_str()) { "files are" } else { "(whatever it is) is" };
    let what =
        format!("{}: .{extension} {kind} not read: models are .obj, .gltf or .glb, scene files .toml", path.display());
    let out = path.with_extension("obj");
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let fix = format!("convert it: Blender exports glTF 2.0 and OBJ, or `assimp export {} {}`", name(path), name(&out));
    SceneError::Usage { what, fix }
}

/// A scene of a model alone: what it does not say of camera, lights and sky is the default.
pub(crate) fn from_model(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    read(path, options).map(|model| model.scene)
}

/// Reads a model that [`is_model`] knows.
pub(crate) fn read(path: &Path, options: &LoadOptions) -> Result<Model, SceneError> {
    if extension(path) == "obj" {
        let model = load_obj(path)?;
        let mut scene = bare(path);
        (scene.mesh, scene.objects) = (model.mesh, model.objects);
        (scene.materials, scene.textures) = (model.materials, model.textures);
        scene.warnings = model.warnings;
        return finish(scene, Vec::new(), Vec::new(), 1);
    }
    let model = load_gltf(path, options)?;
    let mut scene = bare(path);
    (scene.mesh, scene.objects) = (model.mesh, model.objects);
    (scene.materials, scene.textures) = (model.materials, model.textures);
    scene.warnings = model.warnings;
    finish(scene, model.lights, model.cameras, model.frames)
}

/// A scene of this name with nothing in it.
fn bare(path: &Path) -> Scene {
    Scene {
        name: path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy().into_owned()),
        mesh: crate::scene::Mesh::default(),
        objects: Vec::new(),
        materials: Vec::new(),
        textures: Vec::new(),
        lights: Vec::new(),
        sky: defaults::soft_sky(),
        cameras: Vec::new(),
        warnings: Vec::new(),
    }
}

/// Adds what the model does not say.
fn finish(mut scene: Scene, lights: Vec<Light>, cameras: Vec<Camera>, frames: u64) -> Result<Model, SceneError> {
    let view = View::of(&scene);
    scene.lights = if lights.is_empty() { view.lights(&scene) } else { lights };
    scene.cameras = cameras;
    if scene.cameras.is_empty() {
        scene.cameras = vec![view.camera(None); frames as usize];
    }
    scene.validate()?;
    Ok(Model { scene, view, frames })
}
