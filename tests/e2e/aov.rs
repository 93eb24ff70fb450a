//! `rayreel aov`: layers of an EXR file, read by the reference library of OpenEXR.
//!
//! The part that reads is skipped, saying so, where there is no python3 with the package OpenEXR.

use std::process::Command;

use serde_json::Value;

use crate::common::{capture, digest, repository};
use crate::rayreel;

#[test]
fn openexr_reads_what_was_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, file) = (folder.path().join("chess.rtrace"), folder.path().join("a.exr"));
    capture("chess", "--size 48x32 --samples 2x2 --frames 0..2", &trace);
    let [hits, samples] = ["hits.npy", "samples.npy"].map(|name| folder.path().join(name));
    rayreel!["export", "--quiet", &trace, "--what", "hits", "--frames", "1", "-o", &hits].expect(0);
    rayreel![
        "export", "--quiet", &trace, "--what", "samples", "--frames", "1", "--policy", "paper-ss", "--set", "block=4",
        "-o", &samples
    ]
    .expect(0);
    let ran =
        rayreel!["aov", &trace, "--frame", "1", "--policy", "paper-ss", "--set", "block=4", "-o", &file].expect(0);
    assert!(ran.out.contains("frame 1, ") && ran.out.contains("of 48 x 32 pixels"), "{ran:?}");
    let again = folder.path().join("b.exr");
    rayreel!["aov", "--threads", "1", &trace, "--frame", "1", "--policy", "paper-ss", "--set", "block=4", "-o", &again]
        .expect(0);
    assert_eq!(
        std::fs::read(&file).unwrap(),
        std::fs::read(&again).unwrap(),
        "the same bytes for any number of threads"
    );
    // A trace of this frame alone is read as a whole, and its digest is known.
    let alone = folder.path().join("alone.rtrace");
    rayreel!["trim", &trace, "--frames", "1", "-o", &alone].expect(0);
    rayreel!["aov", &alone, "-o", &again].expect(0);
    let (bytes, hash) = (std::fs::read(&again).unwrap(), digest(&alone)["total"].as_str().unwrap().to_owned());
    assert!(bytes.windows(hash.len()).any(|window| window == hash.as_bytes()), "{hash}");
    let script = repository("tests/e2e/aov.py");
    let ran = Command::new("python3").arg("-B").arg(script).args([&file, &hits, &samples]).output();
    let output = match ran {
        Ok(output) => output,
        Err(error) => return eprintln!("skipped: python3 does not start: {error}"),
    };
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.code() == Some(77) {
        return eprintln!("skipped: {}", said.trim());
    }
    assert!(output.status.success(), "{said}");
    let read: Value = serde_json::from_slice(&output.stdout).unwrap();
    let channels: Vec<&str> = read["channels"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    for name in ["R", "depth.Z", "normal.X", "object.id", "material.id", "shadow.light0", "rays.all", "flip.value"] {
        assert!(channels.contains(&name), "{name} is not among {channels:?}");
    }
    assert_eq!(read["comments"], "rayreel aov chess.rtrace --frame 1 --policy paper-ss --set block=4");
    let about: Value = serde_json::from_str(read["rayreel"].as_str().unwrap()).unwrap();
    assert_eq!((&about["frame"], &about["scene"]), (&1.into(), &"chess".into()));
    assert_eq!((&about["trace_digest"], about["trace_fingerprint"].is_string()), (&Value::Null, true), "{about}");
    let traced = rayreel![
        "replay",
        "--quiet",
        "--json",
        "--machine",
        "none",
        "--policy",
        "paper-ss",
        "--set",
        "block=4",
        "--frames",
        "1",
        &trace
    ];
    let traced = traced.expect(0).json();
    assert_eq!(read["traced_samples"], traced["samples_traced"]);
    assert_eq!(read["traced_rays"], traced["rays_traced"]);
    assert_eq!(read["traced_shadow_rays"], traced["rays_by_kind"]["traced"]["shadow"]);
    let flip = |value: &Value| (value.as_f64().unwrap() * 1e5).round();
    assert_eq!(flip(&read["mean_flip"]), flip(&traced["flip"]));
}

#[test]
fn a_scene_gives_what_its_trace_gives() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("cornell", "--size 32x16 --samples 1x1", &at("c.rtrace"));
    rayreel!["aov", "--quiet", &at("c.rtrace"), "-o", &at("trace.exr")].expect(0);
    rayreel!["aov", "--quiet", "cornell", "--size", "32x16", "--samples", "1x1", "-o", &at("scene.exr")].expect(0);
    // They differ in the command alone.
    let [a, b] = ["trace.exr", "scene.exr"].map(|name| rayreel_replay::image::files::read_exr(&at(name)).unwrap());
    assert_eq!(a, b);
}

#[test]
fn wrong_requests_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, file) = (repository("traces/v1_0_cornell.rtrace"), folder.path().join("a.exr"));
    for (args, code, says) in [
        (vec!["--frame", "9"], 2, "frame 9 is not in the trace"),
        (vec!["--policy", "adaptiv"], 2, "did you mean adaptive"),
        (vec!["--set", "blok=4"], 2, "blok"),
        (vec!["--size", "64x32"], 2, "--size is for a scene"),
        (vec!["--samples", "1x1"], 2, "--samples is for a scene"),
        (vec!["--depth", "2"], 2, "--depth is for a scene"),
        (vec!["--fov", "30"], 2, "--fov is for a scene"),
    ] {
        let mut all = vec!["aov".into(), trace.clone().into_os_string(), "-o".into(), file.clone().into_os_string()];
        all.extend(args.iter().map(std::ffi::OsString::from));
        let ran = crate::common::run(&all).expect(code);
        assert!(ran.err.contains(says), "{ran:?}");
        assert!(!file.exists());
    }
    let ran = rayreel!["aov", &trace, "-o", &folder.path().join("a.png")].expect(2);
    assert!(ran.err.contains("let its name end in .exr"), "{ran:?}");
    rayreel!["aov", &folder.path().join("no.rtrace"), "-o", &file].expect(2);
}
