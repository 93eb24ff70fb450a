//! Loads whatever a user may name.

use std::path::Path;

use crate::{builtin, error::SceneError, file, names::hint, scene::Scene};

/// Loads a built-in scene by name, a scene file (`.toml`), or an OBJ model (`.obj`) with default
/// camera and lights.
///
/// # Errors
/// What is wrong with the file; for an unknown name, the names that come near it.
pub fn load(spec: &str) -> Result<Scene, SceneError> {
    if builtin::builtin_names().contains(&spec) {
        return builtin::builtin(spec);
    }
    let path = Path::new(spec);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        _ if path.is_dir() => Err(SceneError::folder(path, "OBJ or scene file")),
        Some("toml") => file::load_scene_file(path),
        Some("obj") => file::from_obj(path),
        _ => {
            let near = hint(spec, builtin::builtin_names(), "built-in scenes");
            let fix = format!("{near} (a scene file ends in .toml or .obj)");
            Err(SceneError::Usage { what: format!("no scene is called `{spec}`"), fix })
        }
    }
}
