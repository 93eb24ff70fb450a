//! The exit codes that `rayreel --help` states, command by command: 0, 1, 2, 3, 65 (75 is in `kill`).

use std::ffi::OsString;
use std::fs;
use std::io::Read;
use std::path::Path;

use crate::common::{capture, command, run};
use crate::rayreel;

/// Runs `line`, split at blanks, `{}` being `folder`; demands the code and, for errors, a message that names `word`.
#[track_caller]
fn expect(folder: &Path, line: &str, code: i32, word: &str) {
    let args: Vec<OsString> =
        line.split_whitespace().map(|a| a.replace("{}", folder.to_str().unwrap()).into()).collect();
    let ran = run(&args).expect(code);
    assert!(format!("{}{}", ran.out, ran.err).contains(word), "`{line}` does not say {word:?}:\n{}", ran.err);
    if code >= 2 {
        assert_eq!(ran.out, "", "`{line}`: errors go to stderr");
        assert!(!ran.err.trim().is_empty() && !ran.err.contains("panicked"), "`{line}`: {}", ran.err);
    }
}

#[test]
fn help_states_the_codes() {
    let folder = tempfile::tempdir().unwrap();
    expect(folder.path(), "--version", 0, "rayreel 0.");
    let help = rayreel!["--help"].expect(0).out;
    let flat = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flat.contains("0 done, 1 the result says no"), "{flat}");
    for code in ["2 wrong usage", "3 incomplete", "65 bad input data", "75 interrupted"] {
        assert!(flat.contains(code), "{code}");
    }
}

#[test]
fn wrong_usage_is_2() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    capture("cornell", "--size 16x16 --samples 1x1", &folder.join("a.rtrace"));
    fs::create_dir(folder.join("some.sweep")).unwrap();
    fs::write(folder.join("some.sweep/plan.json"), "{}").unwrap();
    fs::write(folder.join("odd.toml"), "extends = \"multirat\"").unwrap();
    fs::write(folder.join("far.toml"), "traces = [\"s3://b/*.rtrace\"]\npolicies = [\"full\"]\n").unwrap();
    fs::write(folder.join("single.toml"), "traces = [\"a.rtrace\"]\n[axis]\nname = \"l1\"\n").unwrap();
    fs::write(folder.join("misspelt.toml"), "trace = [\"a.rtrace\"]").unwrap();
    for (line, word) in [
        ("", "Usage"),
        ("captur cornell", "capture"),
        ("capture cornell", "--output"),
        ("capture cornell -o {}/x --size 0x5", "1024x512"),
        ("capture cornell -o {}/x --size 64", "1024x512"),
        ("capture cornell -o {}/x --samples 9x9", "from 1x1 to 8x8"),
        ("capture cornell -o {}/x --frames 5..5", "A..B"),
        ("capture cornell -o {}/x --frames 9", "camera path"),
        ("capture cornell -o {}/x --depth 15", "14"),
        ("capture cornell -o {}/x --tile 0", "1024"),
        ("capture cornell -o {}/x --level 23", "22"),
        ("capture cornell -o {}/a.rtrace", "already exists"),
        ("capture cornell -o {}/no/folder/x", "cannot create"),
        ("render cornell -o {}/x.jpg", ".png or .exr"),
        ("render cornell -o {}/x.png --frame 7", "camera path"),
        ("replay {}/a.rtrace --policy nonsense", "nonsense"),
        ("replay {}/a.rtrace --frob", "--frob"),
        ("replay {}/a.rtrace --machine sgrt-ti3", "did you mean sgrt-ti2"),
        ("replay {}/a.rtrace --machine raycore", "no kernel similarity"),
        ("replay {}/a.rtrace --machine none --set ti.trv=2", "none"),
        ("replay {}/a.rtrace --machine none --timeline {}/x", "none"),
        ("replay {}/a.rtrace --machine none --warm", "--warm is for"),
        ("replay {}/a.rtrace --set gpu.warm_caches=maybe", "gpu.warm_caches"),
        ("paper --machine none --warm", "--warm is for"),
        (
            "paper --scene cornell --machine raycore --cache {}/cache --out {}/out",
            "no kernel similarity and interpolate",
        ),
        ("render cornell -o {}/x.png --frame -1", "give the number of a frame, below 4294967295"),
        ("trim {}/a.rtrace -o {}/x --frames -1", "A..B"),
        ("compare {}/a.rtrace {}/a.rtrace --top -1", "a whole number from 0 on"),
        ("compare {}/a.rtrace {}/a.rtrace", "a.rtrace: it is a trace, and holds no results"),
        ("report {}/a.rtrace", "a.rtrace: it is a trace, and holds no results"),
        ("replay {}/a.rtrace --set ti.trvs=2", "did you mean ti.trv"),
        ("replay {}/a.rtrace --set dram.channels=0", "dram.channels"),
        ("replay {}/a.rtrace --frames 0..2", "frame 1"),
        ("replay {}/a.rtrace --frames 2..2", "A..B"),
        (
            "replay {}/a.rtrace --policy {}/odd.toml",
            "odd.toml: extends: no policy preset \"multirat\"; did you mean multirate? (or",
        ),
        ("sweep {}/some.sweep", "is the folder of a sweep and not a plan file: `rayreel sweep run "),
        ("sweep {}", "is a folder; name a plan file (.toml)"),
        ("sweep plan {}/odd.toml", "unknown field `extends`"),
        ("sweep plan {}/far.toml", "far.toml:1:11: traces \"s3://b/*.rtrace\": patterns are for files on this machine"),
        ("sweep plan {}/single.toml", "single.toml:2:1: one table stands where a list of tables is needed"),
        ("sweep plan {}/misspelt.toml", "misspelt.toml:1:1: unknown field `trace`; did you mean `traces`?"),
        ("presets show sgrt-ti3", "did you mean sgrt-ti2"),
        ("presets show adaptve", "did you mean adaptive"),
        ("presets show sgrt-ti2 --set ti.trv=99", "from 1 to 16"),
        ("info {}/a.rtrace --threads x", "--threads"),
        ("info {}/a.rtrace --memory 1GiB", "a whole number of MiB of 1 or more"),
        ("replay {}/a.rtrace --policy sgrt-ti1", "sgrt-ti1 is a machine and no policy; give it to --machine"),
        ("replay {}/a.rtrace --machine multirate", "multirate is a policy and no machine; give it to --policy"),
        ("replay {}/a.rtrace --set l1.size=8KiB", "--set l1.size=8KiB: a machine has ti.trv_l1.size, ti.ist_l1.size"),
        ("replay chess", "chess is a scene and no trace; `rayreel capture chess -o chess.rtrace` records it"),
        ("render {}/a.rtrace -o {}/x.png", "it is a trace already: `rayreel replay a.rtrace --machine none"),
        ("report {} --animate result -o {}/x.gif", "--animate is for the folder of a replay"),
        ("compare {}/a.rtrace {}/a.rtrace --tolerance 5%%", "such as 1% or 0.01"),
    ] {
        expect(folder, line, 2, word);
    }
    assert!(!folder.join("x").exists() && !folder.join("x.partial").exists(), "nothing is left behind");
    assert!(!folder.join("cache").exists() && !folder.join("out").exists(), "paper begins with what it can know");
}

/// As a trace that is not there: the name is wrong, not what stands in the file.
#[test]
fn a_missing_scene_is_2() {
    let folder = tempfile::tempdir().unwrap();
    for (line, word) in [
        ("capture cornel -o {}/x", "cornell"),
        ("capture {}/missing.obj -o {}/x", "missing.obj"),
        ("capture {}/missing.toml -o {}/x", "missing.toml"),
        ("capture {} -o {}/x", "folder"),
        ("render teapott -o {}/x.png", "teapot"),
        ("scenes show chesss", "chess"),
        ("paper --scene nosuch --cache {}/c --out {}/o", "nosuch"),
    ] {
        expect(folder.path(), line, 2, word);
    }
}

#[test]
fn a_missing_trace_is_2() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["info", "verify", "digest", "replay"] {
        expect(folder.path(), &format!("{command} {{}}/missing.rtrace"), 2, "missing.rtrace");
    }
    expect(folder.path(), "diff {}/missing.rtrace {}/missing.rtrace", 2, "missing.rtrace");
    expect(folder.path(), "repair {}/missing.rtrace -o {}/x", 2, "missing.rtrace");
}

#[test]
fn bad_data_is_65() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("text.rtrace"), "this is a letter, and not a trace at all; it is long enough for a header")
        .unwrap();
    fs::write(folder.join("empty.obj"), "# nothing\n").unwrap();
    fs::write(folder.join("nan.obj"), "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(folder.join("range.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    fs::write(folder.join("typo.toml"), "model = \"empty.obj\"\nmodle = 3\n").unwrap();
    for command in ["info", "verify", "digest", "replay"] {
        expect(folder, &format!("{command} {{}}/text.rtrace"), 65, "not a trace");
    }
    expect(folder, "diff {}/text.rtrace {}/text.rtrace", 65, "not a trace");
    for (scene, word) in
        [("empty.obj", "empty"), ("nan.obj", "finite"), ("range.obj", "out of range"), ("typo.toml", "modle")]
    {
        expect(folder, &format!("capture {{}}/{scene} -o {{}}/x"), 65, word);
        expect(folder, &format!("render {{}}/{scene} -o {{}}/x.png"), 65, word);
        expect(folder, &format!("scenes show {{}}/{scene}"), 65, word);
    }
    assert!(!folder.join("x").exists() && !folder.join("x.partial").exists());
}

#[test]
fn what_is_done_is_0() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (line, word) in [
        ("capture cornell --size 20x20 -o {}/a.rtrace", "bytes/ray"),
        ("capture cornell --size 20x20 -o {}/a.rtrace --force", "bytes/ray"),
        ("render cornell --size 20x20 -o {}/a.PNG", ""),
        ("render cornell --size 20x20 -o {}/a.exr", ""),
        ("scenes list", "teapot"),
        ("scenes list --json", "\"triangles\""),
        ("scenes show cornell", "bounds"),
        ("scenes show chess --json", "\"content_hash\""),
        ("info {}/a.rtrace", "rays"),
        ("verify {}/a.rtrace", "verified"),
        ("digest {}/a.rtrace", "total"),
        ("diff {}/a.rtrace {}/a.rtrace", "equal"),
        ("repair {}/a.rtrace -o {}/b.rtrace", "complete"),
        ("replay {}/a.rtrace", "PSNR"),
        ("replay {}/a.rtrace --machine none", "PSNR"),
        ("replay {}/a.rtrace --machine raycore --policy full --timeline {}/t.json", "Mrays/s"),
    ] {
        expect(folder, line, 0, word);
    }
}

#[test]
fn built_in_scenes_have_their_triangles() {
    let list = rayreel!["scenes", "list", "--json"].expect(0).json();
    let triangles = |name: &str| {
        let scene = list.as_array().unwrap().iter().find(|s| s["name"] == name).unwrap();
        scene["triangles"].as_f64().unwrap()
    };
    assert!((triangles("teapot") / 15_000.0 - 1.0).abs() <= 0.02, "{}", triangles("teapot"));
    assert!((triangles("chess") / 42_000.0 - 1.0).abs() <= 0.02, "{}", triangles("chess"));
    assert_eq!(rayreel!["scenes", "show", "teapot", "--json"].expect(0).json()["triangles"], triangles("teapot"));
}

/// `rayreel scenes list | head -0` is no error.
#[test]
fn a_closed_pipe_is_no_error() {
    let mut child = command(&["scenes".into(), "list".into()]).spawn().unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!((child.wait().unwrap().code(), said.as_str()), (Some(0), ""));
}
