//! What captures of the built-in scenes are, bit for bit: on every machine, built for any processor. `tests/processors.sh` runs this
//! test on builds for several.
//!
//! `traces/captures.txt` holds a line a scene: the digest of what the trace says, and the hash of the file. `RAYREEL_BLESS=1`
//! writes it anew.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use rayreel_formats::trace::{Codec, digest};
use rayreel_formats::{Limits, Trace};
use rayreel_tracer::{CaptureOutcome, CaptureOutput, SampleGrid, TraceSettings, build, capture::capture};

#[test]
fn captures_are_the_same_on_every_processor() {
    let folder = tempfile::tempdir().unwrap();
    let mut page = String::new();
    for name in rayreel_scenes::builtin_names() {
        let scene = rayreel_scenes::builtin(name).unwrap();
        let grid = SampleGrid { width: 64, height: 32, samples: 2, tile: 32, first_frame: 0, frames: 1 };
        let meta = grid.meta(&scene, TraceSettings::default(), "captures");
        let path = folder.path().join(name);
        let output = CaptureOutput::new(path.clone(), Codec::Context, 9);
        let outcome = capture(&scene, &build(&scene).unwrap(), &meta, &output, |_| true).unwrap();
        assert!(matches!(outcome, CaptureOutcome::Finished(_)), "{name}");
        let digest = digest(&Trace::open(&path, Limits::default()).unwrap()).unwrap();
        writeln!(page, "{name} {} {}", digest.total(), blake3::hash(&fs::read(&path).unwrap())).unwrap();
    }
    let expected = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/captures.txt");
    if std::env::var_os("RAYREEL_BLESS").is_some() {
        fs::write(&expected, &page).unwrap();
    }
    let expected = fs::read_to_string(expected).unwrap();
    assert_eq!(page, expected, "captures changed; RAYREEL_BLESS=1 writes traces/captures.txt anew");
}
