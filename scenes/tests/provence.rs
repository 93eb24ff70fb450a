//! The built-in scene `provence`: its flight, its water and panes, its ground.

use std::{collections::BTreeMap, sync::LazyLock};

use glam::{Vec2, Vec3};
use rayreel_scenes::{Optics, Scene, builtin};

/// Made once: half a million triangles are a second's work.
static SCENE: LazyLock<Scene> = LazyLock::new(|| builtin("provence").expect("provence is a built-in scene"));

/// Triangles of the objects that `which` picks by name.
fn triangles(which: impl Fn(&str) -> bool) -> Vec<[Vec3; 3]> {
    let picked: Vec<bool> = SCENE.objects.iter().map(|name| which(name)).collect();
    let triangles = SCENE.mesh.triangles.iter().filter(|t| picked[t.object as usize]);
    triangles.map(|t| t.vertices.map(|v| SCENE.mesh.positions[v as usize])).collect()
}

/// Height of a triangle over a place, if it lies there.
fn height_over([a, b, c]: &[Vec3; 3], p: Vec2) -> Option<f32> {
    let flat = |v: Vec3| Vec2::new(v.x, v.z);
    let whole = (flat(*b) - flat(*a)).perp_dot(flat(*c) - flat(*a));
    let u = (p - flat(*a)).perp_dot(flat(*c) - flat(*a)) / whole;
    let v = (flat(*b) - flat(*a)).perp_dot(p - flat(*a)) / whole;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(a.y + (b.y - a.y) * u + (c.y - a.y) * v)
}

#[test]
fn the_flight_has_700_frames_and_neither_jumps_nor_whirls() {
    let cameras = &SCENE.cameras;
    assert_eq!(cameras.len(), 700);
    for (i, camera) in cameras.iter().enumerate() {
        let next = &cameras[(i + 1) % cameras.len()];
        let (step, way) = (camera.eye.distance(next.eye), |c: &rayreel_scenes::Camera| (c.target - c.eye).normalize());
        assert!((0.03..0.5).contains(&step), "frame {i} moves by {step} m");
        let turn = way(camera).dot(way(next)).min(1.0).acos().to_degrees();
        assert!(turn < 4.0, "frame {i} turns by {turn} degrees");
    }
    // The course has no kink: its steps change slowly.
    for i in 0..cameras.len() {
        let eye = |k: usize| cameras[(i + k) % cameras.len()].eye;
        let bend = (eye(2) - eye(1)) - (eye(1) - eye(0));
        assert!(bend.length() < 0.03, "frame {i} bends by {bend}");
    }
}

#[test]
fn the_flight_stays_over_the_ground() {
    let ground = triangles(|name| ["land", "field", "road", "court", "paving", "water"].contains(&name));
    for (i, camera) in SCENE.cameras.iter().enumerate().step_by(7) {
        let p = Vec2::new(camera.eye.x, camera.eye.z);
        let highest = ground.iter().filter_map(|t| height_over(t, p)).fold(f32::MIN, f32::max);
        let over = camera.eye.y - highest;
        assert!((0.9..8.0).contains(&over), "frame {i} is {over} m over the ground");
    }
}

#[test]
fn the_flight_keeps_clear_of_everything() {
    // Corners in cells of one metre; what is large and flat is tested by height, or stands far off.
    let cell = |p: Vec3| p.floor().as_ivec3().to_array();
    let mut corners: BTreeMap<[i32; 3], Vec<Vec3>> = BTreeMap::new();
    for p in &SCENE.mesh.positions {
        corners.entry(cell(*p)).or_default().push(*p);
    }
    for (i, camera) in SCENE.cameras.iter().enumerate() {
        let [x, y, z] = cell(camera.eye);
        for k in 0..27 {
            let near = corners.get(&[x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]);
            for p in near.into_iter().flatten() {
                let away = p.distance(camera.eye);
                assert!(away > 0.6, "frame {i} passes {away} m from {p}");
            }
        }
    }
}

#[test]
fn the_flight_stays_outside_the_houses() {
    for name in ["house", "wing", "barn"] {
        let walls: Vec<Vec3> = triangles(|n| n == format!("{name} walls")).into_iter().flatten().collect();
        let (low, high) = walls.iter().fold((Vec3::MAX, Vec3::MIN), |(l, h), p| (l.min(*p), h.max(*p)));
        let margin = Vec3::splat(1.0);
        for (i, camera) in SCENE.cameras.iter().enumerate() {
            let inside = camera.eye.cmpgt(low - margin).all() && camera.eye.cmplt(high + margin).all();
            assert!(!inside, "frame {i} is in the {name}");
        }
    }
}

#[test]
fn the_water_has_a_floor_below_it() {
    let (water, floor) = (triangles(|n| n == "water"), triangles(|n| n == "pool floor"));
    let mut tested = 0;
    for triangle in &floor {
        let middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
        let p = Vec2::new(middle.x, middle.z);
        let heights: Vec<f32> = water.iter().filter_map(|t| height_over(t, p)).collect();
        let (low, high) = heights.iter().fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(*y), h.max(*y)));
        assert!(low < middle.y && middle.y + 0.5 < high, "water from {low} to {high}, floor at {}", middle.y);
        tested += 1;
    }
    assert!(tested > 500);
}

#[test]
fn every_window_has_six_panes_of_glass() {
    let glass = |t: &&rayreel_scenes::Triangle| SCENE.materials[t.material as usize].optics == Optics::Dielectric;
    let panes: Vec<usize> = (0..SCENE.objects.len()).filter(|o| SCENE.objects[*o].ends_with(" panes")).collect();
    assert!(panes.len() >= 12, "{} windows", panes.len());
    for object in panes {
        let count = SCENE.mesh.triangles.iter().filter(glass).filter(|t| t.object as usize == object).count();
        assert_eq!(count, 6 * 12, "{}", SCENE.objects[object]);
    }
}

#[test]
fn no_triangle_is_a_line_and_no_place_is_nan() {
    for (i, t) in SCENE.mesh.triangles.iter().enumerate() {
        let [a, b, c] = t.vertices.map(|v| SCENE.mesh.positions[v as usize]);
        assert!((b - a).cross(c - a).length() > 0.0, "triangle {i} of `{}`", SCENE.objects[t.object as usize]);
    }
    assert!(SCENE.mesh.positions.iter().all(|p| p.is_finite()) && SCENE.mesh.uvs.iter().all(|uv| uv.is_finite()));
}
