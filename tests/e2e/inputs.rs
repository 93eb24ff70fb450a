//! What a command reads is still there afterwards, whatever file it is told to write: policies, machines, scenes with all that they are
//! made of, traces, and what pages are made of.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::Path;

use crate::common::{capture, run};
use crate::made_up;
use crate::rayreel;

/// The files of a folder with their bytes.
fn bytes(folder: &Path) -> BTreeMap<OsString, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let files = entries.filter(|entry| entry.path().is_file());
    files.map(|entry| (entry.file_name(), fs::read(entry.path()).unwrap())).collect()
}

/// Every line, `{}` being the folder, is refused for what it would write over, and nothing in the folder changes.
#[track_caller]
fn refused(folder: &Path, lines: &[&str]) {
    let before = bytes(folder);
    for line in lines {
        let args: Vec<OsString> =
            line.split_whitespace().map(|word| word.replace("{}", folder.to_str().unwrap()).into()).collect();
        run(&args).expect(2).says(&["is what is read; name another file to write"]);
        assert!(bytes(folder) == before, "`{line}` changed something");
    }
}

#[test]
fn policies_and_machines_stay() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    capture("cornell", "--size 32x16 --samples 1x1", &folder.join("a.rtrace"));
    fs::write(folder.join("p.toml"), "extends = \"full\"\n").unwrap();
    fs::write(folder.join("m.toml"), "extends = \"sgrt-ti2\"\n").unwrap();
    let export = "export --quiet {}/a.rtrace --what tiles --format csv --policy {}/p.toml --machine {}/m.toml -o {}/";
    refused(folder, &[&format!("{export}p.toml"), &format!("{export}m.toml")]);
}

#[test]
fn traces_stay() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    capture("chess", "--size 32x16 --samples 1x1 --frames 0", &folder.join("a"));
    capture("chess", "--size 32x16 --samples 1x1 --frames 1", &folder.join("b"));
    refused(
        folder,
        &[
            "trim {}/a --columns hits --force -o {}/a",
            "recompress {}/a --codec plain --force -o {}/a",
            "merge {}/a {}/b --force -o {}/b",
        ],
    );
}

/// A triangle with a picture on it.
fn model(folder: &Path) {
    let obj = "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    fs::write(folder.join("m.obj"), obj).unwrap();
    fs::write(folder.join("m.mtl"), "newmtl a\nKd 1 1 1\nmap_Kd result.png\n").unwrap();
    made_up::pictures(folder);
    fs::write(
        folder.join("path.csv"),
        "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,up_x,up_y,up_z,vfov_deg\n0,0,0,5,0,0,0,0,1,0,40\n",
    )
    .unwrap();
    fs::write(folder.join("s.toml"), "model = \"m.obj\"\n[camera]\npath = \"path.csv\"\n").unwrap();
}

#[test]
fn what_a_scene_is_made_of_stays() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    model(folder);
    let of_model =
        ["m.obj", "m.mtl", "result.png"].map(|file| format!("capture {{}}/m.obj --size 16x16 --force -o {{}}/{file}"));
    let of_scene = ["s.toml", "m.obj", "m.mtl", "result.png", "path.csv"]
        .map(|file| format!("capture {{}}/s.toml --size 16x16 --force -o {{}}/{file}"));
    let mut lines: Vec<&str> = of_model.iter().chain(&of_scene).map(String::as_str).collect();
    lines.push("render {}/s.toml --size 16x16 -o {}/result.png");
    refused(folder, &lines);
    // A built-in scene is made of no file, whatever lies there under its name.
    let out = folder.join("cornell");
    for _ in 0..2 {
        capture("cornell", "--size 16x16 --samples 1x1 --force", &out);
    }
}

#[test]
fn what_a_gltf_names_stays() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0_f32]];
    fs::write(folder.join("m.bin"), corners.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<_>>())
        .unwrap();
    let text = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"uri":"m.bin","byteLength":36}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]}"#;
    fs::write(folder.join("m.gltf"), text).unwrap();
    let capture = "capture {}/m.gltf --size 16x16 --force -o {}/";
    refused(folder, &[&format!("{capture}m.gltf"), &format!("{capture}m.bin")]);
}

#[test]
fn what_a_page_of_a_study_is_made_of_stays() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    made_up::write(folder);
    fs::write(folder.join("paper.json"), "[]").unwrap();
    refused(folder, &["report {} -o {}/study.json", "report {} -o {}/paper.json", "report {} -o {}/error.png"]);
    // A page takes the place of a page.
    for _ in 0..2 {
        rayreel!["report", folder].expect(0);
    }
}

#[test]
fn what_a_page_of_a_replay_is_made_of_stays() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (trace, run) = (folder.join("a"), folder.join("run"));
    capture("chess", "--size 32x16 --samples 1x1 --frames 0..2", &trace);
    rayreel!["replay", "--quiet", &trace, "--machine", "none", "--out", &run].expect(0);
    refused(
        &run,
        &[
            "report {} -o {}/stats.json",
            "report {} -o {}/frame_0001_flip.png",
            "report {} --animate result -o {}/stats.json",
            "report {} --animate result -o {}/frame_0000_result.png",
            "report {} --animate result -o {}/frame_0000_result.exr",
        ],
    );
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("stats.json", run.join("link.html")).unwrap();
        refused(&run, &["report {} -o {}/link.html"]);
    }
    // An animation may be called a picture, and be made again.
    for _ in 0..2 {
        rayreel!["report", &run, "--animate", "result", "-o", &run.join("film.png")].expect(0);
    }
}
