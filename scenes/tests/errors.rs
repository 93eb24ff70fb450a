//! The kinds of errors, by who must act. The exit code of a command depends on them.

use rayreel_scenes::error::{Location, SceneError};
use rayreel_scenes::scene::MAX_LIGHTS;
use rayreel_scenes::{Light, Overrides, builtin, load};
use tempfile::TempDir;

#[test]
fn errors_are_sorted_by_who_must_act() {
    let folder = TempDir::new().expect("a temporary folder");
    let obj = "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(folder.path().join("a.obj"), obj).expect("writes");
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    assert!(matches!(load("no such scene"), Err(SceneError::Usage { .. })));
    assert!(matches!(load(&at("")), Err(SceneError::Usage { .. })));
    assert!(matches!(load(&at("none.obj")), Err(SceneError::Io { .. })));
    let Err(SceneError::Input { at: place, source: Some(source), .. }) = load(&at("a.obj")) else {
        panic!("a library is missing");
    };
    assert_eq!(place, Location::Line { path: folder.path().join("a.obj"), line: 1, column: None });
    assert_eq!(source.kind(), std::io::ErrorKind::NotFound);
    let mut scene = builtin("cornell").unwrap();
    scene.lights = vec![scene.lights[0]; MAX_LIGHTS + 1];
    let error = scene.validate().unwrap_err();
    assert_eq!(error.to_string(), "scene `cornell`: 17 lights are too many: at most 16 fit the trace; remove some");
    assert!(matches!(error, SceneError::Limit { .. }));
    scene.lights.clear();
    scene.objects.clear();
    assert!(matches!(scene.validate(), Err(SceneError::Inconsistent { .. })));
}

/// The message and the error of a scene file beside a triangle, `a.obj`.
fn of_scene_file(toml: &str) -> (String, SceneError) {
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::create_dir(folder.path().join("d.obj")).expect("creates");
    let path = folder.path().join("s.toml");
    for (path, text) in [(&folder.path().join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), (&path, toml)] {
        std::fs::write(path, text).expect("writes");
    }
    let error = load(path.to_str().expect("UTF-8")).expect_err("must not load");
    (error.to_string().replace(&format!("{}/", folder.path().display()), ""), error)
}

/// The scene file that names them was not named, and a wrong name on the command line was taken to be at fault.
#[test]
fn files_that_a_scene_file_names_and_that_are_missing_are_its_fault() {
    for (toml, line, wanted) in [
        ("name = \"x\"\nmodel = \"none.obj\"\n", 2, "the OBJ file `none.obj` cannot be read; put it there"),
        ("model=\"none.glb\"\n", 1, "the glTF file `none.glb` cannot be read; put it there"),
        ("model = \"d.obj\"\n", 1, "the model `d.obj` cannot be read; put it there"),
        ("model = \"a.obj\"\n[camera]\npath = \"none.csv\"\n", 3, "the camera path `none.csv` cannot be read"),
    ] {
        let (text, error) = of_scene_file(toml);
        assert!(text.starts_with(&format!("s.toml:{line}: {wanted}")), "{text}");
        assert!(matches!(error, SceneError::Input { source: Some(_), .. }), "{error:?}");
    }
}

/// That a scene is not consistent is said of what no user wrote.
#[test]
fn lights_beyond_what_can_be_drawn_are_the_fault_of_who_asks() {
    let light = "model = \"a.obj\"\n[[lights]]\nkind = \"point\"\n";
    for (keys, wanted) in [
        (
            "position = [1e19, 0.0, 0.0]",
            "s.toml: lights[0].position is [1e19, 0.0, 0.0]; coordinates of point lights are at most 1e18",
        ),
        (
            "position = [1.0, 2.0, 3.0]\ncolour = [1e38, 0.0, 0.0]\nintensity = 1e6",
            "s.toml: lights[0].colour is [1e38, 0.0, 0.0], and times its intensity of 1000000 above 3.4e38; use smaller ones",
        ),
    ] {
        let (error, _) = of_scene_file(&format!("{light}{keys}\n"));
        assert!(error.starts_with(wanted), "{error}\nnot {wanted}");
    }
    let mut scene = builtin("cornell").expect("is built in");
    let far = Overrides::point_light([1e20, 2.0, 3.0], [0.7; 3]);
    let nowhere = Light::Directional { to_light: [0.0; 3].into(), colour: [0.7; 3].into() };
    for (light, wanted) in [
        (far, "a light that was asked for is at [1e20, 2.0, 3.0]; coordinates of point lights are at most 1e18"),
        (nowhere, "a light that was asked for shines from no direction; give one that is not zero"),
    ] {
        let error =
            Overrides { lights: vec![light], ..Overrides::default() }.apply(&mut scene).expect_err("no such light");
        assert!(error.to_string().starts_with(wanted), "{error}");
        assert!(matches!(error, SceneError::Usage { .. }), "{error:?}");
    }
}
