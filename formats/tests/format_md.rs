//! FORMAT.md is enough to read a trace: `format_reader.py` was written from it, and must find in every trace what this crate
//! finds.
//!
//! Skipped where there is no python3, or none that can decompress zstd.

mod trace_support;

use std::path::{Path, PathBuf};
use std::process::Command;

use rayreel_formats::Limits;
use rayreel_formats::trace::{Codec, Trace, digest};
use trace_support::whole::Content;

/// What the reader says when Python has no zstd.
const NO_ZSTD: i32 = 77;

/// The reader's digest of a trace, or why it cannot run.
fn python_digest(path: &Path) -> Result<String, String> {
    let reader = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/format_reader.py");
    let output = Command::new("python3").arg("-B").arg(reader).arg(path).arg("--digest").output();
    let output = output.map_err(|e| format!("python3 does not start: {e}"))?;
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.code() == Some(NO_ZSTD) {
        return Err(errors);
    }
    assert!(output.status.success(), "the reader fails on {}: {errors}", path.display());
    Ok(String::from_utf8(output.stdout).expect("the reader prints text"))
}

/// True when the reader could run; it then found the same.
fn reads_alike(path: &Path) -> bool {
    let found = match python_digest(path) {
        Ok(found) => found,
        Err(why) => {
            eprintln!("skipped: {}", why.trim());
            return false;
        }
    };
    let trace = Trace::open(path, Limits::default()).expect("this crate reads its own trace");
    let digest = digest(&trace).expect("the trace is whole");
    let mut expected: String = digest.parts().iter().map(|(name, hash)| format!("{hash}  {name}\n")).collect();
    expected += &format!("{}  total\n", digest.total());
    assert_eq!(found, expected, "{}", path.display());
    true
}

#[test]
fn golden_traces() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: there is no {}", folder.display());
        return;
    };
    let mut traces: Vec<PathBuf> = entries.map(|entry| entry.expect("the folder can be read").path()).collect();
    traces.retain(|path| path.extension().is_some_and(|e| e == "rtrace"));
    traces.sort();
    for path in traces {
        if !reads_alike(&path) {
            return;
        }
    }
}

/// Made-up tiles have what no tracer writes: cut-outs and dielectrics side by side, refractions where there are none, any `t`
/// and normal, and hardly anything as predicted.
#[test]
fn made_up_traces_of_either_codec_and_of_both() {
    // Seed, size, tile edge, triangles, depth, lights.
    let cases = [
        (1, (9, 7), 4, 40, 3, 2),
        (2, (12, 8), 8, 300, 1, 16),
        (3, (5, 5), 16, 0, 2, 1),
        (4, (20, 1), 7, 3, 14, 0),
        (5, (1, 20), 5, 5, 0, 3),
        (6, (24, 24), 12, 1000, 4, 1),
    ];
    for (seed, size, tile, triangles, depth, lights) in cases {
        let content = Content::random(seed, size, tile, triangles, depth, lights);
        for codec in [|_| Codec::Plain(1), |_| Codec::Context, |tile| if tile % 2 == 0 { Codec::Plain(3) } else { Codec::Context }] {
            let codec: fn(u32) -> Codec = codec;
            let (_folder, path) = content.write(|tile| codec(tile.index));
            if !reads_alike(&path) {
                return;
            }
        }
    }
}

/// More paths in a tile than there are path numbers, so that the labels are forgotten on the way.
#[test]
fn more_paths_than_numbers() {
    let content = Content::random(7, (110, 110), 110, 6, 0, 2);
    let (_folder, path) = content.write(|_| Codec::Context);
    reads_alike(&path);
}
