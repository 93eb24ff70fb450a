//! Scenes, models, pictures and camera paths. What loads is built, as a capture would.

use image::ImageFormat;
use rayreel_scenes::Scene;
use rayreel_scenes::camera::read_path;

use crate::place::{self, Place};
use crate::seeds;
use crate::target::{Target, told};

pub fn targets() -> Vec<Target> {
    let target = |name, seeds, read| Target { name, seeds, read, change: None, mend: None };
    vec![
        target("scene", || vec![seeds::SCENE.into()], |bytes| load("s.toml", "s.toml", bytes)),
        target("obj", || vec![seeds::OBJ.into()], |bytes| load("m.obj", "m.obj", bytes)),
        target("mtl", || vec![seeds::MTL.into()], |bytes| load("m.mtl", "s.toml", bytes)),
        target("gltf", || vec![seeds::GLTF.into()], |bytes| load("m.gltf", "m.gltf", bytes)),
        Target {
            name: "glb",
            seeds: || vec![glb(seeds::GLTF.as_bytes(), &[]), glb(&binary_json(), &[0; 60])],
            read: |bytes| load("m.glb", "m.glb", bytes),
            change: None,
            mend: Some(|bytes| mend_glb(bytes)),
        },
        target("texture", pictures, |bytes| load("t.png", "s.toml", bytes)),
        target(
            "camera-path",
            || vec![seeds::PATH.into()],
            |bytes| place::with(|place| told(&read_path(&place.put("path.csv", bytes)))),
        ),
    ]
}

fn pictures() -> Vec<Vec<u8>> {
    [ImageFormat::Png, ImageFormat::Jpeg].map(|format| seeds::picture(format).expect("a picture")).to_vec()
}

/// The model with its buffer outside of the text.
fn binary_json() -> Vec<u8> {
    let text = seeds::GLTF;
    let (from, to) =
        (text.find(",\"uri\"").expect("it is there"), text.find("}],\"animations\"").expect("it is there"));
    [&text[..from], &text[to..]].concat().into_bytes()
}

fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (part, kind) in [(json, b"JSON"), (binary, b"BIN\0")].into_iter().filter(|(part, _)| !part.is_empty()) {
        let padded = part.len().next_multiple_of(4);
        bytes.extend((padded as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(part);
        bytes.resize(bytes.len() + padded - part.len(), b' ');
    }
    mend_glb(&mut bytes);
    bytes
}

/// The length of the file and of its first part.
fn mend_glb(bytes: &mut [u8]) {
    let length = bytes.len() as u32;
    if let Some(field) = bytes.get_mut(8..12) {
        field.copy_from_slice(&length.to_le_bytes());
    }
    let binary = bytes.windows(4).position(|window| window == b"BIN\0");
    let end = binary.map_or(bytes.len(), |at| at.saturating_sub(4));
    if bytes.len() > 20 && end > 20 {
        bytes[12..16].copy_from_slice(&((end - 20) as u32).to_le_bytes());
    }
}

/// Loads `opened` from a folder in which everything is sound but `name`.
fn load(name: &str, opened: &str, bytes: &[u8]) -> String {
    place::with(|place| {
        complete(place, name);
        place.put(name, bytes);
        let loaded = rayreel_scenes::load(&place.path(opened).display().to_string());
        if let Ok(scene) = &loaded {
            build(scene);
        }
        told(&loaded)
    })
}

/// A file by name, and how its bytes are made.
type Sound = (&'static str, fn() -> Vec<u8>);

/// Puts what a scene needs beside `name`: what is not there yet, and what the last input replaced.
fn complete(place: &Place, name: &str) {
    let replaced = std::fs::read_to_string(place.path("replaced")).unwrap_or_default();
    let sound: [Sound; 4] = [
        ("t.png", || seeds::picture(ImageFormat::Png).expect("a picture")),
        ("m.mtl", || seeds::MTL.into()),
        ("m.obj", || seeds::OBJ.into()),
        ("s.toml", || seeds::SCENE.into()),
    ];
    for (other, bytes) in sound {
        if other != name && (other == replaced || !place.path(other).exists()) {
            place.put(other, &bytes());
        }
    }
    if replaced != name {
        place.put("replaced", name.as_bytes());
    }
}

/// The tree that a capture would trace.
fn build(scene: &Scene) {
    scene.validate().expect("a scene that loads is valid");
    if scene.mesh.triangles.len() < 20_000 {
        drop(told(&rayreel_tracer::build(scene)));
    }
}
