//! Lamps become lights where they shine; faces are flat or smooth, and sizes told, as a model asks for.

mod common;

use common::{TRIANGLE, folder, load_in, warnings};

#[test]
fn lamps_of_the_model_become_lights() {
    let obj = format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}");
    let files = folder(&[("a.obj", &obj), ("a.mtl", "newmtl m\nKe 17 8.5 0\n")]);
    let scene = load_in(&files, "a.obj").expect("loads");
    let [rayreel_scenes::Light::Point { position, colour }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert!(position.z > 0.0 && (colour.y * 2.0 - colour.x).abs() < 1e-6, "in front of it: {position} {colour}");
}

/// A lamp that shines to all sides, an octahedron, at some height over a floor.
#[test]
fn a_lamp_is_not_put_below_the_floor_that_it_stands_on() {
    let scene = |height: f32| {
        let mut obj = String::from(
            "mtllib a.mtl\nv -9 0 -9\nv 9 0 -9\nv 9 0 9\nv -9 0 9\no floor\nusemtl f\nf 4 3 2 1\no lamp\nusemtl m\n",
        );
        for [x, y, z] in [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]] {
            obj += &format!("v {x} {} {z}\n", height + y as f32);
        }
        for [x, y, z] in [[5, 7, 9], [9, 7, 6], [6, 7, 10], [10, 7, 5], [9, 8, 5], [6, 8, 9], [10, 8, 6], [5, 8, 10]] {
            obj += &format!("f {x} {y} {z}\n");
        }
        let files = folder(&[("a.obj", &obj), ("a.mtl", "newmtl f\nKd 1 1 1\nnewmtl m\nKe 1 1 1\n")]);
        let scene = load_in(&files, "a.obj").expect("loads");
        let [rayreel_scenes::Light::Point { position, .. }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
        position.y - height
    };
    assert!(scene(1.0) > 1.0, "it stands on the floor: above");
    assert!(scene(3.0) < -1.0, "it hangs: below");
}

/// A panel that looks up at a ceiling just above it.
#[test]
fn a_lamp_below_a_ceiling_has_its_light_between_the_two() {
    let light = |ceiling: f32| {
        let quad = |y: f32, half: f32| {
            format!("v -{half} {y} -{half}\nv -{half} {y} {half}\nv {half} {y} {half}\nv {half} {y} -{half}\n")
        };
        let obj = format!(
            "mtllib a.mtl\n{}{}{}usemtl f\no floor\nf 1 2 3 4\no ceiling\nf 8 7 6 5\nusemtl m\no lamp\nf 9 10 11 12\n",
            quad(0.0, 9.0),
            quad(ceiling, 9.0),
            quad(2.95, 1.0)
        );
        let files = folder(&[("a.obj", &obj), ("a.mtl", "newmtl f\nKd 1 1 1\nnewmtl m\nKe 1 1 1\n")]);
        let scene = load_in(&files, "a.obj").expect("loads");
        let [rayreel_scenes::Light::Point { position, .. }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
        position.y
    };
    assert!((2.951..3.0).contains(&light(3.0)), "{}", light(3.0));
    assert!((3.1..4.0).contains(&light(4.0)), "as far from it as there is room: {}", light(4.0));
}

/// A box of sky around a floor.
#[test]
fn a_sky_of_lamps_lights_from_within() {
    let mut obj = String::from("mtllib a.mtl\nusemtl m\no sky\n");
    for corner in 0..8 {
        let at = |bit: i32| if corner >> bit & 1 == 0 { -9 } else { 9 };
        obj += &format!("v {} {} {}\n", at(0), at(1), at(2));
    }
    obj += "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
    obj += "v -9 0 -9\nv -9 0 9\nv 9 0 9\nv 9 0 -9\nusemtl f\no floor\nf 9 10 11 12\n";
    let files = folder(&[("a.obj", &obj), ("a.mtl", "newmtl f\nKd 1 1 1\nnewmtl m\nKe 1 1 1\n")]);
    let scene = load_in(&files, "a.obj").expect("loads");
    let [rayreel_scenes::Light::Point { position, .. }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(position.to_array(), [0.0, 4.5, 0.0], "between floor and sky");
}

#[test]
fn a_lamp_can_be_put_out_and_lit_in_a_scene_file() {
    let lights = |toml: &str| {
        let obj = format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}usemtl n\nf 1 3 2\n");
        let mtl = "newmtl m\nKe 1 1 1\nnewmtl n\nKd 1 1 1\n";
        let files = folder(&[("a.obj", &obj), ("a.mtl", mtl), ("s.toml", &format!("model = \"a.obj\"\n{toml}"))]);
        load_in(&files, "s.toml").expect("loads").lights
    };
    assert_eq!(lights("").len(), 1);
    assert_eq!(lights("[materials.m]\nemission = [0, 0, 0]\n").len(), 2, "the default lights");
    let dark = "[materials.m]\nemission = [0, 0, 0]\n[materials.n]\nemission = [0, 1, 0]\n";
    let [rayreel_scenes::Light::Point { colour, .. }] = lights(dark)[..] else { panic!("one lamp") };
    assert!(colour.x == 0.0 && colour.y > 0.0);
}

/// So far away a light gave none.
#[test]
fn a_light_has_a_direction_from_everywhere() {
    let load = |far: &str| {
        let toml = format!("model = \"a.obj\"\n[[lights]]\nkind = \"point\"\nposition = [0, {far}, 0]\n");
        load_in(&folder(&[("a.obj", TRIANGLE), ("s.toml", &toml)]), "s.toml")
    };
    assert!(load("9e17").is_ok());
    let error = load("3e19").expect_err("no direction");
    assert!(
        error.contains("lights[0].position is [0.0, 3e19, 0.0]") && error.contains("make it directional"),
        "{error}"
    );
}

/// Glass that says no colour was grey all over, and a model of light without a highlight had one.
#[test]
fn what_a_material_leaves_out_follows_from_its_model_of_light() {
    let of = |text: &str| {
        let files =
            [("a.obj", format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}")), ("a.mtl", format!("newmtl m\n{text}\n"))];
        let scene =
            load_in(&folder(&files.each_ref().map(|(name, text)| (*name, text.as_str()))), "a.obj").expect("loads");
        (scene.materials[0].diffuse.z, scene.materials[0].specular.y)
    };
    assert_eq!([of("illum 2"), of("Ks 0.5"), of("illum 1\nKs 0.5")], [(0.8, 0.0), (0.8, 0.5), (0.8, 0.0)]);
    assert_eq!([of("illum 7"), of("illum 7\nKd 0.5\nKs 0.5")], [(0.0, 1.0), (0.5, 0.5)]);
}

/// Exports that are mirrored turn the corners and not the normals: they were drawn in flat faces, and their glass began where it ended.
#[test]
fn an_object_that_turns_its_backs_to_its_normals_is_turned_round() {
    // A pyramid with smooth normals, as two objects; of the second one face is broken.
    let pyramid = |last: &str| {
        format!(
            "v 1 0 0\nv 0 0 -1\nv -1 0 0\nv 0 0 1\nv 0 1 0\nvn 1 1 0\nvn 0 1 -1\nvn -1 1 0\nvn 0 1 1\nvn 0 1 0\n\
             o a\nf 1//1 2//2 5//5\nf 2//2 3//3 5//5\nf 3//3 4//4 5//5\no b\nf 4//4 1//1 5//5\nf 1//1 2//2 5//5\n{last}"
        )
    };
    let load = |obj: &str| load_in(&folder(&[("a.obj", obj)]), "a.obj").expect("loads");
    let turned = |obj: String| {
        let lines = obj.lines().map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["f", a, b, c] => format!("f {a} {c} {b}\n"),
            _ => format!("{line}\n"),
        });
        lines.collect::<String>()
    };
    let faces = |scene: &rayreel_scenes::Scene| -> Vec<glam::Vec3> {
        let corners = |t: &rayreel_scenes::Triangle| t.vertices.map(|v| scene.mesh.positions[v as usize]);
        scene.mesh.triangles.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a)).collect()
    };
    let right = load(&pyramid("f 2//2 3//3 5//5\n"));
    let is_told = |scene: &rayreel_scenes::Scene| -> u64 {
        let told = warnings(scene).into_iter().filter(|(_, words)| words.contains("were turned round"));
        told.map(|(count, _)| count).sum()
    };
    assert!(is_told(&right) == 0 && faces(&right).iter().all(|face| face.y > 0.0));
    let wrong = load(&turned(pyramid("f 2//2 3//3 5//5\n")));
    assert_eq!((faces(&wrong), is_told(&wrong)), (faces(&right), 2), "both objects, in one warning");
    // One face of three stays as it is.
    let one = load(&pyramid("f 2//2 5//5 3//3\n"));
    assert_eq!((is_told(&one), faces(&one).iter().filter(|face| face.y < 0.0).count()), (0, 1));
}

#[test]
fn smoothing_that_is_off_leaves_faces_flat() {
    let normals = |statement: &str| {
        let obj = format!("{statement}v 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
        let scene = load_in(&folder(&[("a.obj", &obj)]), "a.obj").expect("loads");
        scene.mesh.normals.len()
    };
    assert_eq!((normals(""), normals("s 1\n")), (4, 4), "corners are shared");
    assert_eq!((normals("s off\n"), normals("s 0\n")), (6, 6), "each face has its own");
}

#[test]
fn triangles_that_are_tiny_beside_their_distance_are_told() {
    // Two tiny triangles so far apart, and a large one below the first or none.
    let load = |away: f32, floor: bool| {
        let tiny = |x: f32| format!("v {x} 0 0\nv {x} 0 0.01\nv {x} 0.01 0\n");
        let large = if floor { "v 1e5 0 0\nv 0 0 1e5\nv -1e5 0 -1e5\nf 7 8 9\n" } else { "" };
        let obj = format!("{}{}f 1 2 3\nf 4 5 6\n{large}", tiny(0.0), tiny(away));
        let scene = load_in(&folder(&[("a.obj", &obj)]), "a.obj").expect("it loads");
        let of_padding = |words: &String| words.contains("padded");
        warnings(&scene).into_iter().map(|(_, words)| words).filter(of_padding).collect::<Vec<_>>()
    };
    assert_eq!(load(160.0, false), Vec::<String>::new(), "1 / 16384 of the distance is the limit");
    let [words] = &load(200.0, false)[..] else { panic!("one warning") };
    assert!(
        words.starts_with("a.obj: half of the triangles are smaller than 5e-5 of their distance from the middle"),
        "{words}"
    );
    assert_eq!(
        load(0.1, true),
        Vec::<String>::new(),
        "a floor that reaches far takes nothing from what stands on its middle"
    );
}

#[test]
fn sizes_and_places_that_floats_hold_badly_are_told() {
    let load = |scale: f32, away: f32| {
        let corner = |x: f32, y: f32| format!("v {} {} 0\n", x * scale + away, y * scale);
        let obj = format!("{}{}{}f 1 2 3\n", corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0));
        load_in(&folder(&[("a.obj", &obj)]), "a.obj").map(|scene| {
            warnings(&scene).into_iter().filter(|(_, words)| !words.contains("without a material")).collect::<Vec<_>>()
        })
    };
    for (scale, away) in [(1.0, 0.0), (1e8, 0.0), (1e-9, 0.0), (1.0, 1000.0)] {
        assert_eq!(load(scale, away), Ok(vec![]), "{scale} at {away}");
    }
    for (scale, away, words) in [
        (1e10, 0.0, "a.obj: the model is 1e10 units large: surfaces may be lit wrongly; scale it nearer to 1"),
        (1e-12, 0.0, "a.obj: the model is 1e-12 units large: surfaces may be lit wrongly; scale it nearer to 1"),
        (
            1.0,
            1_048_576.0,
            "a.obj: the model, 1e0 units large, lies 1.048577e6 units from the origin: surfaces may be lit wrongly; move it there",
        ),
    ] {
        assert_eq!(load(scale, away), Ok(vec![(1, words.into())]), "{scale} at {away}");
    }
    let error = load(1e16, 0.0).expect_err("is too large");
    assert_eq!(error, "a.obj: the model is 1e16 units large; scale it nearer to 1");
}
