//! Skins: vertices that follow joints, against closed forms.

use glam::{Quat, Vec3};
use rayreel_scenes::{LoadOptions, Scene};
use serde_json::{Value, json};

use crate::{message, writer::Writer};

/// Matrices of an inverse bind: translations alone.
fn bind(writer: &mut Writer, moves: &[[f32; 3]]) -> usize {
    let matrices: Vec<f32> = moves
        .iter()
        .flat_map(|[x, y, z]| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, *x, *y, *z, 1.0])
        .collect();
    let bytes: Vec<u8> = matrices.iter().flat_map(|v| v.to_le_bytes()).collect();
    let view = writer.view(&bytes);
    let accessor = json!({"bufferView": view, "componentType": 5126, "count": moves.len(), "type": "MAT4"});
    writer.push("accessors", accessor)
}

/// A triangle with a skin of two joints, which a node of its own moves: that must not count. The first joint stands at the
/// origin, the second at `second` and is bound at (1, 0, 0).
fn skinned(second: &Value, joints: [[u8; 4]; 3], weights: &[[f32; 4]; 3]) -> Writer {
    let mut writer = Writer::triangle(Value::Null);
    let view = writer.view(&joints.concat());
    let joints =
        writer.push("accessors", json!({"bufferView": view, "componentType": 5121, "count": 3, "type": "VEC4"}));
    let weights = writer.floats(weights);
    let attributes = &mut writer.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = joints.into();
    attributes["WEIGHTS_0"] = weights.into();
    let bind = bind(&mut writer, &[[0.0; 3], [-1.0, 0.0, 0.0]]);
    let first = writer.root(json!({"name": "hip", "children": [2]}));
    assert_eq!((first, writer.push("nodes", second.clone())), (1, 2));
    writer.push("skins", json!({"joints": [1, 2], "inverseBindMatrices": bind}));
    writer.json["nodes"][0]["skin"] = 0.into();
    writer.json["nodes"][0]["scale"] = json!([0.01, 0.01, 0.01]);
    writer
}

fn corners(scene: &Scene) -> Vec<Vec3> {
    let mesh = &scene.mesh;
    mesh.triangles[0].vertices.iter().map(|v| mesh.positions[*v as usize]).collect()
}

fn assert_close(found: &[Vec3], wanted: [[f32; 3]; 3]) {
    let near = found.iter().zip(wanted).all(|(a, b)| (*a - Vec3::from(b)).length() < 1e-6);
    assert!(near, "{found:?} for {wanted:?}");
}

#[test]
fn vertices_stand_where_their_joints_take_them() {
    // The second joint has gone from (1, 0, 0) to (1, 0, 2), and turned by a quarter round z.
    let turn = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2).to_array();
    let second = json!({"translation": [1, 0, 2], "rotation": turn});
    let weights = [[1.0, 0.0, 0.0, 0.0], [0.25, 0.75, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0]];
    let (_folder, scene) = skinned(&second, [[0, 1, 0, 0]; 3], &weights).load();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // Of the second corner a quarter stays; of the third the one weight, which is not 1, counts as all.
    assert_close(&corners(&scene), [[0.0; 3], [1.0, 0.0, 1.5], [0.0, -1.0, 2.0]]);
}

#[test]
fn joints_that_move_move_the_mesh() {
    let mut writer = skinned(&json!({"translation": [1, 0, 0]}), [[1, 0, 0, 0]; 3], &[[1.0, 0.0, 0.0, 0.0]; 3]);
    let (times, values) = (writer.floats(&[[0.0], [1.0]]), writer.floats(&[[1.0, 0.0, 0.0], [1.0, 3.0, 0.0]]));
    let sampler = json!({"input": times, "output": values, "interpolation": "LINEAR"});
    let channel = json!({"sampler": 0, "target": {"node": 2, "path": "translation"}});
    writer.push("animations", json!({"samplers": [sampler], "channels": [channel]}));
    for frame in [0, 15, 30] {
        let (_folder, scene) = writer.try_load(&LoadOptions { frame, ..LoadOptions::default() });
        let up = 0.1 * frame as f32;
        assert_close(&corners(&scene.unwrap()), [[0.0, up, 0.0], [1.0, up, 0.0], [0.0, 1.0 + up, 0.0]]);
    }
}

#[test]
fn a_skin_that_does_not_fit_is_an_error() {
    let one = [[1.0, 0.0, 0.0, 0.0]; 3];
    let said = |writer: &Writer| {
        let (folder, scene) = writer.try_load(&LoadOptions::default());
        message(&folder, &scene.unwrap_err())
    };
    let text = said(&skinned(&json!({}), [[0; 4], [2, 0, 0, 0], [0; 4]], &one));
    assert!(text.contains("vertex 1 has joint 2, and its skin has 2"), "{text}");
    let mut few = skinned(&json!({}), [[0; 4]; 3], &one);
    few.json["accessors"][4]["count"] = 1.into();
    let text = said(&few);
    assert!(text.contains("skin 0: it has 2 joints and 1 inverse bind matrices"), "{text}");
    let mut lost = skinned(&json!({}), [[0; 4]; 3], &one);
    lost.json["nodes"][1] = json!({"name": "hip"});
    let text = said(&lost);
    assert!(text.contains("skin 0: its joint 1, node 2, is not in the scene"), "{text}");
    let mut fewer = skinned(&json!({}), [[0; 4]; 3], &one);
    fewer.json["accessors"][3]["count"] = 2.into();
    let text = said(&fewer);
    assert!(text.contains("3 positions, 3 joints and 2 weights"), "{text}");
}

/// Without weights a vertex stands as it is stored, and so does a mesh without joints.
#[test]
fn vertices_without_weights_stand_as_they_are_stored() {
    let stored = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let far = json!({"translation": [9, 9, 9]});
    let writer = skinned(&far, [[1, 0, 0, 0]; 3], &[[0.0; 4]; 3]);
    assert_close(&corners(&writer.load().1), stored);
    let mut bare = skinned(&far, [[1, 0, 0, 0]; 3], &[[1.0, 0.0, 0.0, 0.0]; 3]);
    bare.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("JOINTS_0");
    assert_close(&corners(&bare.load().1), stored);
}
