//! What the tests of this crate share: random points and the scenes to run on.

#![allow(dead_code, reason = "no test binary uses all of this")]

pub mod cutout;
pub mod recorded;

use std::path::PathBuf;

use rayreel_formats::math::{Vec3, vec3};
use rayreel_scenes::Scene;
pub use rayreel_testkit::Random;

/// Draws in space.
pub trait Draws {
    /// A point of a box.
    fn point(&mut self, low: Vec3, high: Vec3) -> Vec3;

    /// A unit vector, all directions alike.
    fn direction(&mut self) -> Vec3;
}

impl Draws for Random {
    fn point(&mut self, low: Vec3, high: Vec3) -> Vec3 {
        vec3(self.range(low.x, high.x), self.range(low.y, high.y), self.range(low.z, high.z))
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.point(Vec3::splat(-1.0), Vec3::splat(1.0));
            if (0.01..=1.0).contains(&v.length()) {
                return v.normalized();
            }
        }
    }
}

/// The built-in scenes that exist, by name.
pub fn builtin(name: &str) -> Scene {
    rayreel_scenes::builtin(name).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// All OBJ models beside the repository, sorted by path; none, with a word on stderr, where the folder is absent.
pub fn shared_models() -> Vec<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let Ok(folders) = std::fs::read_dir(&root) else {
        eprintln!("skipped: there is no ../shared/scenes beside the repository");
        return Vec::new();
    };
    let files = folders.flatten().filter_map(|folder| std::fs::read_dir(folder.path()).ok()).flatten().flatten();
    let is_obj = |path: &PathBuf| path.extension().is_some_and(|e| e == "obj");
    let mut models: Vec<PathBuf> = files.map(|file| file.path()).filter(is_obj).collect();
    models.sort();
    models
}
