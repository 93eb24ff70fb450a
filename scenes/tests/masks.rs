//! Cut-outs of MTL: which channel of which picture.

mod common;

use common::{TRIANGLE, folder, load_in, warnings};
use rayreel_scenes::Scene;

/// A model with this material beside three pictures of two texels: `opaque.png` dark and light, `holed.png` with a hole,
/// `black.png`.
fn load(mtl: &str) -> Scene {
    let faces = TRIANGLE.replace("f 1 2 3", "f 1/1 2/1 3/1");
    let files = folder(&[
        ("a.obj", &format!("mtllib a.mtl\nusemtl m\nvt 0 0\n{faces}")),
        ("a.mtl", &format!("newmtl m\n{mtl}newmtl other\nmap_d opaque.png\n")),
    ]);
    for (name, texels) in [
        ("opaque.png", [[10, 10, 10, 255], [255, 255, 255, 255]]),
        ("holed.png", [[255, 255, 255, 0], [10, 10, 10, 255]]),
        ("black.png", [[0, 0, 0, 255]; 2]),
    ] {
        let picture = image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba(texels[x as usize]));
        picture.save(files.path().join(name)).expect("saves");
    }
    std::fs::create_dir(files.path().join("sub")).expect("creates");
    load_in(&files, "a.obj").unwrap_or_else(|e| panic!("{e}"))
}

/// The alpha of the cut-out, if there is one.
fn alpha(mtl: &str) -> Option<Vec<u8>> {
    let scene = load(mtl);
    let map = scene.materials[0].alpha_map?;
    Some(scene.textures[map].texels.iter().map(|texel| texel[3]).collect())
}

/// The dark parts of an opaque picture that was named twice vanished.
#[test]
fn the_picture_of_the_colour_is_cut_out_by_its_alpha_alone() {
    for mtl in [
        "map_Kd opaque.png\nmap_d opaque.png\n",
        "map_d opaque.png\nmap_Kd opaque.png\n",
        "map_d -imfchan m opaque.png\nmap_Kd opaque.png\n",
        "map_Kd opaque.png\nmap_d sub/../opaque.png\n",
    ] {
        assert_eq!(alpha(mtl), None, "{mtl}");
    }
    assert_eq!(alpha("map_Kd holed.png\nmap_d holed.png\n"), Some(vec![0, 255]));
    // Asked for, and of another picture, the luminance of an opaque one counts.
    assert_eq!(alpha("map_Kd opaque.png\nmap_d -imfchan l opaque.png\n"), Some(vec![10, 255]));
    assert_eq!(alpha("map_Kd holed.png\nmap_d opaque.png\n"), Some(vec![10, 255]));
    assert_eq!(alpha("map_Kd opaque.png\nmap_d holed.png\n"), Some(vec![0, 255]));
    // What one material makes of a picture is nothing to another.
    let scene = load("map_Kd opaque.png\nmap_d opaque.png\n");
    assert_eq!((scene.materials[0].alpha_map, scene.materials[1].alpha_map), (None, Some(1)));
}

#[test]
fn a_mask_that_leaves_nothing_is_told() {
    let told = |mtl: &str| warnings(&load(mtl));
    let words = "a.mtl:1: material `m`: its texture is below the cutoff everywhere, and cuts all away";
    assert_eq!(told("map_d black.png\n"), [(1, words.to_owned())]);
    assert_eq!(told("map_d opaque.png\n"), []);
}

#[test]
fn other_channels_of_a_mask_are_told() {
    let told = |mtl: &str| warnings(&load(mtl)).into_iter().map(|(_, message)| message).collect::<Vec<_>>();
    let words = "a.mtl:2: texture option `-imfchan r` is not supported and was ignored";
    assert_eq!(told("map_d -imfchan r opaque.png\n"), [words]);
    for mtl in ["map_d -imfchan l opaque.png\n", "map_d -imfchan m opaque.png\n", "map_Kd -imfchan r opaque.png\n"] {
        assert!(told(mtl).is_empty(), "{mtl}");
    }
}
