//! `rayreel paper`: tables, pictures, study and page, and a cache that is used and trusted no further than it should be.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use rayreel_study::schema::{SCHEMA, Study};
use serde_json::Value;

use crate::common::{Ran, capture};

const MODES: [(&str, &str); 2] = [("supersampling", "2x2"), ("undersampling", "1x1")];

/// The arguments of a run whose folders are in `folder`.
fn args(folder: &Path, line: &str) -> Vec<OsString> {
    let mut args: Vec<OsString> = format!("paper --quiet {line}").split_whitespace().map(OsString::from).collect();
    for name in ["cache", "out"] {
        args.extend([format!("--{name}").into(), folder.join(name).into_os_string()]);
    }
    args
}

fn paper(folder: &Path, line: &str) -> Ran {
    crate::common::run(&args(folder, line)).expect(0)
}

/// Path relative to the folder, and what tells whether the file was written again, of all files in and below `folder`.
fn stamps(folder: &Path) -> BTreeMap<PathBuf, (u64, SystemTime)> {
    let mut all = BTreeMap::new();
    for file in files(folder) {
        let meta = fs::metadata(folder.join(&file)).unwrap();
        all.insert(file, (inode(&meta), meta.modified().unwrap()));
    }
    all
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut open = vec![PathBuf::new()];
    while let Some(inner) = open.pop() {
        for entry in fs::read_dir(folder.join(&inner)).unwrap() {
            let path = inner.join(entry.unwrap().file_name());
            if folder.join(&path).is_dir() { open.push(path) } else { files.push(path) }
        }
    }
    files
}

/// All bytes below a folder.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    files(folder).into_iter().map(|file| (file.clone(), fs::read(folder.join(file)).unwrap())).collect()
}

#[cfg(unix)]
fn inode(meta: &fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(meta)
}

#[cfg(not(unix))]
fn inode(_: &fs::Metadata) -> u64 {
    0
}

fn study(folder: &Path) -> Study {
    let study: Study = serde_json::from_slice(&fs::read(folder.join("out/study.json")).unwrap()).unwrap();
    assert_eq!(study.schema, SCHEMA);
    study
}

/// The first table: the paper's policies.
fn check_table(text: &str, study: &Study) {
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    for (scene, (word, mode)) in study.scenes.iter().flat_map(|scene| MODES.map(|mode| (&scene.name, mode))) {
        let row = rows.iter().find(|row| row.starts_with(&[scene, word]));
        let row = row.unwrap_or_else(|| panic!("no row for {scene} {word} in\n{text}"));
        let numbers: Vec<f64> = row[2..].iter().filter_map(|word| word.parse().ok()).collect();
        let [full, traced, ratio, rate, psnr] = numbers[..5] else { panic!("{row:?}") };
        assert!(traced < full && (full / traced - ratio).abs() < 0.006, "{row:?}");
        assert!((20.0..100.0).contains(&rate) && (15.0..80.0).contains(&psnr), "{row:?}");
        let policy = if mode == "2x2" { "paper-ss" } else { "paper-us" };
        let point = study.points.iter().find(|p| p.scene == *scene && p.mode == mode && p.policy == policy).unwrap();
        assert_eq!((point.rays_full as f64, point.rays_traced as f64), (full, traced));
    }
}

/// Every picture that the study names is there and shows something.
fn check_pictures(folder: &Path, study: &Study) {
    let out = folder.join("out");
    let open = |name: &str| image::open(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}")).into_rgb8();
    assert!(!study.viewer.is_empty());
    for set in &study.viewer {
        let images = [&set.images.reference, &set.images.result, &set.images.similarity];
        for name in images.map(|name| name.as_deref().expect("a picture of each kind")) {
            let picture = open(name);
            assert_eq!(picture.dimensions(), (set.width, set.height), "{name}");
            let first = picture.get_pixel(0, 0);
            assert!(picture.pixels().any(|p| p != first), "{name} is flat");
        }
        assert!(
            open(set.images.error.as_deref().unwrap()).pixels().any(|p| p.0 != [0; 3]),
            "{} has errors",
            set.policy
        );
        assert_eq!(set.images.rate.is_some(), set.policy == "multirate");
        assert!(!set.tiles.is_empty());
        let point =
            study.points.iter().find(|p| (&p.scene, &p.mode, &p.policy) == (&set.scene, &set.mode, &set.policy));
        assert_eq!(set.tiles.iter().map(|tile| tile.rays_traced).sum::<u64>(), point.unwrap().rays_traced);
    }
    study
        .maps
        .iter()
        .flat_map(|map| [Some(&map.similarity), map.rate.as_ref(), map.picture.as_ref()])
        .flatten()
        .for_each(|name| {
            open(name);
        });
}

#[test]
fn the_second_run_computes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let line = "--size 64x32 --machine none --scene cornell --scene teapot";
    let first = paper(folder.path(), line);
    let study = study(folder.path());
    assert_eq!(study.scenes.len(), 2);
    check_table(&first.out, &study);
    check_pictures(folder.path(), &study);
    assert!(first.out.contains("48.99"), "the paper's own values stand beside ours\n{}", first.out);
    assert!(study.points.iter().all(|p| p.ti.is_none() && p.gpu.is_none()), "no machine, and it says so");

    let (cache, out) = (folder.path().join("cache"), folder.path().join("out"));
    let (cached, written) = (stamps(&cache), bytes(&out));
    let second = paper(folder.path(), &format!("{line} --threads 1"));
    assert_eq!(first.out, second.out);
    assert_eq!(cached, stamps(&cache), "something was computed again");
    assert!(written == bytes(&out), "other bytes");

    // The traces are not even looked at, and the pictures come back though their folder is gone.
    files(&cache).iter().filter(|f| f.extension().is_some_and(|e| e == "rtrace")).for_each(|f| {
        fs::remove_file(cache.join(f)).unwrap();
    });
    fs::remove_dir_all(&out).unwrap();
    paper(folder.path(), line);
    assert!(written == bytes(&out), "other bytes from the cache alone");

    // The same numbers for programs.
    let rows: Vec<Value> = serde_json::from_slice(&written[Path::new("paper.json")]).unwrap();
    assert_eq!(rows.len(), study.points.iter().filter(|p| p.kind != "full").count());
    for row in rows {
        let keys = ["rays_full", "rays_traced", "ray_ratio", "psnr_db", "ssim", "flip"];
        keys.iter().for_each(|key| assert!(row[*key].is_number(), "{key} in {row}"));
        assert!(row["ti_alone"].is_null() && row["gpu"].is_null(), "{row}");
    }
    assert!(fs::read_to_string(out.join("report.html")).unwrap().contains("multirate"));
}

/// Performance and power beside the paper's: from the machine's own figures, the same for any number of threads.
#[test]
fn the_machine_stands_beside_the_paper() {
    let [a, b] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let line = "--size 32x16 --scene teapot";
    let text = paper(a.path(), &format!("{line} --threads 2")).out;
    for part in ["2.43 to 2.98", "1.09", "T&I units alone", "whole GPU", "sgrt-ti2", "tile buffer", "naive"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let json = paper(b.path(), &format!("{line} --threads 1 --json")).out;
    assert_eq!(json.as_bytes(), fs::read(a.path().join("out/paper.json")).unwrap());
    assert!(bytes(&a.path().join("out")) == bytes(&b.path().join("out")), "other bytes with another number of threads");
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value}"));
    for row in serde_json::from_str::<Vec<Value>>(&json).unwrap() {
        let evaluated = row["as_in_the_paper"] == true;
        for part in if evaluated { &["ti_alone", "gpu"][..] } else { &["ti_alone"] } {
            let (full, policy, gain) = (&row[part]["full"], &row[part]["own"], &row[part]["gain"]);
            let expected = [
                ("performance", number(&full["time_ms"]) / number(&policy["time_ms"])),
                ("power", number(&policy["power_w"]) / number(&full["power_w"])),
                ("perf_per_watt", number(&full["energy_mj"]) / number(&policy["energy_mj"])),
            ];
            for (key, value) in expected {
                assert!((number(&gain[key]) / value - 1.0).abs() < 1e-9, "{part} {key} in {row}");
            }
        }
        if evaluated {
            let share = |key: &str| number(&row["srp"][key]);
            assert!((0.001..0.5).contains(&share("similarity_share")), "{row}");
            assert!((0.001..0.5).contains(&share("interpolation_share")), "{row}");
        }
    }
    check_study(&study(a.path()));
}

/// Every part of the study is there and agrees with itself.
fn check_study(study: &Study) {
    let full: Vec<_> = study.points.iter().filter(|p| p.kind == "full").collect();
    assert_eq!(full.len(), MODES.len());
    for point in &study.points {
        let gain = point.ti_gain.unwrap();
        assert!((gain.performance / gain.power / gain.perf_per_watt - 1.0).abs() < 1e-9, "{}", point.policy);
        let Some(gpu) = point.gpu else { continue };
        assert!(gpu.energy_mj > point.ti.unwrap().energy_mj, "the whole is more than a part");
        let energy: f64 = point.energy.iter().map(|c| c.mj).sum();
        assert!((energy / gpu.energy_mj - 1.0).abs() < 1e-9, "the components add up");
        for unit in &point.units {
            let all: f64 = unit.shares.iter().map(|s| s.share).sum();
            assert!((all - 1.0).abs() < 1e-9, "{}", unit.unit);
        }
    }
    let groups = study.ablations.iter().filter(|a| a.base).count();
    assert!(groups >= 9 && study.ablations.len() >= 2 * groups);
    assert!(study.ablations.iter().all(|a| a.perf_per_watt.is_some() && a.rays_full > 0));
    let track = |name: &str| study.tracks.iter().find(|t| t.policy == name).unwrap();
    let (full, policy) = (track("full"), track("multirate"));
    assert_eq!(full.frames.len(), policy.frames.len());
    assert!(full.flicker == Some(0.0) && full.psnr_db.is_none() && policy.flicker.unwrap() > 0.0);
    assert!(policy.frames.iter().any(|f| f.energy_mj.is_some()) && policy.frames[0].frame == 1);
    assert!(study.maps.iter().any(|m| m.policy == "multirate" && m.rate.is_some() && m.frame == 1));
    assert!(study.config.iter().any(|v| v.key == "ti.clock_mhz") && study.policies[0].name == "full");
}

/// A trace or a result in the cache that is not the one wanted, is damaged or was cut short is made again; the others stay.
#[test]
fn the_cache_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let (cache, out) = (folder.path().join("cache"), folder.path().join("out"));
    let run = || paper(folder.path(), "--size 64x32 --scene cornell --machine none").out;
    let expected = run();
    let (whole, written) = (bytes(&cache), bytes(&out));
    let results: Vec<&PathBuf> = whole.keys().filter(|f| f.starts_with("results")).collect();
    assert!(results.len() > 10, "{results:?}");

    // Damaged anywhere, or cut short.
    for (i, result) in results.iter().enumerate() {
        let mut bytes = whole[*result].clone();
        let at = i * bytes.len() / results.len();
        bytes[at] ^= 1;
        if i % 3 == 0 {
            bytes.truncate(at);
        }
        fs::write(cache.join(result), bytes).unwrap();
    }
    assert_eq!(run(), expected);
    assert!(bytes(&cache) == whole && bytes(&out) == written, "made again as they were");

    // Traces: another one under this name, one without an end, a damaged one, and what a killed run left.
    let trace = |mode: &str| cache.join(format!("cornell-64x32-{mode}.rtrace"));
    let partial = cache.join("cornell-64x32-2x2.rtrace.partial");
    let whole_capture = whole[Path::new("cornell-64x32-2x2.rtrace")].clone();
    let spoil: [&dyn Fn(); 4] = [
        &|| drop(capture("cornell", "--size 64x32 --depth 1 --force", &trace("2x2"))),
        &|| fs::write(trace("2x2"), &whole_capture[..whole_capture.len() / 2]).unwrap(),
        &|| {
            let mut bytes = whole_capture.clone();
            bytes[whole_capture.len() / 2] ^= 1;
            fs::write(trace("2x2"), bytes).unwrap();
        },
        &|| {
            fs::remove_file(trace("2x2")).unwrap();
            fs::write(&partial, &whole_capture[..whole_capture.len() / 2]).unwrap();
        },
    ];
    let other = stamps(&cache)[Path::new("cornell-64x32-1x1.rtrace")];
    for (i, spoil) in spoil.iter().enumerate() {
        spoil();
        fs::remove_dir_all(cache.join("results")).unwrap();
        assert_eq!(run(), expected, "{i}");
        assert!(bytes(&cache) == whole && bytes(&out) == written, "{i}: made again as they were");
    }
    assert_eq!(stamps(&cache)[Path::new("cornell-64x32-1x1.rtrace")], other, "the other trace was left alone");
}

/// Killed or interrupted at any point, it goes on and comes to the same.
#[cfg(unix)]
#[test]
fn a_killed_run_goes_on() {
    use std::process::Command;
    use std::time::{Duration, Instant};

    let (calm, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let line = "--size 64x32 --scene cornell --threads 1";
    let expected = paper(calm.path(), line).out;
    let results = |folder: &Path| fs::read_dir(folder.join("cache/results")).map_or(0, Iterator::count);
    let all = results(calm.path());
    for (part, signal) in [(1, "KILL"), (all / 3, "INT"), (all / 2, "KILL")] {
        let mut child = crate::common::command(&args(folder.path(), line)).spawn().unwrap();
        let start = Instant::now();
        while results(folder.path()) < part && child.try_wait().unwrap().is_none() {
            assert!(start.elapsed() < Duration::from_secs(60), "it hangs");
            std::thread::sleep(Duration::from_millis(1));
        }
        Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status().unwrap();
        let ended = child.wait_with_output().unwrap();
        assert!(!ended.status.success(), "it was hit in the middle");
        if signal == "INT" {
            assert_eq!(ended.status.code(), Some(75), "{}", String::from_utf8_lossy(&ended.stderr));
        }
    }
    let kept = stamps(&folder.path().join("cache/results"));
    assert!((all / 2..all).contains(&kept.len()), "{} of {all}", kept.len());
    let tables =
        |text: String| text.lines().filter(|l| !l.starts_with("the page")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(tables(paper(folder.path(), line).out), tables(expected));
    // A file that was being written when the run was killed is hidden, and nobody's; so is the lock.
    let written = |folder: &Path| {
        let mut all = bytes(&folder.join("out"));
        all.retain(|name, _| !name.file_name().unwrap().to_string_lossy().starts_with('.'));
        all
    };
    assert!(written(folder.path()) == written(calm.path()));
    let now = stamps(&folder.path().join("cache/results"));
    let whole = |name: &PathBuf| {
        name.extension().is_some_and(|e| ["seg", "details", "capture"].iter().any(|ending| e == *ending))
    };
    assert!(kept.keys().any(whole));
    assert!(kept.iter().filter(|(name, _)| whole(name)).all(|(name, stamp)| now[name] == *stamp), "done twice");
}

/// The numbers of the line that a run ends with.
fn counts(ran: &Ran) -> Vec<usize> {
    let line = ran.err.lines().find(|line| line.contains(" points: ")).unwrap_or_else(|| panic!("{}", ran.err));
    line.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect()
}

/// Runs a sweep over the large capture of a run, on the whole machine and on its T&I units alone.
fn sweep(run: &Path, place: &Path, name: &str, reuse: &[&Path]) -> Ran {
    let (plan, trace) = (place.join(format!("{name}.toml")), run.join("cache/teapot-32x16-2x2.rtrace"));
    let text = format!(
        "name = \"same\"\ntraces = [{trace:?}]\nmachines = [\"sgrt-ti2\"]\npolicies = [\"full\", \"paper-ss\", \"quality\"]\n\
         [[axis]]\nname = \"ideal\"\nkey = \"srp.ideal\"\nvalues = [false, true]\n"
    );
    fs::write(&plan, text).unwrap();
    let mut args: Vec<OsString> = vec!["sweep".into(), plan.into(), "--quiet".into()];
    args.extend(["-o".into(), place.join(format!("{name}.sweep")).into_os_string()]);
    reuse.iter().for_each(|folder| args.extend(["--reuse".into(), folder.as_os_str().to_owned()]));
    crate::common::run(&args).expect(0)
}

/// A point has one result, whoever computes it.
#[test]
fn a_run_finds_what_a_sweep_has_computed_and_the_other_way_round() {
    let [calm, folder, place] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let line = "--size 32x16 --scene teapot --detail full";
    let plain = paper(calm.path(), line);
    let [points, computed, kept, reused, shown] = counts(&plain)[..] else { panic!("{}", plain.err) };
    assert!(points == computed && (kept, reused, shown) == (0, 0, 0), "{}", plain.err);
    sweep(calm.path(), place.path(), "first", &[]).says(&["6 points, 0 skipped, 0 reused, 6 computed"]);

    // Of the six `quality` on the whole machine is in no table of the experiment.
    let first = place.path().join("first.sweep");
    let ran = paper(folder.path(), &format!("{line} --reuse {}", first.display()));
    let [_, now, kept, reused, shown] = counts(&ran)[..] else { panic!("{}", ran.err) };
    assert_eq!((now, kept, reused), (computed - 5, 0, 5), "{}", ran.err);
    assert_eq!(shown, 1, "the pictures of paper-ss are in no row");
    let file = |folder: &Path, name: &str| fs::read(folder.join("out").join(name)).unwrap();
    for name in ["study.json", "paper.json", "report.html", "teapot-2x2/paper-ss-result.png"] {
        assert!(file(calm.path(), name) == file(folder.path(), name), "{name}");
    }
    // What was taken is kept.
    assert_eq!(counts(&paper(folder.path(), line))[1..], [0, points, 0, 0]);

    let cache = calm.path().join("cache");
    let taken = sweep(calm.path(), place.path(), "second", &[&cache]);
    taken.says(&["6 points, 0 skipped, 5 reused, 1 computed"]);
    let table = |name: &str| fs::read(place.path().join(name).join("results.parquet")).unwrap();
    assert!(table("first.sweep") == table("second.sweep"), "the same table");
    let nowhere = place.path().join("nowhere");
    let wrong = args(folder.path(), &format!("{line} --reuse {}", nowhere.display()));
    crate::common::run(&wrong).expect(2).says(&["nowhere", "is this the folder of a sweep?"]);
}
