//! The kinds of errors, by who must act. The exit code of a command depends on them.

use rayreel_scenes::error::{Location, SceneError};
use rayreel_scenes::scene::MAX_LIGHTS;
use rayreel_scenes::{builtin, load};
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
