//! What the tests of this crate share: a generator of random numbers and the scenes to run on.

#![allow(dead_code, reason = "no test binary uses all of this")]

pub mod cutout;
pub mod recorded;

use std::path::PathBuf;

use rayreel_formats::math::{Vec3, vec3};
use rayreel_scenes::Scene;

/// SplitMix64; tests need no better one.
#[derive(Clone, Copy, Debug)]
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }

    /// A number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        ((u64::from(self.next()) * n as u64) >> 32) as usize
    }

    /// From 0 to below 1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 16_777_216.0
    }

    /// From `low` to below `high`.
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A point of a box.
    pub fn point(&mut self, low: Vec3, high: Vec3) -> Vec3 {
        vec3(self.range(low.x, high.x), self.range(low.y, high.y), self.range(low.z, high.z))
    }

    /// A unit vector, all directions alike.
    pub fn direction(&mut self) -> Vec3 {
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
