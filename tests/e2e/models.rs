//! Models from the command line: glTF beside OBJ, kinds of files that are not read, cameras and lights by flags.

use std::fs;
use std::path::Path;

use crate::common::{capture, digest};
use crate::rayreel;

/// A floor and a leaning triangle, as OBJ and as glTF with a buffer beside it. The camera node of the glTF rises by one unit
/// in half a second if it is asked for.
fn write(folder: &Path, flight: bool) {
    let obj = "mtllib m.mtl\no floor\nusemtl white\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nf 1 2 3\nf 1 3 4\n\
               o sail\nusemtl red\nv -1 0 0\nv 1 0 0.5\nv 0 1.5 -0.25\nf 5 6 7\n";
    let mtl = "newmtl white\nKd 0.75 0.75 0.75\nNs 1\nnewmtl red\nKd 0.7 0.1 0.05\nNs 1\n";
    fs::write(folder.join("m.obj"), obj).unwrap();
    fs::write(folder.join("m.mtl"), mtl).unwrap();
    let floor = [[-2., 0., 2.], [2., 0., 2.], [2., 0., -2.], [-2., 0., 2.], [2., 0., -2.], [-2., 0., -2.]];
    let sail = [[-1., 0., 0.], [1., 0., 0.5], [0., 1.5, -0.25_f32]];
    // Two times, and the camera's place at each.
    let film = [0.0, 0.5, 0.0, 2.0, 5.0, 0.0, 3.0, 5.0];
    let floats = floor.as_flattened().iter().chain(sail.as_flattened()).copied().chain(film);
    fs::write(folder.join("m.bin"), floats.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()).unwrap();
    let accessor = |view: usize, count: usize, kind: &str| {
        format!(r#"{{"bufferView":{view},"componentType":5126,"count":{count},"type":"{kind}"}}"#)
    };
    let view = |offset: usize, length: usize| format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#);
    let material = |name: &str, colour: &str| {
        format!(r#"{{"name":"{name}","pbrMetallicRoughness":{{"baseColorFactor":[{colour},1],"metallicFactor":0}}}}"#)
    };
    let mesh =
        |index: usize| format!(r#"{{"primitives":[{{"attributes":{{"POSITION":{index}}},"material":{index}}}]}}"#);
    let (camera, film) = if flight {
        (
            r#","cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}]"#,
            r#","animations":[{"samplers":[{"input":2,"output":3}],
                "channels":[{"sampler":0,"target":{"node":2,"path":"translation"}}]}]"#,
        )
    } else {
        ("", "")
    };
    let node = if flight { r#",{"name":"eye","camera":0}"# } else { "" };
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0,1{}]}}],"nodes":[{{"mesh":0,"name":"floor"}},{{"mesh":1,"name":"sail"}}{node}],
        "meshes":[{},{}],"materials":[{},{}],"buffers":[{{"uri":"m.bin","byteLength":140}}],
        "bufferViews":[{},{},{},{}],"accessors":[{},{},{},{}]{camera}{film}}}"#,
        if flight { ",2" } else { "" },
        mesh(0),
        mesh(1),
        material("white", "0.75,0.75,0.75"),
        material("red", "0.7,0.1,0.05"),
        view(0, 72),
        view(72, 36),
        view(108, 8),
        view(116, 24),
        accessor(0, 6, "VEC3"),
        accessor(1, 3, "VEC3"),
        accessor(2, 2, "SCALAR"),
        accessor(3, 2, "VEC3"),
    );
    fs::write(folder.join("m.gltf"), text).unwrap();
}

/// The bytes of a small picture.
#[track_caller]
fn picture(folder: &Path, scene: &Path, flags: &[&str]) -> Vec<u8> {
    let out = folder.join("picture.png");
    let mut args = vec!["render".into(), scene.into(), "-o".into(), out.clone().into_os_string()];
    args.extend(["--size", "48x24", "--samples", "2x2"].iter().chain(flags).map(std::ffi::OsString::from));
    crate::common::run(&args).expect(0);
    fs::read(out).unwrap()
}

#[test]
fn a_gltf_gives_the_picture_of_its_obj() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, false);
    let (obj, gltf) = (folder.join("m.obj"), folder.join("m.gltf"));
    assert_eq!(picture(folder, &obj, &[]), picture(folder, &gltf, &[]));
    let columns = |scene: &Path, name: &str| {
        let file = folder.join(name);
        let summary = capture(scene.to_str().unwrap(), "--size 48x24 --samples 1x1", &file);
        assert_eq!(summary["triangles"], 3);
        digest(&file)
    };
    // The metadata hold the hash of the scene, and vertices are stored in another order. All else is the same, bit for bit.
    let (mut a, mut b) = (columns(&obj, "a.rtrace"), columns(&gltf, "b.rtrace"));
    for digest in [&mut a, &mut b] {
        let columns = digest.as_object_mut().unwrap();
        assert!(columns.remove("meta").is_some() && columns.remove("total").is_some());
        assert!(columns.contains_key("bvh") && columns.contains_key("hits"), "{columns:?}");
    }
    assert_eq!(a, b);
}

#[test]
fn a_flight_in_a_gltf_is_captured_frame_by_frame() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, true);
    let gltf = folder.join("m.gltf");
    let shown = rayreel!["scenes", "show", &gltf, "--fps", "8", "--json"].expect(0).json();
    assert_eq!(shown["frames"], 5, "0 to 0.5 seconds");
    let film =
        capture(gltf.to_str().unwrap(), "--size 32x16 --samples 1x1 --fps 8 --frames 0..5", &folder.join("f.rtrace"));
    assert_eq!(film["frames"], 5);
    rayreel!["verify", &folder.join("f.rtrace")].expect(0);
    let render = |scene: &Path, frame: &str| {
        rayreel!["render", scene, "-o", &folder.join("x.png"), "--fps", "8", "--frame", frame].expect(2)
    };
    render(&gltf, "5").says(&["5"]);
    render(&gltf, "4294967295").says(&["give the number of a frame, below 4294967295"]);
    render(&folder.join("m.obj"), "0").says(&["frames a second are of a glTF model"]);
}

/// What is cut out of a film holds the meshes as the film has them.
#[test]
fn a_part_of_the_capture_of_a_moving_model_is_verified() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write(folder.path(), true);
    let gltf = at("m.gltf");
    let text = fs::read_to_string(&gltf).unwrap().replace(r#""node":2"#, r#""node":1"#);
    fs::write(&gltf, text).unwrap();
    capture(gltf.to_str().unwrap(), "--size 32x16 --samples 1x1 --fps 8 --frames 1..5", &at("f.rtrace"));
    rayreel!["trim", "--quiet", &at("f.rtrace"), "--frames", "3", "-o", &at("p.rtrace")].expect(0);
    let verify = |more: &[&str]| {
        let mut args: Vec<std::ffi::OsString> = vec!["verify".into(), at("p.rtrace").into(), "--scene".into()];
        args.push(gltf.clone().into());
        args.extend(["--fps", "8"].iter().chain(more).map(std::ffi::OsString::from));
        crate::common::run(&args)
    };
    let otherwise = verify(&[]).expect(1).out;
    assert!(
        otherwise.contains("differs from the scene: the vertices") && otherwise.contains("--stands-at N"),
        "{otherwise}"
    );
    assert!(verify(&["--stands-at", "1"]).expect(0).out.contains("as the scene: all tables"));
    rayreel!["verify", &at("p.rtrace"), "--stands-at", "1"].expect(2).says(&["--scene <SCENE>"]);
}

#[test]
fn other_kinds_of_files_are_told_what_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("x.png");
    for name in ["m.fbx", "m.ply", "m.STL", "m.usdz", "m.blend"] {
        let ran = rayreel!["render", name, "-o", &out].expect(2);
        let ran = ran.says(&["not read: models are .obj, .gltf or .glb", "`assimp export m."]);
        assert!(!ran.err.contains("no scene is called"), "{}", ran.err);
    }
    let bad = folder.path().join("m.glb");
    fs::write(&bad, b"glTF rest").unwrap();
    rayreel!["render", &bad, "-o", &out].expect(65).says(&["m.glb: the .glb is cut short"]);
    rayreel!["render", &folder.path().join("n.glb"), "-o", &out].expect(2).says(&["cannot read this glTF file"]);
}

#[test]
fn flags_replace_camera_lights_and_sky() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, false);
    let toml = folder.join("s.toml");
    let text = "model = \"m.gltf\"\n[camera]\neye = [0.5, 1.0, 4.0]\ntarget = [0.0, 0.5, 0.0]\nvfov_deg = 50.0\n\
                [[lights]]\nkind = \"point\"\nposition = [-1.0, 3.0, 2.0]\ncolour = [0.5, 0.75, 0.25]\nintensity = 1.0\n\
                [sky]\ncolour = [0.25, 0.5, 0.75]\n";
    fs::write(&toml, text).unwrap();
    let flags =
        ["--eye=0.5,1,4", "--target=0,0.5,0", "--fov=50", "--light=-1,3,2,0.5,0.75,0.25", "--sky=0.25,0.5,0.75"];
    let wanted = picture(folder, &toml, &[]);
    for scene in ["m.obj", "m.gltf", "s.toml"] {
        assert_eq!(picture(folder, &folder.join(scene), &flags), wanted, "{scene}");
        for left_out in 0..if scene == "s.toml" { 0 } else { flags.len() } {
            let mut some = flags.to_vec();
            some.remove(left_out);
            assert_ne!(picture(folder, &folder.join(scene), &some), wanted, "{scene} without {}", flags[left_out]);
        }
    }
    assert_ne!(picture(folder, &toml, &["--up=1,1,0"]), wanted);
    // Both eye and target: the camera stands still for all frames of a flight.
    let still = rayreel!["scenes", "show", "teapot", "--eye", "-3,2,4", "--target", "0,1,0", "--json"].expect(0).json();
    assert_eq!(still["frames"], 120);
}

#[test]
fn flags_that_place_no_camera_are_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("x.png");
    for (flags, words) in [
        (&["--eye=1,1,1", "--target=1,1,1"][..], "the camera's eye and target are the same point"),
        (&["--eye=0,5,0", "--target=0,0,0", "--up=0,1,0"], "up vector is parallel to its view axis"),
        (&["--up=0,0,0"], "up vector has no direction"),
        (&["--eye=1,2"], "give three numbers, such as 1,2.5,-3"),
        (&["--fov=180"], "give degrees between 0 and 180"),
        (&["--light=1,2,3,4"], "give a place and, if you like, a colour"),
        (&["--sky=1,-1,0"], "give three numbers from 0 on"),
        (&["--fps=0"], "give a number above 0"),
    ] {
        let mut args: Vec<std::ffi::OsString> =
            vec!["render".into(), "cornell".into(), "-o".into(), out.clone().into()];
        args.extend(flags.iter().map(std::ffi::OsString::from));
        crate::common::run(&args).expect(2).says(&[words]);
    }
    let many: Vec<std::ffi::OsString> = (0..17).map(|x| format!("--light={x},9,0").into()).collect();
    let args: Vec<_> = ["render".into(), "cornell".into(), "-o".into(), out.into()].into_iter().chain(many).collect();
    crate::common::run(&args).expect(2).says(&["17 lights are too many"]);
}

/// The glTF files below a folder.
fn models_in(folder: &Path) -> Vec<std::path::PathBuf> {
    let (mut todo, mut found) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(path.read_dir().unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|ending| ending == "gltf" || ending == "glb") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Skipped, saying so, unless `RAYREEL_MODELS` names a folder, such as that of Debian's `assimp-testmodels`.
#[test]
fn models_of_others_give_a_picture_or_one_error() {
    let Some(folder) = std::env::var_os("RAYREEL_MODELS") else {
        return eprintln!("skipped: RAYREEL_MODELS names no folder of models");
    };
    let models = models_in(Path::new(&folder));
    assert!(!models.is_empty(), "no .gltf and no .glb below {folder:?}");
    let out = tempfile::tempdir().unwrap();
    for model in models {
        let picture = out.path().join("a.png");
        let ran = rayreel!["render", &model, "-o", &picture, "--size", "32x24", "--samples", "1x1"];
        let errors = ran.err.lines().filter(|line| line.starts_with("error: ")).count();
        eprintln!("{}: code {}, {}", model.display(), ran.code, if errors == 0 { "a picture" } else { ran.err.trim() });
        assert!((ran.code == 0 && errors == 0) || (ran.code == 65 && errors == 1), "{ran:?}");
        assert_eq!(picture.exists(), errors == 0, "{ran:?}");
        let _ = fs::remove_file(picture);
    }
}
