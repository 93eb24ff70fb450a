//! Every kind of bad input gives an error or a warning that says what is wrong, in which file and line.

mod common;

use std::{fs, path::Path};

use common::{TRIANGLE, folder, load_in, warnings};
use rayreel_scenes::{Optics, Scene, load, obj::load_obj};
use tempfile::TempDir;

fn obj_error(obj: &str) -> String {
    load_in(&folder(&[("a.obj", obj)]), "a.obj").expect_err("must not load")
}

fn mtl_error(mtl: &str) -> String {
    let obj = format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}");
    load_in(&folder(&[("a.obj", &obj), ("a.mtl", mtl)]), "a.obj").expect_err("must not load")
}

fn mtl(mtl: &str) -> Scene {
    let obj = format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}");
    load_in(&folder(&[("a.obj", &obj), ("a.mtl", mtl)]), "a.obj").unwrap_or_else(|e| panic!("{e}"))
}

fn toml_files(toml: &str) -> TempDir {
    let obj = format!("mtllib a.mtl\nusemtl board\n{TRIANGLE}");
    folder(&[("a.obj", &obj), ("a.mtl", "newmtl board\nKd 0.5 0.5 0.5\n"), ("s.toml", toml)])
}

fn toml_error(toml: &str) -> String {
    load_in(&toml_files(&format!("model = \"a.obj\"\n{toml}")), "s.toml").expect_err("must not load")
}

fn toml(toml: &str) -> Scene {
    load_in(&toml_files(&format!("model = \"a.obj\"\n{toml}")), "s.toml").unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn obj_errors_name_the_line() {
    let cases = [
        (
            "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n",
            "a.obj:2: vertex 2 is not finite (`v nan 0 0`); correct the coordinate or export the model again",
        ),
        ("v 0 0 0\nv 1e40 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj:2: vertex 2 is not finite"),
        ("v 0 0 0\nv 1 x 0\n", "a.obj:2: `v` has `x` where a number is needed; correct the number"),
        ("v 0 0\n", "a.obj:1: `v` has 2 numbers; a vertex needs three"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n",
            "a.obj:5: vertex index 4 is out of range: the file has 3; correct the face",
        ),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "a.obj:4: vertex index 0 is out of range"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "a.obj:4: vertex index -4 is out of range"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2 3\n",
            "a.obj:4: texture coordinate index 1 is out of range: the file has 0",
        ),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2 3\n", "a.obj:4: normal index 1 is out of range"),
        ("v 0 0 0\nf 1 a 1\n", "a.obj:2: `a` is no face corner; write v, v/vt, v//vn or v/vt/vn"),
        ("v 0 0 0\nf /1 1 1\n", "a.obj:2: `/1` is no face corner"),
        ("", "a.obj: the mesh is empty: it has no face with three corners; a scene needs at least one triangle"),
        ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 1\n", "a.obj: the mesh is empty: all 2 triangles have no area"),
        (
            "mtllib gone.mtl\nv 0 0 0\nf 1 1 1\n",
            "a.obj:1: the material library `gone.mtl` cannot be read; put it there",
        ),
        (
            "v 500000 0 4000000\nv 500000.1 0 4000000\nv 500000 0.1 4000000\nf 1 2 3\n",
            "a.obj: the mesh is empty: all 1 triangles have no area in single precision: the model, 1e-1 units large, lies 4e6 units from the origin",
        ),
    ];
    for (obj, wanted) in cases {
        let error = obj_error(obj);
        assert!(error.starts_with(wanted), "{obj:?}\n gives {error}\n  not {wanted}");
    }
}

#[test]
fn odd_obj_input_is_counted() {
    let obj = format!("{TRIANGLE}f 1 1 2\nf 1 2 2\nl 1 2\nusemtl nowhere\nf 3 2 1\nfoo bar\nf 1 2\n");
    let scene = load_in(&folder(&[("a.obj", &obj)]), "a.obj").expect("loads");
    assert_eq!(scene.mesh.triangles.len(), 2);
    let found = warnings(&scene);
    let has = |count: u64, text: &str| {
        assert!(found.iter().any(|(c, m)| *c == count && m.contains(text)), "{count} x {text} in {found:#?}")
    };
    has(2, "triangles without area were dropped");
    has(1, "points and lines");
    has(1, "material `nowhere` is in no library and becomes a default grey");
    has(1, "`foo` is not supported");
    has(1, "fewer than three corners");
    has(1, "faces without a material");
    assert_eq!(found.len(), 6);
}

#[test]
fn broken_normals_fall_back_to_the_face() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nvn nan 0 1\nvn 0 0 5\nf 1//1 2//2 3//3\n";
    let scene = load_in(&folder(&[("a.obj", obj)]), "a.obj").expect("loads");
    assert!(scene.mesh.normals.iter().all(|n| (n.z - 1.0).abs() < 1e-6), "{:?}", scene.mesh.normals);
    assert!(warnings(&scene).iter().any(|(c, m)| *c == 2 && m.contains("normal is zero or not finite")));
}

#[test]
fn corners_with_and_without_texture_coordinates_mix() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.25 0.75\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 2 4 3\nf 2/2 4 3/3\n";
    let scene = load_in(&folder(&[("a.obj", obj)]), "a.obj").expect("loads");
    assert_eq!(scene.mesh.uvs.len(), scene.mesh.positions.len());
    assert!(scene.mesh.uvs.contains(&[0.25, 0.75].into()));
}

#[test]
fn a_comment_that_ends_in_a_backslash_ends_there() {
    let obj = format!("# C:\\models\\\n{}", TRIANGLE.replace("f 1 2 3", "f 1 \\\n 2 3"));
    let scene = load_in(&folder(&[("a.obj", &obj)]), "a.obj").expect("loads");
    assert_eq!(scene.mesh.positions.len(), 3);
    let behind = format!("{}f 3 2 1\n", TRIANGLE.replace("f 1 2 3", "f 1 2 3 # C:\\models\\"));
    let scene = load_in(&folder(&[("a.obj", &behind)]), "a.obj").expect("loads");
    assert_eq!(scene.mesh.triangles.len(), 2);
}

#[test]
fn objects_are_merged_by_name_and_materials_by_library() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\no one\nusemtl x\nf 1 2 3\nusemtl y\nf 3 2 1\no empty\no two words\nf 1 2 3\no one\nf 1 2 3\n";
    let scene = load_in(&folder(&[("a.obj", obj), ("a.mtl", "newmtl y\nnewmtl x\n")]), "a.obj").expect("loads");
    assert_eq!(scene.objects, ["one", "two words"]);
    let ids: Vec<(u32, u32)> = scene.mesh.triangles.iter().map(|t| (t.object, t.material)).collect();
    assert_eq!(ids, [(0, 1), (0, 0), (1, 0), (0, 0)]);
}

#[test]
fn flat_boxes_stay_flat_and_shallow_bends_are_smooth() {
    // Two faces that meet at 20 degrees, and one at a right angle to the first.
    let obj = "v 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nv 2 -0.36397 0\nv 2 -0.36397 -1\nv 0 -1 0\nv 0 -1 -1\nf 1 2 3 4\nf 2 5 6 3\nf 7 1 4 8\n";
    let scene = load_in(&folder(&[("a.obj", obj)]), "a.obj").expect("loads");
    let mesh = &scene.mesh;
    let at = |x: f32, y: f32| {
        mesh.positions
            .iter()
            .zip(&mesh.normals)
            .filter(|(p, _)| p.x == x && p.y == y && p.z == 0.0)
            .map(|(_, n)| *n)
            .collect::<Vec<_>>()
    };
    let bend = at(1.0, 0.0);
    assert_eq!(bend.len(), 1, "one smooth normal: {bend:?}");
    assert!((f64::from(bend[0].x).atan2(f64::from(bend[0].y)).to_degrees() - 10.0).abs() < 0.01);
    assert_eq!(at(0.0, 0.0).len(), 2, "the right angle keeps its edge");
}

#[test]
fn mtl_errors_name_the_line() {
    let cases = [
        ("newmtl m\nKd 0.5 oops 0\n", "a.mtl:2: `Kd` has `oops` where a finite number is needed; correct the number"),
        ("newmtl m\nKd nan\n", "a.mtl:2: `Kd` has `nan` where a finite number is needed"),
        ("newmtl m\nKd 1 2\n", "a.mtl:2: `Kd` has 2 numbers; write one or three"),
        ("newmtl m\nKs -1 0 0\n", "a.mtl:2: `Ks` is negative; colours start at 0"),
        ("newmtl m\nNs\n", "a.mtl:2: `Ns` without a number; add the number or remove the line"),
        ("newmtl m\nd 2\n", "a.mtl:2: `d` is 2; it must be between 0 and 1"),
        ("newmtl m\nillum 99\n", "a.mtl:2: `illum 99` is no illumination model; it must be an integer from 0 to 10"),
        ("newmtl\n", "a.mtl:1: `newmtl` without a name"),
        ("newmtl m\nmap_Kd gone.png\n", "a.mtl:2: the texture `gone.png` cannot be read; put it there"),
        (
            "newmtl m\nmap_Kd -s 2 2 1 gone dir\\my tex.png\n",
            "a.mtl:2: the texture `gone dir/my tex.png` cannot be read; put it there",
        ),
        ("newmtl m\nmap_Kd\n", "a.mtl:2: `map_Kd` names no file"),
        ("newmtl m\nmap_Kd a.obj\n", "a.mtl:2: the texture `a.obj` cannot be decoded:"),
    ];
    for (text, wanted) in cases {
        let error = mtl_error(text);
        assert!(error.starts_with(wanted), "{text:?}\n gives {error}\n  not {wanted}");
    }
}

#[test]
fn mtl_statements_are_understood() {
    let of = |text: &str| mtl(&format!("newmtl m\n{text}")).materials[0].clone();
    let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} is not {b}");
    for (illum, optics) in [
        (2, Optics::Opaque),
        (3, Optics::Mirror),
        (8, Optics::Mirror),
        (5, Optics::FresnelMirror),
        (4, Optics::Dielectric),
        (9, Optics::Dielectric),
    ] {
        assert_eq!(of(&format!("illum {illum}")).optics, optics);
    }
    close(of("Kd 0.5").diffuse.z, 0.5);
    close(of("illum 7").ior, 1.5);
    close(of("illum 7").transmission.x, 1.0);
    close(of("illum 7\nTf .1 .2 .3").transmission.y, 0.8);
    close(of("illum 7\nTf .1 .2 .3\nd 1").transmission.y, 0.2);
    close(of("illum 7\nTf .1 .2 .6").transmission.y, 0.2);
    close(of("illum 2\nd 0.25\nKd 1 1 1").transmission.x, 0.75);
    assert_eq!(of("illum 2\nTr 0.75").optics, Optics::Dielectric);
    assert_eq!(of("illum 2\nd 0").optics, Optics::Opaque);
    assert_eq!(of("Ns 96.4").shininess, 96);
    close(of("Ke 17 12 4 # lamp").emission.y, 12.0);
    assert_eq!(warnings(&mtl("newmtl m\nKd spectral file.rfl\nbump x.png\nPr 0.3\n")).len(), 3);
}

#[test]
fn a_mask_without_alpha_gets_its_luminance() {
    let files = folder(&[
        ("a.obj", &format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}")),
        ("a.mtl", "newmtl m\nmap_Kd t.png\nmap_d -imfchan l t.png\n"),
    ]);
    image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([x as u8 * 255; 3]))
        .save(files.path().join("t.png"))
        .expect("saves");
    let scene = load_in(&files, "a.obj").expect("loads");
    assert_eq!((scene.materials[0].diffuse_map, scene.materials[0].alpha_map), (Some(0), Some(1)));
    assert_eq!(scene.textures[0].texels, [[0, 0, 0, 255], [255; 4]]);
    assert_eq!(scene.textures[1].texels, [[0; 4], [255; 4]]);
}

#[test]
fn toml_errors_say_where_and_what() {
    let eye = "[camera]\neye = [0.0, 0.0, 5.0]\n";
    let many = "[[lights]]\nkind = \"point\"\nposition = [1.0, 2.0, 3.0]\n".repeat(17);
    let cases: Vec<(String, &str)> = vec![
        ("modle = 3".into(), "s.toml:2:1: unknown field `modle`; did you mean `model`?"),
        ("[camera]\neye = \"here\"".into(), "s.toml:3:7: invalid type: string \"here\""),
        ("[camera]\nzoom = 1.0".into(), "s.toml:3:1: unknown field `zoom`"),
        ("name = ".into(), "s.toml:2:"),
        (
            "[lights]\nkind = \"point\"".into(),
            "s.toml:2:1: one table stands where a list of tables is needed; write its name in two brackets, such as `[[lights]]`",
        ),
        ("[[camera]]".into(), "s.toml:2: camera is a list, and a scene has one; write its name in one bracket"),
        ("[[materials.a]]\nreflect = 0.5".into(), "s.toml:2: materials.a is a list, and a scene has one"),
        (
            format!("{eye}target = [0.0, 0.0, 5.0]"),
            "s.toml: [camera]: the camera's eye and target are the same point; move one of them",
        ),
        (
            format!("{eye}target = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, 2.0]"),
            "s.toml: [camera]: the camera's up vector is parallel to its view axis",
        ),
        (
            format!("{eye}target = [0.0, 0.0, 0.0]\nvfov_deg = 180.0"),
            "s.toml: [camera]: the camera's vertical field of view is 180 degrees; use a value between 0 and 180",
        ),
        (format!("{eye}target = [0.0, nan, 0.0]"), "s.toml: [camera]: the camera has a coordinate that is not finite"),
        (eye.into(), "s.toml: [camera] has only one of eye and target; give both or neither"),
        (
            format!("{eye}path = \"x.csv\""),
            "s.toml: [camera] has more than one of eye/target, path and keyframes; keep one",
        ),
        ("[camera]\npath = \"gone.csv\"".into(), "s.toml:3: the camera path `gone.csv` cannot be read; put it there"),
        ("[camera]\nkeyframes = []".into(), "s.toml: camera.keyframes is empty"),
        (many, "s.toml: 17 lights are too many: at most 16 fit the trace; remove some"),
        ("[[lights]]\nkind = \"spot\"".into(), "s.toml:3:8: unknown variant `spot`"),
        ("[[lights]]\nkind = \"point\"".into(), "s.toml: lights[0] is a point light without a usable place"),
        (
            "[[lights]]\nkind = \"directional\"\nto_light = [0.0, 0.0, 0.0]".into(),
            "s.toml: lights[0] is a directional light without a usable direction",
        ),
        (
            "[sky]\ncolour = [-1.0, 0.0, 0.0]".into(),
            "s.toml: sky.colour is [-1.0, 0.0, 0.0]; colours are finite and not negative",
        ),
        ("[materials.bord]\nreflect = 0.5".into(), "s.toml:2: the model has no material `bord`; did you mean `board`?"),
        (
            "[materials.board]\nreflect = 1.5".into(),
            "s.toml: materials.board.reflect is 1.5; use a value between 0 and 1",
        ),
        ("[[lights]]\nkind = \"pointy\"".into(), "s.toml:3:8: unknown variant `pointy`; did you mean `point`?"),
        ("[camra]\neye = 3".into(), "s.toml:2:2: unknown field `camra`; did you mean `camera`?"),
        ("zzzz = 3".into(), "s.toml:2:1: unknown field `zzzz`; the keys are `name`, `model`, `camera`"),
        ("[materials.board]\nreflct = 0.5".into(), "s.toml:3:1: unknown field `reflct`; did you mean `reflect`?"),
        ("[materials.board]\nior = 0.5".into(), "s.toml: materials.board.ior is 0.5; use a value between 1 and 1000"),
    ];
    for (text, wanted) in cases {
        let error = toml_error(&text);
        assert!(error.starts_with(wanted), "{text:?}\n gives {error}\n  not {wanted}");
    }
}

#[test]
fn a_scene_file_is_taken_at_its_word() {
    let scene = toml(
        "name = \"mine\"\n[camera]\neye = [5.0, 3.2, 7.0]\ntarget = [0.0, 0.4, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov_deg = 36.0\n[[lights]]\nkind = \"point\"\n\
         position = [6.0, 10.0, 6.0]\nintensity = 0.5\ncolour = [1.0, 0.5, 0.0]\n[sky]\ncolour = [0.5, 0.6, 0.75]\nambient = 0.1\n[materials.board]\nreflect = 0.25\ndiffuse = [0.1, 0.2, 0.3]",
    );
    assert_eq!((scene.name.as_str(), scene.cameras.len(), scene.lights.len()), ("mine", 1, 1));
    assert_eq!(
        scene.lights[0],
        rayreel_scenes::Light::Point { position: [6.0, 10.0, 6.0].into(), colour: [0.5, 0.25, 0.0].into() }
    );
    assert_eq!((scene.materials[0].optics, scene.materials[0].specular.x), (Optics::Mirror, 0.25));
    assert!(scene.sky.ambient < 0.2 && scene.sky.horizon.x > scene.sky.ground.x);
    let plain = toml("");
    assert_eq!((plain.name.as_str(), plain.cameras.len(), plain.lights.len()), ("s", 1, 2));
}

#[test]
fn the_default_camera_looks_past_a_wide_floor() {
    let mut obj = String::from("v -1000 0 -1000\nv 1000 0 -1000\nv 1000 0 1000\nv -1000 0 1000\nf 4 3 2 1\n");
    for i in 0..500 {
        let (x, y) = (f64::from(i % 25) / 25.0, f64::from(i / 25) / 20.0);
        obj += &format!("v {x} {y} 0\nv {} {y} 0\nv {x} {} 0\nf -3 -2 -1\n", x + 0.03, y + 0.03);
    }
    let camera = load_in(&folder(&[("a.obj", &obj)]), "a.obj").expect("loads").cameras[0];
    assert!((camera.eye - camera.target).length() < 10.0, "{camera:?}");
}

#[test]
fn keyframes_and_paths_give_one_camera_per_frame() {
    let keys = "[camera]\nvfov_deg = 40.0\n[[camera.keyframes]]\nframe = 10\neye = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\n[[camera.keyframes]]\nframe = 14\neye = [4.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\n";
    let scene = toml(keys);
    assert_eq!(scene.cameras.len(), 5);
    assert_eq!(warnings(&scene)[0].1, "s.toml: its frame numbers begin at 10, which is frame 0 of the scene");
    assert!(
        (scene.cameras[2].eye.x - 2.0).abs() < 1e-6
            && scene.cameras[4].eye.x == 4.0
            && scene.cameras[1].vfov_deg == 40.0
    );
    assert!(toml_error(&keys.replace("frame = 14", "frame = 10")).contains("has frame 10 after a frame as late"));
    let header = rayreel_scenes::camera::PATH_HEADER;
    for (rows, wanted) in [
        ("1,0,0,5,0,0,0,0,1,0,60\n2,0,0,6,0,0,0,0,1,0,60\n", None),
        ("1,0,0,5,0,0,0,0,1,0\n", Some("p.csv:2: the row has 10 fields; a camera needs 11")),
        (
            "1,0,0,5,0,0,0,0,1,0,60\n3,0,0,5,0,0,0,0,1,0,60\n",
            Some("p.csv:3: frame 3 follows frame 1; frame numbers rise by one"),
        ),
        ("1,0,0,x,0,0,0,0,1,0,60\n", Some("p.csv:2: `x` is no finite number")),
        ("1,0,0,0,0,0,0,0,1,0,60\n", Some("p.csv:2: the camera's eye and target are the same point")),
        ("", Some("p.csv:1: the camera path has no frame")),
    ] {
        let files = toml_files("model = \"a.obj\"\n[camera]\npath = \"p.csv\"\n");
        fs::write(files.path().join("p.csv"), format!("{header}\n{rows}")).expect("writes");
        match (load_in(&files, "s.toml"), wanted) {
            (Ok(scene), None) => assert_eq!(scene.cameras.len(), 2),
            (Err(error), Some(wanted)) => {
                assert!(error.starts_with(wanted), "{error}\nnot {wanted}")
            }
            (other, wanted) => panic!("{other:?}, not {wanted:?}"),
        }
    }
}

#[test]
fn names_that_are_none_get_a_hint() {
    assert!(
        load("teapto")
            .expect_err("no scene")
            .to_string()
            .starts_with("no scene is called `teapto`; did you mean `teapot`?")
    );
    assert!(load("qqqqqqqq").expect_err("no scene").to_string().contains("the built-in scenes are `"));
    let folder = folder(&[]);
    fs::create_dir(folder.path().join("x.obj")).expect("creates");
    for name in ["", "x.obj"] {
        let error = load(folder.path().join(name).to_str().expect("UTF-8")).expect_err("a folder");
        assert!(error.to_string().contains("is a folder"), "{error}");
    }
    assert!(
        load_obj(Path::new("nowhere.obj"))
            .expect_err("no file")
            .to_string()
            .starts_with("nowhere.obj: cannot read this OBJ file")
    );
}

#[test]
fn comments_behind_names_of_files_are_none_of_the_name() {
    let obj = format!("mtllib a.mtl # mine\nusemtl m\n{TRIANGLE}");
    let scene = load_in(&folder(&[("a.obj", &obj), ("a.mtl", "newmtl m\nKd 1 0 0\n")]), "a.obj").expect("loads");
    assert_eq!(scene.materials[0].diffuse.to_array(), [1.0, 0.0, 0.0]);
    // A name may hold the sign.
    let obj = format!("mtllib a #2.mtl\nusemtl m\n{TRIANGLE}");
    let files = folder(&[("a.obj", &obj), ("a #2.mtl", "newmtl m\nmap_Kd t.png # wood\n")]);
    let error = load_in(&files, "a.obj").expect_err("has no texture");
    assert!(error.contains("the texture `t.png` cannot be read"), "{error}");
}

#[test]
fn a_text_in_utf_16_is_read() {
    let files = folder(&[]);
    let units: Vec<u8> = std::iter::once(0xfeff).chain(TRIANGLE.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    fs::write(files.path().join("a.obj"), units).expect("writes");
    assert_eq!(load_in(&files, "a.obj").expect("loads").mesh.triangles.len(), 1);
}

#[test]
fn what_passes_a_mirror_is_told_to_be_unread() {
    let told = |text: &str| warnings(&mtl(&format!("newmtl m\nKs 0.5 0.5 0.5\n{text}"))).len();
    assert_eq!([told("illum 3\n"), told("illum 3\nd 0.1\n"), told("illum 5\nTr 0.9\n")], [0, 1, 1]);
    assert_eq!([told("illum 2\nTf 1 1 1\n"), told("illum 2\nd 0.5\nTf 0.2 0.9 0.2\n")], [0, 1]);
}

#[test]
fn frames_a_second_are_of_what_moves() {
    let error = toml_error("[animation]\nfps = 24\n");
    assert!(error.contains("frames a second are of a glTF model, and a.obj is none"), "{error}");
}
