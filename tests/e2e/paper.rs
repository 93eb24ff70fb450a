//! `rayreel paper`: the table, the pictures, and a cache that is used and trusted no further than it should be.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde_json::Value;

use crate::common::{BUILTIN, Ran, capture};
use crate::rayreel;

const MODES: [(&str, &str); 2] = [("supersampling", "2x2"), ("undersampling", "1x1")];

fn paper(folder: &Path) -> Ran {
    let (cache, out) = (folder.join("cache"), folder.join("out"));
    rayreel!["paper", "--quiet", "--size", "96x48", "--machine", "none", "--cache", &cache, "--out", &out].expect(0)
}

/// What tells whether a file was written again.
fn stamps(folder: &Path) -> BTreeMap<PathBuf, (u64, SystemTime)> {
    let stamp = |path: PathBuf| {
        let meta = fs::metadata(&path).unwrap();
        (path, (inode(&meta), meta.modified().unwrap()))
    };
    fs::read_dir(folder).unwrap().map(|entry| stamp(entry.unwrap().path())).collect()
}

#[cfg(unix)]
fn inode(meta: &fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(meta)
}

#[cfg(not(unix))]
fn inode(_: &fs::Metadata) -> u64 {
    0
}

fn check_table(text: &str) {
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    for scene in BUILTIN {
        for (mode, _) in MODES {
            let row = rows.iter().find(|row| row.starts_with(&[scene, mode]));
            let row = row.unwrap_or_else(|| panic!("no row for {scene} {mode} in\n{text}"));
            let numbers: Vec<f64> = row[2..].iter().filter_map(|word| word.parse().ok()).collect();
            let [full, traced, ratio, similar, psnr] = numbers[..5] else { panic!("{row:?}") };
            assert!(traced < full && (full / traced - ratio).abs() < 0.006, "{row:?}");
            assert!((1.0..100.0).contains(&similar) && (15.0..80.0).contains(&psnr), "{row:?}");
        }
    }
    assert!(text.contains("48.99") && text.contains("28.53"), "the paper's own values stand beside ours\n{text}");
}

fn check_pictures(out: &Path) {
    for scene in BUILTIN {
        for (mode, _) in MODES {
            let folder = out.join(format!("{scene}-{mode}"));
            for name in ["result.png", "reference.png"] {
                let picture = image::open(folder.join(name)).unwrap().into_rgb8();
                assert_eq!(picture.dimensions(), (96, 48), "{scene} {mode} {name}");
                let first = picture.get_pixel(0, 0);
                assert!(picture.pixels().any(|p| p != first), "{scene} {mode} {name} is flat");
            }
            image::open(folder.join("similarity.png")).unwrap();
            let exr = rayreel_replay::image::files::read_exr(&folder.join("result.exr")).unwrap();
            assert_eq!((exr.width, exr.height), (96, 48));
        }
    }
}

#[test]
fn the_second_run_captures_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let first = paper(folder.path());
    check_table(&first.out);
    check_pictures(&folder.path().join("out"));
    let cache = folder.path().join("cache");
    let before = stamps(&cache);
    assert_eq!(before.len(), BUILTIN.len() * MODES.len(), "{before:?}");
    let second = paper(folder.path());
    assert_eq!(first.out, second.out);
    assert_eq!(before, stamps(&cache), "a trace was written again");

    // The same numbers for programs.
    let file = fs::read_to_string(folder.path().join("out/paper.json")).unwrap();
    let rows: Vec<Value> = serde_json::from_str(&file).unwrap();
    assert_eq!(rows.len(), BUILTIN.len() * MODES.len());
    for row in rows {
        let keys = ["rays_full", "rays_traced", "ray_ratio", "psnr_db", "ssim"];
        keys.iter().for_each(|key| assert!(row[*key].is_number(), "{key} in {row}"));
        assert!(row["ti_alone"].is_null() && row["gpu"].is_null(), "no machine, and it says so: {row}");
    }
}

/// Performance and power beside the paper's: from the machine's own figures, the same for any number of threads.
#[test]
fn the_machine_stands_beside_the_paper() {
    let folder = tempfile::tempdir().unwrap();
    let (cache, out) = (folder.path().join("cache"), folder.path().join("out"));
    let run = |more: &str| {
        let line = format!("paper --quiet --size 64x32 --scene teapot --scene cornell {more} --cache");
        let mut args: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
        args.extend([cache.as_os_str(), "--out".as_ref(), out.as_os_str()].map(ToOwned::to_owned));
        crate::common::run(&args).expect(0).out
    };
    let text = run("--threads 2");
    for part in ["2.43 to 2.98", "1.09", "T&I units alone", "whole GPU", "Mrays/s", "sgrt-ti2"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let json = run("--threads 1 --json");
    assert_eq!(json, run("--threads 3 --json"));
    let rows: Vec<Value> = serde_json::from_str(&json).unwrap();
    assert_eq!(rows.len(), 2 * MODES.len());
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value}"));
    for row in rows {
        for part in ["ti_alone", "gpu"] {
            let own = &row[part];
            let cost = |run: &Value| if part == "gpu" { run["gpu"].clone() } else { run.clone() };
            let (full, adaptive) = (&own["full"], &own["adaptive"]);
            let expected = [
                ("performance", number(&full["time_ms"]) / number(&adaptive["time_ms"])),
                ("power", number(&cost(adaptive)["power_w"]) / number(&cost(full)["power_w"])),
                ("perf_per_watt", number(&cost(full)["energy_mj"]) / number(&cost(adaptive)["energy_mj"])),
            ];
            for (key, value) in expected {
                assert!((number(&own["gain"][key]) / value - 1.0).abs() < 1e-9, "{part} {key} in {row}");
            }
            assert_eq!(full["rays_machine"], row["rays_full"]);
            assert_eq!(adaptive["rays_machine"], row["rays_traced"]);
        }
        // An SRP that takes no time helps, but for what another order of memory requests may cost.
        let cycles = |part: &str| number(&row[part]["full"]["cycles"]);
        assert!(cycles("ti_alone") < 1.05 * cycles("gpu"), "{row}");
        for key in ["similarity_share", "interpolation_share"] {
            assert!((0.001..0.5).contains(&number(&row["srp"][key])), "{key} in {row}");
        }
        assert_eq!(row["ti_alone"]["paper_perf_per_watt"].is_object(), row["scene"] == "teapot");
    }
}

/// A trace in the cache that is not the one wanted, is damaged or was cut short is captured again; the others stay.
#[test]
fn the_cache_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let (cache, out) = (folder.path().join("cache"), folder.path().join("out"));
    let run = || {
        let line = "paper --size 64x32 --scene cornell --quiet --machine none --cache";
        let mut args: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
        args.extend([cache.as_os_str(), "--out".as_ref(), out.as_os_str()].map(ToOwned::to_owned));
        crate::common::run(&args).expect(0).out
    };
    let expected = run();
    let names = ["cornell-64x32-2x2.rtrace", "cornell-64x32-1x1.rtrace"].map(|name| cache.join(name));
    let bytes = names.each_ref().map(|name| fs::read(name).unwrap());
    let other = stamps(&cache)[&names[1]];

    // Another capture under this name.
    capture("cornell", "--size 64x32 --depth 1 --force", &names[0]);
    assert_eq!(run(), expected);
    assert!(fs::read(&names[0]).unwrap() == bytes[0]);
    // A file without an end.
    fs::write(&names[0], &bytes[0][..bytes[0].len() / 2]).unwrap();
    assert_eq!(run(), expected);
    // What a killed run left.
    fs::remove_file(&names[0]).unwrap();
    fs::write(cache.join("cornell-64x32-2x2.rtrace.partial"), &bytes[0][..bytes[0].len() / 2]).unwrap();
    assert_eq!(run(), expected);
    assert!(fs::read(&names[0]).unwrap() == bytes[0], "resumed to the same bytes");
    assert_eq!(stamps(&cache)[&names[1]], other, "the other trace was left alone");
}
