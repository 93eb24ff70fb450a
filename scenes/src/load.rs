//! One entry for whatever a user may name.

use std::path::Path;

use crate::{
    builtin,
    error::{SceneError, hint},
    file,
    scene::Scene,
};

/// Loads a built-in scene by name, a scene file (`.toml`), or an OBJ model (`.obj`) with default
/// camera and lights.
///
/// # Errors What is wrong with the file, or which names come near a name that is none.
pub fn load(spec: &str) -> Result<Scene, SceneError> {
    if builtin::builtin_names().contains(&spec) {
        return builtin::builtin(spec);
    }
    let path = Path::new(spec);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        _ if path.is_dir() => Err(SceneError::IsFolder { path: path.to_owned(), expected: "OBJ or scene file" }),
        Some("toml") => file::load_scene_file(path),
        Some("obj") => file::from_obj(path),
        _ => {
            let near = hint(spec, builtin::builtin_names(), "built-in scenes");
            let hint = format!("{near} (a scene file ends in .toml or .obj)");
            Err(SceneError::UnknownScene { name: spec.to_owned(), hint })
        }
    }
}
