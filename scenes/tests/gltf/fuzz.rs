//! Cut short or with bits flipped, a `.glb` never panics, and what loads is valid.

use proptest::prelude::*;
use rayreel_scenes::{LoadOptions, Scene};
use serde_json::json;
use tempfile::TempDir;

use crate::{load_file, writer::Writer};

/// A small file with a bit of everything that has an index, a length or a number.
fn rich() -> Vec<u8> {
    let mut w = Writer::triangle(json!({"name": "m", "alphaMode": "MASK", "normalTexture": {"index": 0},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}, "KHR_materials_ior": {"ior": 1.4}}}));
    let mut png = Vec::new();
    image::RgbaImage::new(2, 2)
        .write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png)
        .expect("encodes");
    let view = w.view(&png);
    w.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    w.push("samplers", json!({"wrapS": 33071}));
    w.push("textures", json!({"source": 0, "sampler": 0}));
    let (places, values) = (w.indices(&[1]), w.floats(&[[2.0_f32, 0.0, 0.0]]));
    let view = |w: &Writer, a: usize| w.json["accessors"][a]["bufferView"].clone();
    w.json["accessors"][0]["sparse"] = json!({"count": 1, "indices": {"bufferView": view(&w, places), "componentType": 5121},
        "values": {"bufferView": view(&w, values)}});
    w.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}));
    w.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}, {"type": "point"}]}});
    w.root(json!({"camera": 0, "children": [2], "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    w.push("nodes", json!({"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]}));
    let (input, output) = (w.floats(&[[0.0_f32], [0.1]]), w.floats(&[[0.0_f32, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]));
    w.push(
        "animations",
        json!({"samplers": [{"input": input, "output": output}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}]}),
    );
    w.glb()
}

fn try_bytes(folder: &TempDir, bytes: &[u8]) -> Option<Scene> {
    let path = folder.path().join("a.glb");
    std::fs::write(&path, bytes).expect("writes");
    load_file(&path, &LoadOptions { frames: 2, ..LoadOptions::default() }).ok()
}

#[test]
fn every_length_is_an_error_but_the_whole() {
    let (folder, whole) = (crate::folder(), rich());
    assert!(try_bytes(&folder, &whole).is_some(), "the whole file loads");
    for length in 0..whole.len() {
        assert!(try_bytes(&folder, &whole[..length]).is_none(), "{length} of {} bytes", whole.len());
    }
}

/// Every digit of the JSON becomes every other digit: most indices, counts and types go wrong once.
#[test]
fn every_digit_of_the_json_may_be_wrong() {
    let (folder, whole) = (crate::folder(), rich());
    let end = 20 + u32::from_le_bytes([whole[12], whole[13], whole[14], whole[15]]) as usize;
    let (mut loaded, mut refused) = (0, 0);
    for at in (20..end).filter(|at| whole[*at].is_ascii_digit()) {
        for digit in *b"012579" {
            let mut bytes = whole.clone();
            bytes[at] = digit;
            match try_bytes(&folder, &bytes) {
                Some(scene) => {
                    loaded += 1;
                    assert!(scene.validate().is_ok());
                }
                None => refused += 1,
            }
        }
    }
    assert!(loaded > 100 && refused > 100, "{loaded} loaded, {refused} refused");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bits_never_panic(flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u32), 1..6)) {
        let (folder, mut bytes) = (crate::folder(), rich());
        for (at, bit) in flips {
            let at = at.index(bytes.len());
            bytes[at] ^= 1 << bit;
        }
        if let Some(scene) = try_bytes(&folder, &bytes) {
            prop_assert!(scene.validate().is_ok());
        }
    }
}
