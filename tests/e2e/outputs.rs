//! What is written never takes the place of what is read, of a device or of a link; what is compared is there.

use std::fs;

use crate::common::capture;
use crate::rayreel;

#[test]
fn inputs_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("a.rtrace");
    capture("cornell", "--size 32x16 --samples 1x1", &trace);
    let bytes = fs::read(&trace).unwrap();
    let ran = rayreel!["export", &trace, "--what", "nodes", "--format", "csv", "-o", &trace].expect(2);
    assert!(ran.err.contains("is what is read; name another file to write"), "{ran:?}");
    assert_eq!(fs::read(&trace).unwrap(), bytes);
}

/// What takes long to make is refused before it is made, and the file that is there stays.
#[test]
fn places_are_looked_at_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("cornell", "--size 32x16 --samples 1x1", &at("a.rtrace"));
    fs::write(at("p.toml"), "extends = \"full\"\n").unwrap();
    fs::create_dir(at("out")).unwrap();
    let bytes = |name: &str| fs::read(at(name)).unwrap();
    let (trace, policy) = (bytes("a.rtrace"), bytes("p.toml"));
    let timeline = |to: &str| {
        rayreel!["replay", &at("a.rtrace"), "--policy", &at("p.toml"), "--timeline", &at(to), "--out", &at("out")]
    };
    for (to, said) in [
        ("a.rtrace", "a.rtrace is what is read; name another file to write"),
        ("p.toml", "p.toml is what is read"),
        ("none/t.json", "none/t.json: No such file or directory"),
        (".", "is a folder; name a file to write"),
        ("out/stats.json", "out/stats.json is written by --out; name another file for --timeline"),
    ] {
        let ran = timeline(to).expect(2);
        assert!(ran.err.contains(said) && ran.out.is_empty(), "{ran:?}");
    }
    assert_eq!((bytes("a.rtrace"), bytes("p.toml")), (trace, policy));
    let ran = rayreel!["render", "cornell", "-o", &at("none/a.png")].expect(2);
    assert!(ran.err.contains("none/a.png: No such file or directory"), "{ran:?}");
    fs::copy(at("a.rtrace"), at("a.exr")).unwrap();
    let ran = rayreel!["aov", &at("a.exr"), "-o", &at("a.exr")].expect(2);
    assert!(ran.err.contains("a.exr is what is read"), "{ran:?}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "nothing is left behind");
    assert_eq!(fs::read_dir(at("out")).unwrap().count(), 0);
}

/// Only tables go to standard output: elsewhere `-` would name a file that nobody asked for.
#[test]
fn a_dash_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("a.rtrace");
    capture("cornell", "--size 32x16 --samples 1x1", &trace);
    for ran in [
        rayreel!["capture", "cornell", "-o", "-"],
        rayreel!["recompress", &trace, "-o", "-"],
        rayreel!["repair", &trace, "-o", "-"],
        rayreel!["aov", &trace, "-o", "-"],
        rayreel!["replay", &trace, "--timeline", "-"],
        rayreel!["report", folder.path(), "-o", "-"],
    ] {
        let ran = ran.expect(2);
        assert!(ran.err.contains("standard output cannot take it; name a file (./- is one called -)"), "{ran:?}");
    }
}

/// A sweep of one point, merged.
fn merged(folder: &std::path::Path) -> std::path::PathBuf {
    capture("cornell", "--size 32x16 --samples 1x1", &folder.join("a.rtrace"));
    let plan = folder.join("s.toml");
    fs::write(&plan, "traces = [\"a.rtrace\"]\nmachines = [\"none\"]\npolicies = [\"full\"]\n").unwrap();
    let sweep = folder.join("s.sweep");
    rayreel!["sweep", "--quiet", &plan, "--traces", folder, "-o", &sweep].expect(0);
    sweep
}

#[test]
fn results_and_plans_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = merged(folder.path());
    let both = folder.path().join("x.csv");
    let ran = rayreel!["sweep", "merge", &sweep, "-o", &both].expect(2);
    assert!(ran.err.contains("cannot be the Parquet file and the CSV file"), "{ran:?}");
    let ran = rayreel!["sweep", "merge", &sweep, "-o", &sweep.join("plan.json")].expect(2);
    assert!(ran.err.contains("is what is read"), "{ran:?}");
    let results = sweep.join("results.parquet");
    let ran = rayreel!["report", &results, "-o", &results].expect(2);
    assert!(ran.err.contains("is what is read"), "{ran:?}");
    let columns = sweep.join("columns/x.html");
    let ran = rayreel!["report", &sweep, "-o", &columns].expect(2);
    assert!(ran.err.contains("x.html is among the files that the sweep lives on"), "{ran:?}");
    let trace = folder.path().join("a.rtrace");
    for ran in [rayreel!["report", &sweep, "-o", &trace], rayreel!["sweep", "merge", &sweep, "--csv", &trace]] {
        assert!(ran.expect(2).err.contains("a.rtrace is a trace; name another file to write"));
    }
    let ran = rayreel!["report", &sweep, "--charts", &trace].expect(2);
    assert!(ran.err.contains("a.rtrace is a file; name a folder"), "{ran:?}");
    let ran = rayreel!["sweep", "run", &sweep, "-o", &folder.path().join("other")].expect(2);
    assert!(ran.err.contains("is the folder of a sweep already; -o is for a plan file"), "{ran:?}");
    rayreel!["sweep", "merge", &sweep].expect(0);
    rayreel!["compare", &sweep, &sweep].expect(0);
}

#[test]
fn comparing_nothing_is_no_agreement() {
    let folder = tempfile::tempdir().unwrap();
    capture("cornell", "--size 32x16 --samples 1x1", &folder.path().join("a.rtrace"));
    let (plan, sweep) = (folder.path().join("s.toml"), folder.path().join("s.sweep"));
    fs::write(&plan, "traces = [\"a.rtrace\"]\nmachines = [\"none\"]\npolicies = [\"full\"]\n").unwrap();
    rayreel!["sweep", "plan", &plan, "--traces", folder.path(), "-o", &sweep, "--no-estimate"].expect(0);
    rayreel!["sweep", "merge", &sweep, "--partial"].expect(3);
    let ran = rayreel!["compare", &sweep, &sweep].expect(65);
    assert!(ran.err.contains("holds no results"), "{ran:?}");
}

#[cfg(unix)]
#[test]
fn pipes_are_refused_and_links_followed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("cornell", "--size 32x16 --samples 1x1", &at("a.rtrace"));
    let export = |to: &str| rayreel!["export", "--quiet", &at("a.rtrace"), "--what", "nodes", "-o", &at(to)];
    assert!(std::process::Command::new("mkfifo").arg(at("pipe.csv")).status().unwrap().success());
    let ran = export("pipe.csv").expect(2);
    assert!(ran.err.contains("it is a device or a pipe, and a file cannot take its place"), "{ran:?}");
    let ran = rayreel!["trim", &at("a.rtrace"), "--columns", "hits", "-o", &at("pipe.csv"), "--force"].expect(2);
    assert!(ran.err.contains("it is a device or a pipe"), "{ran:?}");
    fs::write(at("there.csv"), "old").unwrap();
    std::os::unix::fs::symlink("there.csv", at("link.csv")).unwrap();
    export("link.csv").expect(0);
    assert!(fs::symlink_metadata(at("link.csv")).unwrap().is_symlink());
    assert!(fs::read_to_string(at("there.csv")).unwrap().lines().count() > 100, "the link names what was written");
    // To where nothing is yet, over another link; and round in a circle.
    for (name, to) in
        [("new.csv", "far.csv"), ("far.csv", "end.csv"), ("round.csv", "about.csv"), ("about.csv", "round.csv")]
    {
        std::os::unix::fs::symlink(to, at(name)).unwrap();
    }
    export("new.csv").expect(0);
    assert!(fs::read(at("end.csv")).unwrap() == fs::read(at("there.csv")).unwrap());
    assert!(["new.csv", "far.csv"].iter().all(|name| fs::symlink_metadata(at(name)).unwrap().is_symlink()));
    let ran = export("round.csv").expect(74);
    assert!(ran.err.contains("round.csv") && fs::symlink_metadata(at("round.csv")).unwrap().is_symlink(), "{ran:?}");
}

/// A trace in the folder of the pictures, under the name of one.
#[test]
fn a_folder_of_pictures_keeps_what_is_read_and_the_timeline() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("out")).unwrap();
    capture("cornell", "--size 32x16 --samples 1x1", &at("a.rtrace"));
    let bytes = fs::read(at("a.rtrace")).unwrap();
    for name in ["out/result.png", "out/stats.json", "out/frame_0000_flip.png"] {
        fs::copy(at("a.rtrace"), at(name)).unwrap();
        let ran = rayreel!["replay", &at(name), "--machine", "none", "--out", &at("out")].expect(2);
        assert!(ran.err.contains("is what is read; name another file to write"), "{ran:?}");
        assert!(fs::read(at(name)).unwrap() == bytes);
        fs::remove_file(at(name)).unwrap();
    }
    for timeline in ["out/result.png", "out/../out/stats.json"] {
        let ran = rayreel!["replay", &at("a.rtrace"), "--out", &at("out"), "--timeline", &at(timeline)].expect(2);
        assert!(ran.err.contains("is written by --out; name another file for --timeline"), "{ran:?}");
    }
    assert_eq!(fs::read_dir(at("out")).unwrap().count(), 0);
    let ran = rayreel!["capture", "cornell", "-o", &format!("{}/", at("new").display())].expect(2);
    assert!(ran.err.contains("it ends as the name of a folder does; name a file"), "{ran:?}");
    assert!(!at("new.partial").exists());
}

#[test]
fn traces_without_a_column_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("cornell", "--size 32x16 --samples 1x1", &at("all"));
    rayreel!["trim", "--quiet", &at("all"), "--columns", "hits", "-o", &at("some")].expect(0);
    rayreel!["diff", &at("some"), &at("some")].expect(0);
    let told = rayreel!["diff", &at("all"), &at("some")].expect(1).out;
    assert_eq!(told, "frame 0, tile 0, column radiance: there | missing\n");
}

/// A scene is what a capture was told that it is.
#[test]
fn a_trace_is_held_against_the_scene_as_it_was_captured() {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("a.rtrace");
    capture("cornell", "--size 32x16 --samples 1x1 --light 0,1.5,0 --fov 50", &trace);
    rayreel!["verify", "--quiet", &trace, "--scene", "cornell"].expect(1);
    rayreel!["verify", "--quiet", &trace, "--scene", "cornell", "--light", "0,1.5,0", "--fov", "50"].expect(0);
    let ran = rayreel!["verify", &trace, "--fov", "50"].expect(2);
    assert!(ran.err.contains("--fov says how the scene was captured; name it with --scene"), "{ran:?}");
}
