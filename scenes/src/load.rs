//! Loads whatever a user may name.

use std::path::Path;

use crate::{builtin, error::SceneError, file, names::hint, options::LoadOptions, scene::Scene};

/// Loads a built-in scene by name, a scene file (`.toml`), or a model (`.obj`, `.gltf`, `.glb`) with default camera and lights
/// where it has none.
///
/// # Errors
/// What is wrong with the file; for an unknown name, the names that come near it; for an unknown kind of file, what is read.
pub fn load(spec: &str) -> Result<Scene, SceneError> {
    load_with(spec, &LoadOptions::default())
}

/// [`load`] with options for animated models.
///
/// # Errors
/// As [`load`].
pub fn load_with(spec: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    if builtin::builtin_names().contains(&spec) {
        options.check_still(spec)?;
        return builtin::builtin(spec);
    }
    let path = Path::new(spec);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        _ if path.is_dir() => Err(SceneError::folder(path, "model or scene file")),
        Some("toml") => file::load_scene_file(path, options),
        Some(_) if file::is_model(path) => file::from_model(path, options),
        Some(_) => Err(file::unknown_format(path)),
        None if path.is_file() => Err(SceneError::Usage {
            what: format!("{spec}: a file without an extension does not say what it is"),
            fix: "end its name in .obj, .gltf, .glb or .toml".into(),
        }),
        None => {
            let near = hint(spec, builtin::builtin_names(), "built-in scenes");
            let fix = format!("{near} (a model ends in .obj, .gltf or .glb, a scene file in .toml)");
            Err(SceneError::Usage { what: format!("no scene is called `{spec}`"), fix })
        }
    }
}
