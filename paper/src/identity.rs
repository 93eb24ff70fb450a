//! Which capture a capture is, before there is a trace of it; and what the cache folder knows of traces that were made.
//!
//! A result is kept under the fingerprint of its trace, so that sweeps over the same trace find it. The trace itself need not be
//! there to find it again: a small file remembers which fingerprint a capture has come to.

use std::fs;
use std::path::{Path, PathBuf};

use rayreel_formats::scene::Meta;
use rayreel_study::files::write_whole;

use crate::error::Result;

/// What a capture depends on, as a hash: the program, the content of the scene, the grid, the frames and the depth.
pub fn identity(meta: &Meta) -> String {
    let Meta {
        tool, scene, scene_hash, width, height, samples, tile, first_frame, frames, max_depth, min_weight, ..
    } = meta;
    let numbers = [*width, *height, *samples, *tile, *first_frame, *frames, *max_depth, min_weight.to_bits()];
    let mut hasher = blake3::Hasher::new();
    for part in [&b"rayreel capture 1"[..], tool.as_bytes(), scene.as_bytes(), &scene_hash[..]] {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
    }
    for number in numbers {
        hasher.update(&number.to_le_bytes());
    }
    format!("capture {}", hasher.finalize().to_hex())
}

/// The fingerprints of captures that were made, one file each: the hash of its second line, then the fingerprint.
pub struct Fingerprints {
    folder: PathBuf,
}

impl Fingerprints {
    /// Those in a folder.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.into() }
    }

    fn file(&self, identity: &str) -> PathBuf {
        let name = blake3::hash(identity.as_bytes()).to_hex();
        self.folder.join(format!("{}.capture", &name[..32]))
    }

    /// The fingerprint that this capture has come to, if it is known.
    pub fn get(&self, identity: &str) -> Option<String> {
        let text = fs::read_to_string(self.file(identity)).ok()?;
        let (hash, fingerprint) = text.split_once('\n')?;
        (blake3::hash(fingerprint.as_bytes()).to_hex().as_str() == hash).then(|| fingerprint.to_owned())
    }

    /// Remembers it.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn remember(&self, identity: &str, fingerprint: &str) -> Result<()> {
        let text = format!("{}\n{fingerprint}", blake3::hash(fingerprint.as_bytes()).to_hex());
        Ok(write_whole(&self.file(identity), text.as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use rayreel_tracer::{SampleGrid, TraceSettings};

    use super::*;

    #[test]
    fn whatever_changes_a_capture_changes_its_identity() {
        let scene = rayreel_scenes::load("cornell").unwrap();
        let grid = SampleGrid { width: 32, height: 16, samples: 1, tile: 32, first_frame: 0, frames: 1 };
        let base = grid.meta(&scene, TraceSettings::default(), "tool 1");
        let mut other_scene = base.clone();
        other_scene.scene_hash[31] ^= 1;
        let others = [
            other_scene,
            SampleGrid { width: 16, height: 32, ..grid }.meta(&scene, TraceSettings::default(), "tool 1"),
            SampleGrid { tile: 16, ..grid }.meta(&scene, TraceSettings::default(), "tool 1"),
            SampleGrid { frames: 2, ..grid }.meta(&scene, TraceSettings::default(), "tool 1"),
            grid.meta(&scene, TraceSettings { max_depth: 3, ..TraceSettings::default() }, "tool 1"),
            grid.meta(&scene, TraceSettings::default(), "tool 2"),
        ];
        assert_eq!(identity(&base), identity(&base.clone()));
        others.iter().for_each(|other| assert_ne!(identity(other), identity(&base), "{other:?}"));
    }

    #[test]
    fn a_damaged_fingerprint_is_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let known = Fingerprints::new(folder.path());
        assert_eq!(known.get("a"), None);
        known.remember("a", "0123abcd").unwrap();
        assert_eq!(known.get("a").as_deref(), Some("0123abcd"));
        assert_eq!(known.get("b"), None);
        let bytes = fs::read(known.file("a")).unwrap();
        for i in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[i] ^= 1;
            fs::write(known.file("a"), changed).unwrap();
            assert_eq!(known.get("a"), None, "byte {i}");
            fs::write(known.file("a"), &bytes[..i]).unwrap();
            assert_eq!(known.get("a"), None, "cut at {i}");
        }
    }
}
