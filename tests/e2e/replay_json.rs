//! What programs read: the JSON of `capture`, `info` and `replay`.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::common::scenes::moving;
use crate::common::{capture, digest, replay, run};
use crate::rayreel;

fn trace(folder: &Path, scene: &str, options: &str) -> PathBuf {
    let file = folder.join("a.rtrace");
    capture(scene, options, &file);
    file
}

#[test]
fn capture_says_what_it_did() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.rtrace");
    let said = capture("teapot", "--size 41x23 --samples 2x2 --frames 3..5", &file);
    let keys = ["scene", "triangles", "frames", "samples", "rays", "steps", "file_bytes", "path_bytes", "rays_per_s"];
    keys.iter().for_each(|key| assert!(!said[*key].is_null(), "{key} is missing in {said}"));
    assert_eq!((&said["scene"], &said["frames"], &said["samples"]), (&json!("teapot"), &json!(2), &json!(41 * 23 * 8)));
    assert_eq!(said["file_bytes"], fs::metadata(&file).unwrap().len());
    let info = rayreel!["info", "--json", &file].expect(0).json();
    for key in ["scene", "triangles", "frames", "rays", "file_bytes"] {
        assert_eq!(said[key], info[key], "{key}");
    }
    assert_eq!(said["path_bytes"], info["bytes"]["paths"]);
    let parts: u64 = info["bytes"].as_object().unwrap().values().map(|v| v.as_u64().unwrap()).sum();
    assert_eq!(said["file_bytes"], parts, "the parts make up the file");
    let kinds: u64 = info["rays_by_kind"].as_object().unwrap().values().map(|v| v.as_u64().unwrap()).sum();
    assert_eq!(said["rays"], kinds);
    let verified = rayreel!["verify", "--json", "--quiet", &file].json();
    assert_eq!((&said["rays"], &said["steps"]), (&verified["rays"], &verified["steps"]));
}

#[test]
fn replay_has_the_promised_keys() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), "cornell", "--size 60x34");
    let said = replay(&file, "--policy adaptive-4").expect(0).json();
    let quality = ["psnr_db", "ssim", "flip", "worst_tile_psnr_db", "worst_tile"];
    for key in ["rays_full", "rays_traced", "samples_traced", "samples_interpolated"].into_iter().chain(quality) {
        assert!(said[key].is_number(), "{key}: {}", said[key]);
        assert!(said["descriptions"][key]["unit"].is_string(), "{key} has no unit");
        assert!(said["descriptions"][key]["description"].is_string(), "{key} is not described");
    }
    assert_eq!((&said["trace"], &said["policy"]), (&json!("a.rtrace"), &json!("adaptive-4")));
    assert_eq!(said.get("machine"), Some(&Value::Null), "no machine model, and it says so");
    assert_eq!(said["trace_digest"], digest(&file)["total"]);
    assert!(said["trace_fingerprint"].is_string());
    let number = |key: &str| said[key].as_u64().unwrap();
    assert_eq!(number("samples_traced") + number("samples_interpolated"), 60 * 34 * 4);
    assert!(number("rays_traced") < number("rays_full"));
    assert_eq!(number("rays_full"), rayreel!["info", "--json", &file].json()["rays"].as_u64().unwrap());
    assert!(!said.to_string().contains("seconds"), "no wall clock");
}

#[test]
fn a_machine_adds_its_figures_and_changes_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), &moving(folder.path()), "--size 40x26 --frames 1..4");
    let plain = replay(&file, "").expect(0).json();
    let out = folder.path().join("out");
    let said = replay(&file, &format!("--machine sgrt-ti2 --out {}", out.display())).expect(0).json();
    assert_eq!(said["machine"], "sgrt-ti2");
    for key in ["rays_full", "rays_traced", "samples_traced", "psnr_db", "ssim", "trace_digest", "policy_config"] {
        assert_eq!(said[key], plain[key], "{key}");
    }
    for key in ["cycles", "time_ms", "mrays_per_s", "power_w", "energy_mj", "perf_per_watt", "energy_per_ray_nj"] {
        assert!(said[key].as_f64() > Some(0.0), "{key}: {}", said[key]);
        assert!(plain.get(key) == Some(&Value::Null), "{key} is null without a machine");
    }
    for key in ["power_w", "energy_mj", "perf_per_watt"] {
        assert!(said["gpu"][key].as_f64() > Some(0.0), "gpu {key}");
    }
    assert!(said["counters"]["ti/trv/node_visits"]["value"].as_u64() > Some(0));
    let frames = said["frames"].as_array().unwrap();
    let sum = |key: &str| frames.iter().map(|f| f[key].as_u64().unwrap()).sum::<u64>();
    assert_eq!((frames.len(), Some(sum("cycles"))), (3, said["cycles"].as_u64()));
    // A frame by itself is the frame of the sequence: caches are cold at its beginning.
    let one = replay(&file, "--machine sgrt-ti2 --frames 2").expect(0).json();
    assert_eq!((&one["cycles"], &one["energy_mj"]), (&frames[1]["cycles"], &frames[1]["energy_mj"]));
    assert_eq!(one["frames"].as_array().unwrap().len(), 1);
    let known = ["trace_fingerprint", "trace_digest"].map(|key| one[key] == said[key]);
    assert_eq!((known, &one["trace_digest"]), ([true, false], &Value::Null), "a digest would read all frames");
    let mut same = replay(&file, "--machine sgrt-ti2 --frames 1..4").expect(0).json();
    same["command"] = said["command"].clone();
    assert_eq!(same, said, "in other words");
}

/// Overrides go to the machine or to the policy by their key.
#[test]
fn overrides_find_their_way() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), "cornell", "--size 40x24");
    let said =
        replay(&file, "--machine sgrt-ti1 --set block=4 --set ti.clock_mhz=400 --set gpu.cores=1").expect(0).json();
    assert_eq!(said["machine"], "sgrt-ti1+ti.clock_mhz=400+gpu.cores=1");
    assert_eq!((&said["policy"], &said["policy_config"]["block"]), (&json!("adaptive+block=4"), &json!(4)));
    let value = &said["machine_config"]["ti.clock_mhz"];
    assert_eq!((&value["value"], &value["class"]), (&json!(400), &json!("override")));
    let ms = said["cycles"].as_f64().unwrap() / 400e3;
    assert!((said["time_ms"].as_f64().unwrap() / ms - 1.0).abs() < 1e-12);
}

#[test]
fn frames_add_up() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), &moving(folder.path()), "--size 40x26 --frames 1..4");
    let out = folder.path().join("out");
    let said = replay(&file, &format!("--out {}", out.display())).expect(0).json();
    let frames = said["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|f| f["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2, 3]);
    for key in ["rays_full", "rays_traced", "rays_saved", "samples_traced", "samples_interpolated"] {
        let sum: i64 = frames.iter().map(|f| f[key].as_i64().unwrap()).sum();
        assert_eq!(said[key], sum, "{key}");
        let tiles =
            |f: &Value| f["tiles"].as_array().unwrap().iter().map(|t| t[key].as_i64().unwrap_or(0)).sum::<i64>();
        if key != "rays_saved" {
            frames.iter().for_each(|f| assert_eq!(f[key], tiles(f), "{key} of the tiles"));
        }
    }
    // The PSNR of the mean squared error over all frames, not the mean of the decibels.
    let error = |f: &Value| 10f64.powf(-f["psnr_db"].as_f64().unwrap() / 10.0);
    let mean = -10.0 * (frames.iter().map(error).sum::<f64>() / 3.0).log10();
    assert!((said["psnr_db"].as_f64().unwrap() - mean).abs() < 1e-9, "{} {mean}", said["psnr_db"]);
    // A frame's flicker is since the one before.
    assert_eq!(frames.iter().map(|f| f["flicker"].is_number()).collect::<Vec<_>>(), [false, true, true]);
    assert!(said["flicker"].as_f64() > Some(0.0) && said["flicker_db"].is_number());
    for frame in 1..4 {
        for name in ["result.exr", "result.png", "reference.png", "error.png", "flip.png", "similarity.png"] {
            assert!(out.join(format!("frame_{frame:04}_{name}")).is_file(), "{name} of frame {frame}");
        }
    }
}

#[test]
fn the_bytes_do_not_depend_on_threads_or_folder() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), "teapot", "--size 63x35 --tile 16 --frames 7..9");
    for policy in ["full", "adaptive", "adaptive-8"] {
        let outs = [1, 2, 3].map(|threads| {
            let out = folder.path().join(format!("{policy}-{threads}"));
            let options = format!("--policy {policy} --threads {threads} --out {}", out.display());
            (replay(&file, &options).expect(0).out, out)
        });
        for (said, out) in &outs {
            assert!(*said == outs[0].0, "{policy}: JSON");
            assert_eq!(fs::read_to_string(out.join("stats.json")).unwrap(), *said, "stats.json is what is printed");
            for entry in fs::read_dir(&outs[0].1).unwrap() {
                let name = entry.unwrap().file_name();
                let same = fs::read(out.join(&name)).unwrap() == fs::read(outs[0].1.join(&name)).unwrap();
                assert!(same, "{policy}: {}", name.display());
            }
        }
    }
}

/// A folder of results says what made it, whoever finds it: the same words wherever it was made.
#[test]
fn results_say_what_made_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), "cornell", "--size 40x20");
    let (policy, out) = (folder.path().join("my policy.toml"), folder.path().join("out"));
    fs::write(&policy, "extends = \"adaptive\"\n").unwrap();
    let policy = policy.to_str().unwrap();
    let options = [
        "--policy",
        policy,
        "--set",
        "block=4",
        "--frames",
        "0",
        "--detail",
        "all",
        "--warm",
        "--threads",
        "2",
        "--quiet",
    ];
    let run = |more: &[&str]| {
        let args =
            ["replay".as_ref(), file.as_os_str()].into_iter().chain(options.iter().chain(more).map(|s| s.as_ref()));
        run(&args.map(Into::into).collect::<Vec<_>>()).expect(0).out
    };
    let said: Value = serde_json::from_str(&run(&["--json"])).unwrap();
    let command = "rayreel replay a.rtrace --policy 'my policy.toml' --machine sgrt-ti2 --set block=4 --frames 0..1 --detail all --warm";
    assert_eq!(said["command"], command);
    assert_eq!(said["program"], format!("rayreel {}", env!("CARGO_PKG_VERSION")));
    assert_eq!(said["model_version"], rayreel_study::point::version::MODEL_VERSION);
    run(&["--out", out.to_str().unwrap()]);
    let stats: Value = serde_json::from_slice(&fs::read(out.join("stats.json")).unwrap()).unwrap();
    assert_eq!(stats, said);
    let exr = fs::read(out.join("result.exr")).unwrap();
    let holds = |words: &str| exr.windows(words.len()).any(|bytes| bytes == words.as_bytes());
    let about = json!({ "model_version": said["model_version"], "trace": "a.rtrace", "trace_fingerprint": said["trace_fingerprint"],
        "trace_digest": said["trace_digest"], "frame": 0, "policy": said["policy"], "machine": said["machine"] });
    for words in [command, &about.to_string(), said["program"].as_str().unwrap(), "software"] {
        assert!(holds(words), "{words}");
    }
    assert!(!holds(folder.path().to_str().unwrap()), "no folder of this machine");
}

#[test]
fn overrides_are_the_same_as_a_policy_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), "cornell", "--size 60x34");
    let figures = |options: &str| {
        let said = replay(&file, options).expect(0).json();
        (said["policy_config"].clone(), said["rays_traced"].clone(), said["psnr_db"].clone(), said["policy"].clone())
    };
    let preset = figures("--policy adaptive-4");
    let set = figures("--policy adaptive --set block=4 --set refine=hierarchical");
    assert_eq!((&preset.0, &preset.1, &preset.2), (&set.0, &set.1, &set.2));
    assert_eq!(set.3, "adaptive+block=4+refine=hierarchical");
    let file_policy = folder.path().join("own.toml");
    fs::write(&file_policy, "kind = \"adaptive\"\nblock = 4\nrefine = \"hierarchical\"\n").unwrap();
    let from_file = figures(&format!("--policy {}", file_policy.display()));
    assert_eq!((&from_file.0, &from_file.1, &from_file.3), (&set.0, &set.1, &json!("own")));

    let loose =
        figures("--set similarity.normal_deg=90 --set similarity.object_id=false --set similarity.shadow=false");
    let plain = figures("--policy adaptive");
    assert!(loose.1.as_u64() < plain.1.as_u64(), "looser tests trace less: {} {}", loose.1, plain.1);
    assert_eq!(loose.0["similarity"]["normal_deg"], 90.0);
    let full = figures("--policy adaptive --set kind=full");
    assert_eq!(full.2, Value::Null, "full is identical to itself");
}

#[test]
fn wrong_policies_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), "cornell", "--size 16x16");
    for (options, words) in [
        ("--policy adaptiv", vec!["adaptiv", "did you mean adaptive?"]),
        ("--policy nowhere/own.toml", vec!["cannot read the policy file", "nowhere/own.toml"]),
        ("--set blok=4", vec!["blok", "did you mean block?"]),
        ("--set similarity.normal_degs=4", vec!["did you mean similarity.normal_deg?"]),
        ("--set block=5", vec!["block = 5", "2 or 3 or 4 or 8"]),
        ("--set refine=both", vec!["refine", "\"direct\" or \"hierarchical\""]),
        ("--set similarity.normal_deg=200", vec!["similarity.normal_deg", "0 to 180"]),
        ("--set block", vec!["key=value"]),
        ("--policy full --set block=4", vec!["block", "full"]),
        ("--set block=3", vec!["block = 3", "tiles of 32", "2, 4, 8"]),
    ] {
        let ran = replay(&file, options).expect(2).says(&words);
        assert_eq!(ran.out, "", "{options}");
    }
}

#[test]
fn people_get_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path(), "cornell", "--size 32x20");
    let text = run(&["replay".into(), "--quiet".into(), file.into()]).expect(0).out;
    for word in ["a.rtrace", "adaptive", "rays", "primary", "shadow", "PSNR", "SSIM", "sgrt-ti2", "Mrays/s", "row hits"]
    {
        assert!(text.contains(word), "no {word} in\n{text}");
    }
}
