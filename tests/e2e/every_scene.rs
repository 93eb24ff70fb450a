//! Every scene, built-in and shared: it captures, verifies from the trace alone, and its `full` replay is the render, bit for
//! bit. Image sizes are multiples of neither tile nor block.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::scenes::{SceneFile, all};
use crate::common::{capture, replay};
use crate::rayreel;

/// Captures, verifies and replays a scene, and compares with its render.
fn check(folder: &Path, scene: &SceneFile, grid: &str, tile: u32) {
    let SceneFile { name, spec, frame } = scene;
    let what = format!("{name} {grid}");
    let file = folder.join(format!("{name}.rtrace"));
    let captured = capture(spec, &format!("{grid} --tile {tile} --frames {frame} --force"), &file);
    let verified = rayreel!["verify", "--quiet", "--json", &file].expect(0).json();
    assert_eq!(verified["rays"], captured["rays"], "{what}: every ray is traversed again");
    assert_eq!(verified["steps"], captured["steps"], "{what}");
    assert_eq!(verified["first_mismatch"], Value::Null, "{what}");

    let out = folder.join("out");
    let report = replay(&file, &format!("--policy full --out {}", out.display())).expect(0).json();
    let (exr, png) = (folder.join("render.exr"), folder.join("render.png"));
    let frame = frame.to_string();
    render(spec, grid, &frame, &exr);
    same(&out.join("result.exr"), &exr, &what);
    // The sRGB picture is made from the linear one: once is enough where a scene takes seconds to load.
    if captured["triangles"].as_u64() < Some(100_000) {
        render(spec, grid, &frame, &png);
        same(&out.join("result.png"), &png, &what);
    }
    same(&out.join("reference.png"), &out.join("result.png"), &what);
    assert_eq!((&report["identical"], &report["psnr_db"]), (&Value::Bool(true), &Value::Null), "{what}");
    assert_eq!(report["rays_full"], captured["rays"], "{what}");
    assert_eq!(report["rays_traced"], captured["rays"], "{what}");
    assert_eq!(report["samples_traced"], captured["samples"], "{what}");
}

fn render(spec: &str, grid: &str, frame: &str, file: &Path) {
    let grid: Vec<&str> = grid.split_whitespace().collect();
    rayreel!["render", spec, "-o", file, "--frame", frame, grid[0], grid[1], grid[2], grid[3]].expect(0);
}

/// The same file to the byte: our writers give the same bytes for the same picture. EXR files also say what they are of; their
/// pixels are the same to the bit.
#[track_caller]
fn same(a: &Path, b: &Path, what: &str) {
    let (a_name, b_name) = (a.display(), b.display());
    if a.extension().is_none_or(|e| e != "exr") {
        assert!(fs::read(a).unwrap() == fs::read(b).unwrap(), "{what}: {a_name} and {b_name} are other pictures");
        return;
    }
    let [x, y] = [a, b].map(|path| rayreel_replay::image::files::read_exr(path).unwrap());
    assert_eq!((x.width, x.height), (y.width, y.height), "{what}: {a_name} and {b_name}");
    let bits = |pixel: &[f32; 3]| pixel.map(f32::to_bits);
    let wrong = x.pixels.iter().zip(&y.pixels).position(|(x, y)| bits(x) != bits(y));
    assert_eq!(wrong, None, "{what}: {a_name} and {b_name} differ, first in this pixel");
}

#[test]
fn full_replay_is_the_render_2x2() {
    let folder = tempfile::tempdir().unwrap();
    for scene in all(folder.path()) {
        check(folder.path(), &scene, "--size 53x29 --samples 2x2", 24);
    }
}

#[test]
fn full_replay_is_the_render_1x1() {
    let folder = tempfile::tempdir().unwrap();
    for scene in all(folder.path()).into_iter().filter(|s| !s.name.starts_with("provence")) {
        check(folder.path(), &scene, "--size 71x37 --samples 1x1", 32);
    }
}

/// More samples than the paper's four: the same holds, blocks of 3 fit the tiles that are taken for them, and every machine's work is
/// the policy's.
#[test]
fn three_and_four_samples_across_a_pixel() {
    let folder = tempfile::tempdir().unwrap();
    for (samples, tile, policy) in
        [("3x3", 48, "adaptive --set block=3"), ("4x4", 32, "multirate"), ("8x8", 32, "adaptive-8")]
    {
        let (file, out) = (folder.path().join("a.rtrace"), folder.path().join("out"));
        let grid = format!("--size 31x18 --samples {samples}");
        capture("cornell", &format!("{grid} --force"), &file);
        assert_eq!(rayreel!["info", "--json", &file].expect(0).json()["tile"], tile, "{samples}");
        let full = replay(&file, &format!("--policy full --machine none --out {}", out.display())).expect(0).json();
        let exr = folder.path().join("render.exr");
        render("cornell", &grid, "0", &exr);
        same(&out.join("result.exr"), &exr, samples);
        let adaptive = replay(&file, &format!("--machine sgrt-ti2 --policy {policy}")).expect(0).json();
        assert_eq!(adaptive["rays_full"], full["rays_full"], "{samples}");
        assert_eq!(adaptive["rays_machine"], adaptive["rays_traced"], "{samples}");
        assert!(adaptive["rays_traced"].as_u64() < adaptive["rays_full"].as_u64(), "{samples}");
    }
}

/// The replay is the render at other depths too, and with a tile larger than the picture.
#[test]
fn full_replay_is_the_render_at_any_depth() {
    let folder = tempfile::tempdir().unwrap();
    for depth in [0, 1, 9] {
        let file = folder.path().join("a.rtrace");
        let (out, exr) = (folder.path().join("out"), folder.path().join("a.exr"));
        let depth = depth.to_string();
        let grid = format!("--size 40x30 --depth {depth} --tile 256 --force");
        capture("cornell", &grid, &file);
        rayreel!["verify", &file].expect(0);
        replay(&file, &format!("--policy full --out {}", out.display())).expect(0);
        rayreel!["render", "cornell", "-o", &exr, "--size", "40x30", "--depth", &depth].expect(0);
        same(&out.join("result.exr"), &exr, &format!("depth {depth}"));
    }
}

/// The pictures are of something: no frame is black, flat, or the same as that of another scene.
#[test]
fn pictures_show_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen: Vec<Vec<u8>> = Vec::new();
    for scene in all(folder.path()).into_iter().filter(|s| s.name != "provence_air") {
        let png = folder.path().join("a.png");
        render(&scene.spec, "--size 48x24 --samples 1x1", &scene.frame.to_string(), &png);
        let picture = image::open(&png).unwrap().into_luma8().into_raw();
        let mean = picture.iter().map(|&v| f64::from(v)).sum::<f64>() / picture.len() as f64;
        let spread = picture.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / picture.len() as f64;
        assert!((20.0..240.0).contains(&mean), "{}: mean {mean}", scene.name);
        assert!(spread.sqrt() > 8.0, "{}: deviation {}", scene.name, spread.sqrt());
        assert!(!seen.contains(&picture), "{}: the picture of another scene", scene.name);
        seen.push(picture);
    }
}
