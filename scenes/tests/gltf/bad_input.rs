//! Bad glTF gives one error that says what, where, and what to do.

use rayreel_scenes::{LoadOptions, load};
use serde_json::{Value, json};

use crate::{assert_warned, message, writer::Writer};

/// The error of a triangle whose JSON was changed.
fn error(change: impl Fn(&mut Value)) -> String {
    let mut writer = Writer::triangle(json!({"name": "m"}));
    change(&mut writer.json);
    let (folder, scene) = writer.try_load(&LoadOptions::default());
    message(&folder, &scene.expect_err("must not load"))
}

#[test]
fn errors_name_the_file_and_the_part() {
    type Change = fn(&mut Value);
    let cases: [(Change, &str); 18] = [
        (|j| j["asset"]["version"] = json!("1.0"), "a.glb: this is glTF 1.0, and 2.0 is read; export it as glTF 2.0"),
        (
            // Version 1 has objects where version 2 has lists.
            |j| *j = json!({"asset": {"version": "1.0.1"}, "meshes": {"a": {}}}),
            "a.glb: this is glTF 1.0.1, and 2.0 is read; export it as glTF 2.0",
        ),
        (
            |j| j["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
            "a.glb: it requires the extension KHR_draco_mesh_compression, which is not read; unpack it: `gltf-transform copy",
        ),
        (
            |j| j["extensionsRequired"] = json!(["X_y"]),
            "X_y, which is not read; export it without, or convert it: `assimp",
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(99),
            "a.glb: mesh 0, primitive 0: there is no accessor 99; export the model again",
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["material"] = json!(9),
            "a.glb: meshes[0].primitives[0].material: the index is out of range",
        ),
        (|j| j["nodes"][0]["mesh"] = json!(7), "a.glb: nodes[0].mesh: the index is out of range"),
        (
            |j| j["accessors"][0]["count"] = json!(4),
            "a.glb: accessor 0: 4 elements of 12 bytes, 12 apart, from byte 0 of buffer view 0 do not fit its 36 bytes",
        ),
        (|j| j["accessors"][0]["count"] = json!(u64::MAX), "do not fit its 36 bytes"),
        (|j| j["accessors"][0]["name"] = json!("spots"), ""),
        (
            |j| j["accessors"][0]["type"] = json!("VEC2"),
            "a.glb: accessor 0: its elements are Vec2 of F32, and 3 numbers are needed",
        ),
        (
            |j| j["bufferViews"][0]["byteLength"] = json!(1_u64 << 40),
            "buffer view 0 takes 1099511627776 bytes from byte 0 of buffer 0",
        ),
        (|j| j["bufferViews"][0]["byteStride"] = json!(4), "a.glb: accessor 0: 3 elements of 12 bytes, 4 apart"),
        (|j| j["nodes"][0]["matrix"] = json!([1e39, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "a.glb:1:"),
        (
            |j| j["nodes"][0]["matrix"] = json!([1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "the last row of its matrix is not 0 0 0 1",
        ),
        (
            |j| j["nodes"][0]["scale"] = json!([0, 0, 0]),
            "a.glb: the scene is empty: no node has a mesh with a triangle that has an area in single precision",
        ),
        (|j| j["materials"][0]["pbrMetallicRoughness"] = json!({"roughnessFactor": 2}), "material"),
        (
            |j| j["buffers"] = json!([{"byteLength": 5000}]),
            "a.glb: buffer 0: it has 40 bytes of the 5000 that the file states",
        ),
    ];
    for (at, (change, words)) in cases.into_iter().enumerate() {
        if words.is_empty() {
            continue;
        }
        let text = error(change);
        assert!(text.contains(words), "case {at}: {text}\nnot {words}");
    }
}

#[test]
fn files_beside_the_model_are_read_and_no_others() {
    for (uri, words) in [
        ("https://example.org/a.bin", "is not in a file beside the model, and nothing is fetched; download it"),
        ("file:///etc/passwd", "is not in a file beside the model"),
        ("../a.bin", "leaves the model's folder, and only files in it are read; put the file there"),
        ("sub/%2e%2e/../../a.bin", "leaves the model's folder"),
        ("/etc/passwd", "leaves the model's folder"),
        ("missing.bin", "missing.bin` cannot be read"),
        // By its names: no folder `sub` need be there, and one that is a link leads nowhere else.
        ("sub/../missing.bin", "missing.bin` cannot be read"),
        ("", "names no file"),
        ("data:application/octet-stream;base64,%%%", "is no base64"),
        ("data:nothing", "has no data"),
    ] {
        let text = error(|json| json["buffers"] = json!([{"byteLength": 40, "uri": uri}]));
        assert!(text.starts_with("a.glb: buffer 0: ") && text.contains(words), "{uri}: {text}");
    }
}

#[test]
fn data_uris_hold_buffers_with_and_without_padding() {
    use base64::Engine;
    let writer = Writer::triangle(json!(null));
    for engine in [base64::engine::general_purpose::STANDARD, base64::engine::general_purpose::STANDARD_NO_PAD] {
        let mut inside = writer.clone();
        let uri = format!("data:application/octet-stream;base64,{}", engine.encode(&writer.bytes));
        inside.json["buffers"] = json!([{"byteLength": writer.bytes.len(), "uri": uri}]);
        inside.bytes.clear();
        assert_eq!(inside.load().1.content_hash(), writer.load().1.content_hash());
    }
}

#[test]
fn unknown_kinds_of_files_say_what_is_read_and_how_to_convert() {
    for name in ["x.fbx", "some/where.PLY", "x.stl", "x.usdz", "x.blend", "x.qqq"] {
        let text = load(name).expect_err("is not read").to_string();
        assert!(
            text.starts_with(&format!("{name}: ."))
                && text.contains("models are .obj, .gltf or .glb, scene files .toml"),
            "{text}"
        );
        // What nobody knows no program converts.
        let fix = if name == "x.qqq" {
            "; name a model"
        } else {
            "; convert it: Blender exports glTF 2.0 and OBJ, or `assimp export "
        };
        assert!(text.contains(fix), "{text}");
    }
    assert!(load("x.fbx").expect_err("is not read").to_string().ends_with("`assimp export x.fbx x.obj`"));
    assert!(
        load("gone.glb").expect_err("is not there").to_string().starts_with("gone.glb: cannot read this glTF file")
    );
}

/// glTF 2.0 lets a file leave these out, or say more than anybody reads.
#[test]
fn what_gltf_allows_is_read() {
    let model = || Writer::triangle(json!({}));
    let scene = |change: &dyn Fn(&mut Writer)| {
        let mut writer = model();
        change(&mut writer);
        writer.load()
    };
    let plain = model().load().1.content_hash();
    let cases: [&dyn Fn(&mut Writer); 7] = [
        &|w| w.json["meshes"][0]["primitives"][0]["attributes"]["_BATCHID"] = json!(0),
        &|w| w.json["nodes"][0]["extras"] = json!("a text"),
        &|w| w.json["asset"]["extras"] = json!(null),
        &|w| {
            w.push("scenes", json!({}));
        },
        &|w| w.json["asset"] = json!({"version": "2.7", "minVersion": "2.0"}),
        &|w| {
            // All zeros: it turns nothing, and no picture is mapped by it.
            let zeros = w.push("accessors", json!({"componentType": 5126, "type": "VEC2", "count": 3}));
            w.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(zeros);
        },
        &|w| {
            let (times, values) = (w.floats(&[[0.0], [1.0]]), w.floats(&[[0.0], [1.0]]));
            w.push(
                "animations",
                json!({
                    "samplers": [{"input": times, "output": values}],
                    "channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/a"}}}}]
                }),
            );
        },
    ];
    for (number, change) in cases.into_iter().enumerate() {
        assert_eq!(scene(change).1.content_hash(), plain, "case {number}");
    }
    let (folder, odd) = scene(&|w| {
        let (times, values) = (w.floats(&[[0.0], [1.0]]), w.floats(&[[0.0], [1.0]]));
        let channel = json!({"sampler": 0, "target": {"node": 0, "path": "pointer"}});
        w.push("animations", json!({"samplers": [{"input": times, "output": values}], "channels": [channel]}));
    });
    assert_warned(
        &folder,
        &odd,
        1,
        "it moves something else than a node's translation, rotation or scale, and is not read",
    );
}

#[test]
fn what_a_file_requires_and_nobody_reads_is_refused() {
    for (change, words) in [
        (
            json!({"extensionsRequired": ["EXT_texture_webp"]}),
            "EXT_texture_webp, which is not read; convert its pictures to PNG",
        ),
        (json!({"asset": {"version": "2.0", "minVersion": "2.1"}}), "this is glTF 2.1, and 2.0 is read"),
    ] {
        let message = error(|json| {
            change.as_object().expect("an object").iter().for_each(|(key, value)| json[key] = value.clone());
        });
        assert!(message.contains(words), "{message}");
    }
    let (folder, result) =
        Writer::triangle(json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.1]}}))
            .try_load(&LoadOptions::default());
    let error = message(&folder, &result.expect_err("nothing is left"));
    assert!(error.contains("its materials cut all of it away"), "{error}");
}

/// Of what is packed nothing is left without the extension, whether the file says that it requires it or not.
#[test]
fn packed_meshes_are_named_as_such() {
    let draco = error(|j| {
        j["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        j["meshes"][0]["primitives"][0]["extensions"] =
            json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
        let accessor = j["accessors"][0].as_object_mut().unwrap();
        accessor.remove("bufferView");
    });
    assert!(
        draco.contains("it uses the extension KHR_draco_mesh_compression") && draco.contains("unpack it"),
        "{draco}"
    );
    // With its data beside the packed ones a mesh is whole.
    let mut whole = Writer::triangle(json!({"name": "m"}));
    whole.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    whole.load();
    let meshopt = error(|j| {
        j["buffers"] = json!([{"byteLength": 42}, {"byteLength": 36}]);
        j["bufferViews"][0]["buffer"] = json!(1);
        j["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression": {"buffer": 0, "byteLength": 36,
            "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"}});
    });
    assert!(meshopt.contains("it uses the extension EXT_meshopt_compression"), "{meshopt}");
}
