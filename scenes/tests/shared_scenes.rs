//! Real scenes, when they are at hand beside the repository.

use std::path::PathBuf;

use rayreel_scenes::{Optics, load, obj::load_obj};

/// Model and triangles, from the folder's README; zero-area ones have been dropped.
const MODELS: [(&str, usize); 11] = [
    ("teapot/teapot.obj", 15_706),
    ("teapot/teapot_glass.obj", 15_706),
    ("chess/chess.obj", 39_756),
    ("chess/chess_glass.obj", 39_756),
    ("car_focus/car_focus.obj", 55_155 - 2),
    ("chemlab/chemlab.obj", 100_032),
    ("provence_candela/provence_candela.obj", 430_628),
    ("cornell/CornellBox-Empty-CO.obj", 12),
    ("cornell/CornellBox-Original.obj", 36),
    ("cornell/CornellBox-Sphere.obj", 2_188),
    ("cornell/CornellBox-Water.obj", 7_088),
];

/// The folder with the scenes, or `None` with a word on stderr.
fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    if !folder.is_dir() {
        eprintln!("skipped: there is no ../shared/scenes beside the repository");
        return None;
    }
    Some(folder)
}

#[test]
fn every_model_loads_with_its_triangles() {
    let Some(folder) = folder() else { return };
    for (name, triangles) in MODELS {
        let start = std::time::Instant::now();
        let scene =
            load(folder.join(name).to_str().expect("the path is UTF-8")).unwrap_or_else(|e| panic!("{name}: {e}"));
        eprintln!(
            "{name}: {} triangles, {} vertices, {} objects, {:?}",
            scene.mesh.triangles.len(),
            scene.mesh.positions.len(),
            scene.objects.len(),
            start.elapsed()
        );
        scene.warnings.iter().for_each(|w| eprintln!("  {} x {}", w.count, w.message));
        assert_eq!(scene.mesh.triangles.len(), triangles, "{name}");
    }
}

#[test]
fn the_car_says_what_was_dropped() {
    let Some(folder) = folder() else { return };
    let car = load_obj(folder.join("car_focus/car_focus.obj")).expect("the car loads");
    let dropped: Vec<u64> =
        car.warnings.iter().filter(|w| w.message.contains("without area")).map(|w| w.count).collect();
    assert_eq!(dropped, [2]);
}

#[test]
fn the_cornell_glass_is_read_as_a_filter() {
    let Some(folder) = folder() else { return };
    let cornell = load_obj(folder.join("cornell/CornellBox-Sphere.obj")).expect("the box loads");
    let glass = cornell.materials.iter().find(|m| m.name == "rightSphere").expect("it has a glass sphere");
    assert_eq!(glass.optics, Optics::Dielectric);
    assert!((glass.transmission.x - 0.9).abs() < 1e-6 && (glass.ior - 2.5).abs() < 1e-6, "{glass:?}");
}

#[test]
fn the_fly_through_has_seven_hundred_cameras() {
    let Some(folder) = folder() else { return };
    let path = folder.join("provence_candela/camera_700.csv");
    let cameras = rayreel_scenes::camera::read_path(&path).expect("the path loads");
    assert_eq!(cameras.len(), 700);
}
