//! Golden traces: the committed files, their digests and replay results, and a capture anew that must give the same.
//!
//! Every value is compared exactly. What differs was changed by someone: either by mistake, or `traces/` is written anew.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::common::{BLESS, blessing, capture, digest, replay, repository};
use crate::rayreel;

/// Name of the file, scene, options of the capture.
const GOLDENS: [(&str, &str, &str); 2] = [
    ("v1_0_cornell.rtrace", "cornell", "--size 80x48 --samples 1x1 --tile 16 --depth 2"),
    ("v1_0_teapot.rtrace", "teapot", "--size 32x16 --samples 2x2 --frames 30..32 --level 19"),
];

const POLICIES: [&str; 3] = ["full", "adaptive", "adaptive-8"];

/// What of a replay is kept: counts, and the two figures of quality to the last bit.
const FIGURES: [&str; 8] = [
    "rays_full",
    "rays_traced",
    "rays_by_kind",
    "samples_full",
    "samples_traced",
    "samples_interpolated",
    "psnr_db",
    "ssim",
];

/// Both committed traces together stay below this.
const MOST_BYTES: u64 = 300_000;

fn committed(name: &str) -> PathBuf {
    repository("traces").join(name)
}

fn expected() -> Map<String, Value> {
    let path = committed("goldens.json");
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}; {BLESS}", path.display()));
    serde_json::from_str(&text).unwrap()
}

/// The results of all policies on a trace.
fn replays(file: &Path, threads: usize) -> Value {
    let one = |policy: &str| {
        let said = replay(file, &format!("--policy {policy} --threads {threads}")).expect(0).json();
        FIGURES.iter().map(|key| ((*key).to_string(), said[*key].clone())).collect::<Map<_, _>>()
    };
    POLICIES.iter().map(|policy| ((*policy).to_string(), Value::Object(one(policy)))).collect()
}

fn entry(scene: &str, options: &str, file: &Path) -> Value {
    json!({
        "capture": format!("rayreel capture {scene} {options}"),
        "digest": digest(file),
        "replay": replays(file, 0),
    })
}

#[track_caller]
fn assert_same(what: &str, found: &Value, expected: &Value) {
    assert_eq!(found, expected, "{what} changed; {BLESS}");
}

/// Rewrites the files if it is asked to; the tests below then see the new ones.
fn bless() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        if !blessing() {
            return;
        }
        let mut all = Map::new();
        for (name, scene, options) in GOLDENS {
            capture(scene, &format!("{options} --force"), &committed(name));
            all.insert(name.into(), entry(scene, options, &committed(name)));
        }
        fs::write(committed("goldens.json"), format!("{:#}\n", Value::Object(all))).unwrap();
    });
}

#[test]
fn committed_traces_hold_what_they_held() {
    bless();
    let expected = expected();
    assert_eq!(expected.len(), GOLDENS.len(), "{BLESS}");
    for (name, ..) in GOLDENS {
        assert_same(&format!("digest of {name}"), &digest(&committed(name)), &expected[name]["digest"]);
        rayreel!["verify", "--quiet", &committed(name)].expect(0);
    }
}

#[test]
fn committed_traces_replay_as_they_did() {
    bless();
    let expected = expected();
    for (name, ..) in GOLDENS {
        for threads in [1, 3] {
            let found = replays(&committed(name), threads);
            assert_same(&format!("replay of {name}, {threads} threads,"), &found, &expected[name]["replay"]);
        }
    }
}

/// Scene, tracer and codec give what they gave when the file was written.
#[test]
fn a_capture_anew_gives_the_same() {
    bless();
    let (expected, folder) = (expected(), tempfile::tempdir().unwrap());
    for (name, scene, options) in GOLDENS {
        let command = format!("rayreel capture {scene} {options}");
        assert_same(&format!("capture of {name}"), &command.into(), &expected[name]["capture"]);
        for threads in [1, 3] {
            let file = folder.path().join(format!("{threads}-{name}"));
            capture(scene, &format!("{options} --threads {threads}"), &file);
            let what = format!("digest of a new {name}, {threads} threads,");
            assert_same(&what, &digest(&file), &expected[name]["digest"]);
            rayreel!["diff", &committed(name), &file].expect(0);
        }
    }
}

/// The file itself, byte for byte: the codec gives what it gave, unless the format was meant to change.
#[test]
fn a_capture_anew_gives_the_same_bytes() {
    bless();
    let folder = tempfile::tempdir().unwrap();
    for (name, scene, options) in GOLDENS {
        let file = folder.path().join(name);
        capture(scene, options, &file);
        assert!(fs::read(&file).unwrap() == fs::read(committed(name)).unwrap(), "bytes of {name} changed; {BLESS}");
    }
}

#[test]
fn golden_traces_stay_small() {
    bless();
    let bytes: u64 = GOLDENS.iter().map(|(name, ..)| fs::metadata(committed(name)).unwrap().len()).sum();
    assert!(bytes < MOST_BYTES, "{bytes} bytes");
}

/// The goldens exercise what they are for: all kinds of rays, and samples that pass and fail.
#[test]
fn golden_traces_are_worth_it() {
    bless();
    for (name, golden) in expected() {
        let full = &golden["replay"]["full"];
        for kind in ["primary", "reflection", "refraction", "shadow"] {
            assert!(full["rays_by_kind"]["full"][kind].as_u64() > Some(100), "{name}: {kind} rays");
        }
        for policy in ["adaptive", "adaptive-8"] {
            let figures = &golden["replay"][policy];
            assert!(figures["samples_interpolated"].as_u64() > Some(500), "{name} {policy}");
            assert!(figures["samples_traced"].as_u64() > Some(500), "{name} {policy}");
            assert!(figures["psnr_db"].as_f64() > Some(20.0), "{name} {policy}");
        }
    }
}
