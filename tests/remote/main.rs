//! Traces far away: an S3 endpoint on this machine, and a small web server that counts what it is asked for.

#[allow(dead_code, reason = "shared with the other end-to-end tests")]
#[path = "../common/mod.rs"]
mod common;

mod cache;
mod moto;
mod ranges;
mod s3;
mod server;
mod web;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use common::capture;

/// Frames of [`orbit`]; one of them is 5 % of the tiles.
const FRAMES: u32 = 20;

/// A trace of many frames, made once.
fn orbit() -> &'static Path {
    static FILE: OnceLock<PathBuf> = OnceLock::new();
    FILE.get_or_init(|| once("orbit", &format!("--size 128x64 --frames 0..{FRAMES}")))
}

/// The same, smaller: for what does not depend on sizes.
fn few() -> &'static Path {
    static FILE: OnceLock<PathBuf> = OnceLock::new();
    FILE.get_or_init(|| once("few", "--size 64x32 --frames 0..8 --tile 16"))
}

/// Captures into the folder that Cargo gives tests.
fn once(name: &str, options: &str) -> PathBuf {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.rtrace"));
    for old in [file.clone(), file.with_extension("rtrace.partial")] {
        std::fs::remove_file(old).ok();
    }
    capture("teapot", options, &file);
    file
}

/// A trace of one small frame in `folder`, as a file; `scene` makes one different from another.
fn small(folder: &Path, scene: &str) -> PathBuf {
    let file = folder.join(format!("{scene}.rtrace"));
    capture(scene, "--size 48x32", &file);
    file
}
