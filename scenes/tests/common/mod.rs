//! Small models as files.

use std::fs;

use rayreel_scenes::{Scene, load};
use tempfile::TempDir;

pub const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A folder with the given files.
pub fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("writes");
    }
    folder
}

pub fn load_in(folder: &TempDir, name: &str) -> Result<Scene, String> {
    let path = folder.path().join(name);
    // The name of the folder differs from run to run.
    load(path.to_str().expect("UTF-8")).map_err(|e| e.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

/// Warnings by count, without the folder.
pub fn warnings(scene: &Scene) -> Vec<(u64, String)> {
    scene.warnings.iter().map(|w| (w.count, w.message.rsplit('/').next().unwrap_or("").to_owned())).collect()
}
