//! Geometry: strips and fans, types of indices, sparse and quantised accessors, trees of nodes, texture coordinates.

use glam::{Vec2, Vec3};
use rayreel_scenes::{LoadOptions, Scene};
use serde_json::{Value, json};

use crate::{message, writer::Writer};

/// A sheet of 4 x 1 squares in z = 0: upper row, then lower row, seen from +z.
fn sheet() -> Vec<[f32; 3]> {
    (0..5).map(|x| [x as f32, 1.0, 0.0]).chain((0..5).map(|x| [x as f32, 0.0, 0.0])).collect()
}

fn area(scene: &Scene) -> Vec3 {
    let mesh = &scene.mesh;
    let corner = |v: u32| mesh.positions[v as usize];
    let twice = |t: &rayreel_scenes::Triangle| {
        let [a, b, c] = t.vertices.map(corner);
        (b - a).cross(c - a)
    };
    mesh.triangles.iter().map(twice).sum::<Vec3>() / 2.0
}

fn with_mode(mode: Value, indices: &[u32]) -> Scene {
    let mut writer = Writer::new();
    let mesh = writer.triangles(&sheet(), indices);
    if !mode.is_null() {
        writer.json["meshes"][mesh]["primitives"][0]["mode"] = mode;
    }
    writer.root(json!({"mesh": mesh}));
    writer.load().1
}

#[test]
fn lists_strips_and_fans_are_the_same_sheet() {
    let strip = with_mode(json!(5), &[0, 5, 1, 6, 2, 7, 3, 8, 4, 9]);
    assert_eq!((strip.mesh.triangles.len(), area(&strip)), (8, Vec3::Z * 4.0));
    let list = with_mode(json!(null), &[0, 5, 1, 1, 5, 6]);
    assert_eq!((list.mesh.triangles.len(), area(&list)), (2, Vec3::Z));
    let fan = with_mode(json!(6), &[0, 5, 6, 7, 8]);
    assert_eq!((fan.mesh.triangles.len(), area(&fan)), (3, Vec3::Z * 1.5));
    assert!(strip.mesh.normals.iter().all(|n| *n == Vec3::Z), "without normals faces are flat");
}

#[test]
fn a_list_without_indices_takes_its_vertices_in_order() {
    let mut writer = Writer::new();
    let positions = writer.floats(&[[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0, 5.0, 5.0]]);
    let mesh = writer.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}}]}));
    writer.root(json!({"mesh": mesh}));
    let (folder, scene) = writer.load();
    assert_eq!(scene.mesh.triangles.len(), 1);
    crate::assert_warned(&folder, &scene, 1, "the last indices are no whole triangle");
}

#[test]
fn all_types_of_indices_and_strides_are_read() {
    for most in [4_u32, 300, 70_000] {
        let mut positions = vec![[0.0, 0.0, 0.0]; most as usize - 2];
        positions.extend([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let mut writer = Writer::new();
        let mesh = writer.triangles(&positions, &[0, most - 2, most - 1]);
        writer.root(json!({"mesh": mesh}));
        let scene = writer.load().1;
        assert_eq!(
            (area(&scene), scene.mesh.positions.len()),
            (Vec3::Z * 0.5, 3),
            "{most}: unused vertices are left out"
        );
    }
    // Position and something else, interleaved: 20 bytes apart, after 8 bytes of another use.
    let mut writer = Writer::new();
    let rows = [[0.0_f32, 0.0, 0.0, 9.0, 9.0], [1.0, 0.0, 0.0, 9.0, 9.0], [0.0, 1.0, 0.0, 9.0, 9.0]];
    let bytes: Vec<u8> = [7_u8; 8].into_iter().chain(rows.iter().flatten().flat_map(|v| v.to_le_bytes())).collect();
    let view = writer.view(&bytes);
    writer.json["bufferViews"][view]["byteStride"] = 20.into();
    let accessor = json!({"bufferView": view, "byteOffset": 8, "componentType": 5126, "count": 3, "type": "VEC3"});
    let accessor = writer.push("accessors", accessor);
    let mesh = writer.push("meshes", json!({"primitives": [{"attributes": {"POSITION": accessor}}]}));
    writer.root(json!({"mesh": mesh}));
    assert_eq!(area(&writer.load().1), Vec3::Z * 0.5, "min and max are not needed");
}

#[test]
fn quantised_positions_are_numbers() {
    let mut writer = Writer::new();
    let bytes: Vec<u8> =
        [[0_i8, 0, 0, 0], [127, 0, 0, 0], [0, -127, 0, 0]].as_flattened().iter().map(|v| *v as u8).collect();
    let view = writer.view(&bytes);
    writer.json["bufferViews"][view]["byteStride"] = 4.into();
    let accessor = json!({"bufferView": view, "componentType": 5120, "count": 3, "type": "VEC3", "normalized": true});
    let accessor = writer.push("accessors", accessor);
    let mesh = writer.push("meshes", json!({"primitives": [{"attributes": {"POSITION": accessor}}]}));
    writer.root(json!({"mesh": mesh, "scale": [2, 2, 2]}));
    writer.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let scene = writer.load().1;
    assert_eq!(scene.bounds(), (Vec3::new(0.0, -2.0, 0.0), Vec3::new(2.0, 0.0, 0.0)));
}

#[test]
fn sparse_values_replace_those_of_the_base_or_zeros() {
    for with_base in [true, false] {
        let mut writer = Writer::new();
        let base = writer.floats(&[[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let (places, values) = (writer.indices(&[1, 2]), writer.floats(&[[4.0_f32, 0.0, 0.0], [0.0, 6.0, 0.0]]));
        let view = |writer: &Writer, accessor: usize| writer.json["accessors"][accessor]["bufferView"].clone();
        let sparse = json!({"count": 2, "indices": {"bufferView": view(&writer, places), "componentType": 5121},
                            "values": {"bufferView": view(&writer, values)}});
        writer.json["accessors"][base]["sparse"] = sparse;
        if !with_base {
            writer.json["accessors"][base].as_object_mut().expect("is an object").remove("bufferView");
        }
        let mesh = writer.push("meshes", json!({"primitives": [{"attributes": {"POSITION": base}}]}));
        writer.root(json!({"mesh": mesh}));
        assert_eq!(area(&writer.load().1), Vec3::Z * 12.0, "with base: {with_base}");
    }
}

#[test]
fn trees_place_instances_and_mirrored_ones_keep_their_outside() {
    let mut writer = Writer::new();
    let mesh = writer.triangles(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 2]);
    writer.json["meshes"][mesh]["name"] = "kite".into();
    // A quarter turn about x takes +z to -y, twice the size, moved; the child moves by its parent's axes.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    writer.root(
        json!({"children": [1, 2], "rotation": [half, 0, 0, half], "scale": [2, 2, 2], "translation": [10, 0, 0]}),
    );
    writer.push("nodes", json!({"mesh": mesh, "translation": [0, 0, 1]}));
    let mirrored = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    writer.push("nodes", json!({"mesh": mesh, "name": "other", "matrix": mirrored}));
    let scene = writer.load().1;
    assert_eq!(scene.objects, ["kite", "other"]);
    let at = |triangle: usize| scene.mesh.triangles[triangle].vertices.map(|v| scene.mesh.positions[v as usize]);
    let near = |a: Vec3, b: [f32; 3]| (a - Vec3::from(b)).length() < 1e-5;
    assert!(
        near(at(0)[0], [10.0, -2.0, 0.0]) && near(at(0)[1], [12.0, -2.0, 0.0]) && near(at(0)[2], [10.0, -2.0, 2.0])
    );
    for triangle in 0..2 {
        let [a, b, c] = at(triangle);
        let normal = scene.mesh.normals[scene.mesh.triangles[triangle].vertices[0] as usize];
        assert!(
            near((b - a).cross(c - a).normalize(), [0.0, -1.0, 0.0]) && near(normal, [0.0, -1.0, 0.0]),
            "{triangle}"
        );
    }
}

#[test]
fn texture_transforms_and_sets_are_applied() {
    let mut writer = Writer::triangle(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 0,
        "extensions": {"KHR_texture_transform": {"offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2,
                                                 "scale": [2, 3], "texCoord": 1}}}}}));
    let wrong = writer.floats(&[[9.0_f32, 9.0]; 3]);
    let uvs = writer.floats(&[[0.0_f32, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    writer.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = wrong.into();
    writer.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = uvs.into();
    let mut png = Vec::new();
    image::RgbImage::new(1, 1).write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).expect("encodes");
    let view = writer.view(&png);
    writer.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    writer.push("textures", json!({"source": 0}));
    let scene = writer.load().1;
    let uvs = scene.mesh.triangles[0].vertices.map(|v| scene.mesh.uvs[v as usize]);
    // Scaled, then turned by a quarter as three.js and Babylon do, then moved; `v` of the scene points up.
    for (found, [u, v]) in uvs.into_iter().zip([[0.5, 0.25], [0.5, 0.25 - 2.0], [0.5 + 3.0, 0.25]]) {
        assert!((found - Vec2::new(u, 1.0 - v)).length() < 1e-5, "{found}");
    }
}

#[test]
fn a_tree_that_is_none_and_too_much_geometry_are_refused() {
    let mut ring = Writer::triangle(json!(null));
    ring.json["nodes"][0]["children"] = json!([0]);
    let (folder, scene) = ring.try_load(&LoadOptions::default());
    let text = message(&folder, &scene.expect_err("is a ring"));
    assert_eq!(text, "a.glb: node 0 `it`: it is reached twice: nodes must form a tree; export the model again");
    // One mesh of 10,000 triangles at ten thousand nodes.
    let mut many = Writer::new();
    let mesh = many.triangles(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 2].repeat(10_000));
    let nodes: Vec<Value> = (0..10_000).map(|_| json!({"mesh": mesh})).collect();
    many.json["nodes"] = nodes.into();
    many.json["scenes"][0]["nodes"] = (0..10_000).collect::<Vec<_>>().into();
    // Without area they are dropped before they take memory, but count.
    let view = many.json["accessors"][0]["bufferView"].as_u64().expect("is a number") as usize;
    let start = many.json["bufferViews"][view]["byteOffset"].as_u64().expect("is a number") as usize;
    many.bytes[start..start + 36].fill(0);
    let (folder, scene) = many.try_load(&LoadOptions::default());
    let text = message(&folder, &scene.expect_err("is too much"));
    assert!(
        text.contains("the scene has more than 33554432 triangles") && text.ends_with("; split the model"),
        "{text}"
    );
}
