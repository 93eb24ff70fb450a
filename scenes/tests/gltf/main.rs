//! glTF models: the same scene as OBJ, animation in closed form, every extension that is read, and bad input.

mod animation;
mod bad_input;
mod fuzz;
mod materials;
mod same_as_obj;
mod shapes;
mod skins;
mod writer;

use std::path::Path;

use rayreel_scenes::{LoadOptions, Scene, SceneError, load_with};
use tempfile::TempDir;

fn folder() -> TempDir {
    TempDir::new().expect("a temporary folder")
}

fn load_file(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    load_with(path.to_str().expect("UTF-8"), options)
}

/// The error without the folder, which differs from run to run.
fn message(folder: &TempDir, error: &SceneError) -> String {
    error.to_string().replace(&format!("{}/", folder.path().display()), "")
}

/// Warnings by count, without the folder.
fn warnings(folder: &TempDir, scene: &Scene) -> Vec<(u64, String)> {
    let short = |text: &str| text.replace(&format!("{}/", folder.path().display()), "");
    scene.warnings.iter().map(|w| (w.count, short(&w.message))).collect()
}

/// Whether a warning with this count has these words.
#[track_caller]
fn assert_warned(folder: &TempDir, scene: &Scene, count: u64, words: &str) {
    let all = warnings(folder, scene);
    assert!(all.iter().any(|(n, text)| *n == count && text.contains(words)), "no {count} x `{words}` in {all:#?}");
}
