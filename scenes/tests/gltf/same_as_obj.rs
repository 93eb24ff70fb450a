//! A room as OBJ and as glTF is the same scene, bit for bit, wherever both can say the same.

use std::fmt::Write;

use rayreel_scenes::{Camera, LoadOptions, Optics, Scene};
use serde_json::json;

use crate::{folder, load_file, writer::Writer};

/// One object: name, material, positions, normals (one a vertex or none), texture coordinates, triangles.
struct Object {
    name: &'static str,
    material: usize,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

const WHITE: usize = 0;
const RED: usize = 1;
const MIRROR: usize = 2;
const GLASS: usize = 3;
const LAMP: usize = 4;
const PICTURE: usize = 5;

const MTL: &str = "newmtl white\nKd 0.75 0.75 0.75\nNs 1\n\
    newmtl red\nKd 0.7 0.1 0.05\nNs 1\n\
    newmtl mirror\nKd 0 0 0\nKs 0.9 0.85 0.8\nNs 10000\nillum 5\n\
    newmtl glass\nKd 0 0 0\nNs 10000\nNi 1.25\nTf 0.95 1 0.9\nd 1\nillum 7\n\
    newmtl lamp\nKd 0.5 0.5 0.5\nNs 1\nKe 6 5 4\n\
    newmtl picture\nKd 1 0.5 0.25\nNs 1\nmap_Kd leaf.png\nmap_d leaf.png\n";

fn quad(name: &'static str, material: usize, corners: [[f32; 3]; 4]) -> Object {
    let uvs = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    Object { name, material, positions: corners.to_vec(), normals: Vec::new(), uvs, triangles }
}

/// An octahedron whose normals point from its middle: smooth.
fn jewel(name: &'static str, material: usize, at: [f32; 3]) -> Object {
    let points = [[0.3, 0., 0.], [0., 0.3, 0.], [0., 0., 0.3], [-0.3, 0., 0.], [0., -0.3, 0.], [0., 0., -0.3_f32]];
    let unit = |p: [f32; 3]| p.map(|x| if x == 0.0 { 0.0 } else { x.signum() });
    Object {
        name,
        material,
        positions: points.iter().map(|p| [p[0] + at[0], p[1] + at[1], p[2] + at[2]]).collect(),
        normals: points.map(unit).to_vec(),
        uvs: vec![[0.0; 2]; 6],
        triangles: [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]].to_vec(),
    }
}

fn room() -> Vec<Object> {
    vec![
        quad("floor", WHITE, [[-1., 0., 1.], [1., 0., 1.], [1., 0., -1.], [-1., 0., -1.]]),
        quad("back", WHITE, [[-1., 0., -1.], [1., 0., -1.], [1., 2., -1.], [-1., 2., -1.]]),
        quad("left", RED, [[-1., 0., 1.], [-1., 0., -1.], [-1., 2., -1.], [-1., 2., 1.]]),
        quad("right", MIRROR, [[1., 0., -1.], [1., 0., 1.], [1., 2., 1.], [1., 2., -1.]]),
        quad("ceiling", WHITE, [[-1., 2., -1.], [1., 2., -1.], [1., 2., 1.], [-1., 2., 1.]]),
        quad("lamp", LAMP, [[-0.3, 1.9, -0.3], [0.3, 1.9, -0.3], [0.3, 1.9, 0.3], [-0.3, 1.9, 0.3]]),
        quad("leaf", PICTURE, [[-0.8, 0.2, 0.1], [-0.2, 0.2, 0.3], [-0.2, 1.2, 0.3], [-0.8, 1.2, 0.1]]),
        jewel("ball", GLASS, [0.4, 0.5, 0.2]),
    ]
}

/// The OBJ text. Its `v` points up.
fn obj(objects: &[Object]) -> String {
    let mut text = String::from("mtllib room.mtl\n");
    let names = ["white", "red", "mirror", "glass", "lamp", "picture"];
    let (mut vertices, mut normals) = (1, 1);
    for object in objects {
        writeln!(text, "o {}\nusemtl {}", object.name, names[object.material]).expect("writes");
        object.positions.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").expect("writes"));
        object.uvs.iter().for_each(|[u, v]| writeln!(text, "vt {u} {v}").expect("writes"));
        object.normals.iter().for_each(|[x, y, z]| writeln!(text, "vn {x} {y} {z}").expect("writes"));
        for triangle in &object.triangles {
            let corner = |v: u32| {
                let (at, normal) = (v + vertices, v + normals);
                if object.normals.is_empty() { format!("{at}/{at}") } else { format!("{at}/{at}/{normal}") }
            };
            let corners = triangle.map(corner);
            writeln!(text, "f {}", corners.join(" ")).expect("writes");
        }
        vertices += object.positions.len() as u32;
        normals += object.normals.len() as u32;
    }
    text
}

/// The same as glTF, whose `v` points down.
fn gltf(objects: &[Object]) -> Writer {
    let mut out = Writer::new();
    let rough = |base: [f32; 4]| json!({"baseColorFactor": base, "metallicFactor": 0});
    let smooth =
        |base: [f32; 4], metal: f32| json!({"baseColorFactor": base, "metallicFactor": metal, "roughnessFactor": 0});
    let mut picture = rough([1.0, 0.5, 0.25, 1.0]);
    picture["baseColorTexture"] = json!({"index": 0});
    for (name, pbr) in [
        ("white", rough([0.75, 0.75, 0.75, 1.0])),
        ("red", rough([0.7, 0.1, 0.05, 1.0])),
        ("mirror", smooth([0.9, 0.85, 0.8, 1.0], 1.0)),
        ("glass", smooth([0.95, 1.0, 0.9, 1.0], 0.0)),
        ("lamp", rough([0.5, 0.5, 0.5, 1.0])),
        ("picture", picture),
    ] {
        out.push("materials", json!({"name": name, "pbrMetallicRoughness": pbr}));
    }
    out.json["materials"][GLASS]["extensions"] =
        json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.25}});
    out.json["materials"][LAMP]["emissiveFactor"] = json!([1.0, 5.0_f32 / 6.0, 4.0_f32 / 6.0]);
    out.json["materials"][LAMP]["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 6}});
    out.json["materials"][PICTURE]["alphaMode"] = json!("MASK");
    out.json["extensionsUsed"] =
        json!(["KHR_materials_transmission", "KHR_materials_ior", "KHR_materials_emissive_strength"]);
    out.push("images", json!({"uri": "leaf.png"}));
    out.push("textures", json!({"source": 0}));
    for object in objects {
        let uvs: Vec<[f32; 2]> = object.uvs.iter().map(|[u, v]| [*u, 1.0 - v]).collect();
        let mut attributes = json!({"POSITION": out.floats(&object.positions), "TEXCOORD_0": out.floats(&uvs)});
        if !object.normals.is_empty() {
            attributes["NORMAL"] = out.floats(&object.normals).into();
        }
        let indices = out.indices(object.triangles.as_flattened());
        let primitive = json!({"attributes": attributes, "indices": indices, "material": object.material});
        let mesh = out.push("meshes", json!({"primitives": [primitive]}));
        out.root(json!({"mesh": mesh, "name": object.name}));
    }
    out
}

/// What a picture depends on, triangle by triangle: vertices and materials may have another order.
fn corners(scene: &Scene) -> Vec<(String, Vec<u32>, String)> {
    let bits = |triangle: &rayreel_scenes::Triangle| {
        let vertex = |v: &u32| {
            let (v, mesh) = (*v as usize, &scene.mesh);
            let all = [mesh.positions[v].to_array(), mesh.normals[v].to_array(), mesh.uvs[v].extend(0.0).to_array()];
            // Adding zero makes -0 and 0 the same.
            all.as_flattened().iter().map(|x| (x + 0.0).to_bits()).collect::<Vec<_>>()
        };
        triangle.vertices.iter().flat_map(vertex).collect::<Vec<u32>>()
    };
    let material = |index: u32| {
        let mut m = scene.materials[index as usize].clone();
        let texels = |map: Option<usize>| map.map(|map| &scene.textures[map].texels);
        let maps = format!("{:?} {:?}", texels(m.diffuse_map), texels(m.alpha_map));
        (m.diffuse_map, m.alpha_map) = (None, None);
        // Not in a picture: an opaque surface bends nothing.
        if m.optics != Optics::Dielectric {
            m.ior = 1.0;
        }
        format!("{m:?} {maps}")
    };
    let triangles = scene.mesh.triangles.iter();
    triangles.map(|t| (scene.objects[t.object as usize].clone(), bits(t), material(t.material))).collect()
}

#[test]
fn a_room_is_the_same_scene_in_both() {
    let folder = folder();
    let path = folder.path();
    let objects = room();
    let leaf =
        image::RgbaImage::from_fn(4, 4, |x, y| image::Rgba([40 * x as u8, 60, 200, if x + y < 3 { 20 } else { 250 }]));
    leaf.save(path.join("leaf.png")).expect("writes");
    std::fs::write(path.join("room.mtl"), MTL).expect("writes");
    std::fs::write(path.join("room.obj"), obj(&objects)).expect("writes");
    let writer = gltf(&objects);
    writer.write_gltf(path, "room");
    writer.write_glb(path, "packed");
    std::fs::write(path.join("by.toml"), "model = \"room.gltf\"\n").expect("writes");
    let load = |name: &str| load_file(&path.join(name), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let wanted = load("room.obj");
    assert_eq!(wanted.materials.len(), 6);
    for name in ["room.gltf", "packed.glb", "by.toml"] {
        let scene = load(name);
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
        let (found, wanted_corners) = (corners(&scene), corners(&wanted));
        assert_eq!(found.len(), wanted_corners.len());
        for (at, (found, wanted)) in found.iter().zip(&wanted_corners).enumerate() {
            assert_eq!(found, wanted, "{name}: triangle {at}");
        }
        assert_eq!((&scene.lights, &scene.cameras, scene.sky), (&wanted.lights, &wanted.cameras, wanted.sky), "{name}");
    }
    let Camera { eye, .. } = wanted.cameras[0];
    assert!(eye.x.abs() < 1.0 && eye.y.abs() < 2.0 && eye.z.abs() < 1.0, "the camera stands in the room, not at {eye}");
}
