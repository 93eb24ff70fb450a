//! `car`, and what `teapot` and `chess` promise beside it: panes, soundness, paths, contact planes.

use std::sync::LazyLock;

use glam::Vec3;
use rayreel_scenes::{Optics, Scene, builtin};

static CAR: LazyLock<Scene> = LazyLock::new(|| scene("car"));

fn scene(name: &str) -> Scene {
    builtin(name).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The corners of an object's triangles.
fn corners(scene: &Scene, object: &str) -> Vec<Vec3> {
    let index = scene.objects.iter().position(|o| o == object).unwrap_or_else(|| panic!("no `{object}`"));
    let triangles = scene.mesh.triangles.iter().filter(|t| t.object as usize == index);
    triangles.flat_map(|t| t.vertices).map(|v| scene.mesh.positions[v as usize]).collect()
}

/// The lowest and the highest corner coordinates.
fn bounds(corners: &[Vec3]) -> (Vec3, Vec3) {
    corners.iter().fold((Vec3::MAX, Vec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)))
}

#[test]
fn triangles_have_numbers_and_area() {
    let scene = &*CAR;
    for (i, t) in scene.mesh.triangles.iter().enumerate() {
        let [a, b, c] = t.vertices.map(|v| scene.mesh.positions[v as usize].as_dvec3());
        assert!(a.is_finite() && b.is_finite() && c.is_finite(), "triangle {i}");
        let area = (b - a).cross(c - a).length();
        assert!(area > 1e-9, "triangle {i} of `{}` is {a}, {b}, {c}", scene.objects[t.object as usize]);
    }
}

/// The sides of the car are mirror images and meet in the middle to the bit: a seam would show in the paint.
#[test]
fn the_body_is_symmetric() {
    let scene = &*CAR;
    for object in ["body", "roof", "windscreen"] {
        let corners = corners(scene, object);
        let astray = corners.iter().find(|p| p.z != 0.0 && p.z.abs() < 0.004);
        assert_eq!(astray, None, "`{object}` has a corner beside the middle");
        let (low, high) = bounds(&corners);
        assert!((low.z + high.z).abs() < 1e-4, "`{object}` reaches from {} to {}", low.z, high.z);
    }
    let [left, right] = ["left door window", "right door window"].map(|o| bounds(&corners(scene, o)));
    assert_eq!((left.0.z, left.1.z), (-right.1.z, -right.0.z));
}

/// A car and not a toy: metres, four wheels on the ground, lower than long, windows above the waist.
#[test]
fn the_car_has_the_size_of_a_car_and_stands_on_its_wheels() {
    let scene = &*CAR;
    let (low, high) = bounds(&corners(scene, "body"));
    let size = high - low;
    assert!((4.0..4.6).contains(&size.x) && (1.5..1.8).contains(&size.z), "the body is {size}");
    assert!(bounds(&corners(scene, "roof")).1.y < 1.35);
    for wheel in ["front left wheel", "front right wheel", "rear left wheel", "rear right wheel"] {
        let bottom = bounds(&corners(scene, wheel)).0.y;
        assert!(bottom.abs() < 0.004, "`{wheel}` starts at {bottom}");
    }
}

#[test]
fn windows_are_panes_of_glass_that_one_can_see_through() {
    let scene = &*CAR;
    let windows: Vec<&String> = scene.objects.iter().filter(|o| o.ends_with("window") || *o == "windscreen").collect();
    assert_eq!(windows.len(), 6);
    for window in windows {
        let index = scene.objects.iter().position(|o| o == window);
        let triangles: Vec<_> = scene.mesh.triangles.iter().filter(|t| Some(t.object as usize) == index).collect();
        assert!(
            triangles.iter().all(|t| scene.materials[t.material as usize].optics == Optics::Dielectric),
            "`{window}`"
        );
        // A closed pane: its volume by its one-sided area is its thickness, six millimetres.
        let (mut volume, mut area) = (0.0, 0.0);
        for t in triangles {
            let [a, b, c] = t.vertices.map(|v| scene.mesh.positions[v as usize].as_dvec3());
            volume += a.dot(b.cross(c)) / 6.0;
            area += (b - a).cross(c - a).length() / 2.0;
        }
        let thickness = volume / (area / 2.0);
        assert!((0.004..0.007).contains(&thickness), "`{window}` is {thickness} thick");
    }
}

/// Between car and columns, above the ground: the path cannot enter anything, for nothing stands there.
#[test]
fn the_path_stays_between_car_and_columns() {
    let scene = &*CAR;
    let empty = |p: &Vec3| (4.0..9.0).contains(&p.with_y(0.0).length()) && p.y > 0.05 && p.y < 3.0;
    for (frame, camera) in scene.cameras.iter().enumerate() {
        assert!(empty(&camera.eye) && camera.eye.y > 0.5, "frame {frame} at {}", camera.eye);
    }
    let inside = scene.mesh.positions.iter().find(|p| empty(p));
    assert_eq!(inside, None, "something stands where the camera goes");
}

/// Glass whose foot lies on the very plane of the ground would be speckled: rounding would choose which of the
/// two a ray meets first.
#[test]
fn no_glass_shares_a_plane_with_the_ground() {
    for scene in [&scene("teapot"), &scene("chess"), &*CAR] {
        for t in &scene.mesh.triangles {
            if scene.materials[t.material as usize].optics == Optics::Dielectric {
                let on_plane = t.vertices.iter().all(|v| scene.mesh.positions[*v as usize].y.abs() < 1e-3);
                assert!(!on_plane, "{}: `{}` lies on the ground's plane", scene.name, scene.objects[t.object as usize]);
            }
        }
    }
}
