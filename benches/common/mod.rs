//! What the benches share: sizes, CPU time, and traces of the built-in scenes.

#![allow(dead_code, reason = "no bench uses all of it")]

use std::path::{Path, PathBuf};

use rayreel_formats::Limits;
use rayreel_formats::trace::{Codec, Trace};
use rayreel_tracer::capture::capture;
use rayreel_tracer::{CaptureOutput, SampleGrid, TraceSettings, build};
use tempfile::TempDir;

/// Width and height of `WxH`.
pub fn size(text: &str) -> (u32, u32) {
    let pair = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    pair.expect("--size takes WxH")
}

/// CPU time of all threads of this process so far, seconds. Linux counts in hundredths.
pub fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the command may hold blanks; what follows its parenthesis does not.
    let fields: Vec<_> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// The trace at `path`.
pub fn open(path: &Path) -> Trace {
    Trace::open(path, Limits::default()).expect("a trace")
}

/// A trace by its name: a file, or a scene of which one frame of 2x2 samples is captured into a folder that goes with it.
pub fn trace(name: &str, size: (u32, u32)) -> (Trace, Option<TempDir>) {
    if name.ends_with(".rtrace") {
        return (open(Path::new(name)), None);
    }
    let (path, folder) = captured(name, size);
    (open(&path), Some(folder))
}

/// One frame of a scene with 2x2 samples, in a folder that goes with it.
pub fn captured(scene: &str, (width, height): (u32, u32)) -> (PathBuf, TempDir) {
    let scene = rayreel_scenes::load(scene).expect("a scene");
    let built = build(&scene).expect("bvh");
    let grid = SampleGrid { width, height, samples: 2, tile: 32, first_frame: 0, frames: 1 };
    let meta = grid.meta(&scene, TraceSettings::default(), "bench");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bench.rtrace");
    let output = CaptureOutput::new(path.clone(), Codec::Context, 9);
    capture(&scene, &built, &meta, &output, |_| true).expect("a capture");
    (path, folder)
}
