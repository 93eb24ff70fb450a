//! The built-in scene `lab`: what is in it, sound triangles, filled vessels, a path through free air.

use std::{collections::BTreeMap, sync::LazyLock};

use glam::{DVec3, Vec3};
use rayreel_scenes::{
    Optics, Scene, builtin,
    modelling::{
        Part,
        profile::{c, s},
        vessel::Vessel,
    },
};

/// Content hash, the same on every machine.
const HASH: &str = "7f333733d2a1a290b4af0b595e0899cb4bc0021e5115cecb70e955503fb7712b";

/// The scene, built once for all tests.
fn lab() -> &'static Scene {
    static LAB: LazyLock<Scene> = LazyLock::new(|| builtin("lab").unwrap_or_else(|e| panic!("{e}")));
    &LAB
}

#[test]
fn there_is_what_a_laboratory_needs() {
    let scene = lab();
    for name in
        ["still", "condenser", "receiver", "burette", "retort", "rack", "test tube 7", "red beaker", "sink", "tap"]
    {
        assert!(scene.objects.iter().any(|o| o == name), "no {name}");
    }
    let liquids: Vec<_> = scene.objects.iter().filter_map(|o| o.strip_suffix(": liquid")).collect();
    assert!(liquids.len() >= 30, "{} liquids", liquids.len());
    for vessel in liquids {
        assert_eq!(scene.objects.iter().filter(|o| *o == vessel).count(), 1, "the vessel of {vessel}");
    }
    let coloured = |m: &&rayreel_scenes::Material| {
        m.optics == Optics::Dielectric && m.transmission.max_element() > 1.5 * m.transmission.min_element()
    };
    assert!(scene.materials.iter().filter(coloured).count() >= 6, "coloured transmission");
    assert_eq!(scene.lights.len(), 3);
    assert!(scene.textures.len() >= 6);
}

/// Recorded figures hang on these bytes: a change here is a change of the scene, on purpose or not.
#[test]
fn the_scene_is_the_same_everywhere() {
    let hash: String = lab().content_hash().iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(hash, HASH, "lab has changed");
}

#[test]
fn every_triangle_has_an_area() {
    let mesh = &lab().mesh;
    for (i, t) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = t.vertices.map(|v| mesh.positions[v as usize].as_dvec3());
        let area = (b - a).cross(c - a).length() / 2.0;
        assert!(area > 1e-8, "triangle {i} of area {area:e}");
    }
}

/// Positions by bit pattern, so that seams count only where they are exact.
fn open_edges(parts: &[&Part]) -> usize {
    let key = |p: DVec3| (p.as_vec3() + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut edges: BTreeMap<_, i32> = BTreeMap::new();
    for part in parts {
        for t in &part.triangles {
            let t = t.map(|v| key(part.positions[v as usize]));
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                continue;
            }
            for k in 0..3 {
                *edges.entry((t[k], t[(k + 1) % 3])).or_default() += 1;
            }
        }
    }
    edges.iter().filter(|((a, b), count)| **count != 1 || edges.get(&(*b, *a)) != Some(&1)).count()
}

fn volume(parts: &[&Part]) -> f64 {
    let corners = |part: &Part| -> f64 {
        let sixth = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| part.positions[v as usize]);
            a.dot(b.cross(c)) / 6.0
        };
        part.triangles.iter().map(sixth).sum()
    };
    parts.iter().map(|part| corners(part)).sum()
}

/// A straight cylinder, where volumes can be worked out by hand.
#[test]
fn wall_and_liquid_are_one_closed_solid() {
    let (radius, height, wall) = (1.0, 3.0, 0.05);
    let vessel = Vessel::new(&[s(0.0, 0.0), c(radius, 0.0), c(radius, height)], 0.5, wall, 64);
    let pi = std::f64::consts::PI;
    let empty = vessel.empty();
    assert_eq!(open_edges(&[&empty]), 0);
    let wanted = pi * (radius * radius * height - (radius - wall) * (radius - wall) * (height - wall));
    assert!((volume(&[&empty]) - wanted).abs() < 0.05 * wanted, "{} for {wanted}", volume(&[&empty]));
    for level in [0.4, 1.0, 2.13, 2.8] {
        let filled = vessel.filled(level);
        let [wet, surface] = &filled.liquid;
        let parts = [&filled.glass, wet, surface];
        assert_eq!(open_edges(&parts), 0, "level {level}");
        let dry = pi * (radius * radius - (radius - wall) * (radius - wall)) * (height - level);
        let wanted = pi * radius * radius * level + dry;
        assert!((volume(&parts) - wanted).abs() < 0.02 * wanted, "level {level}: {} for {wanted}", volume(&parts));
        assert!(open_edges(&[&filled.glass]) > 0 && open_edges(&[wet, surface]) > 0, "they share the rest");
    }
}

/// No camera stands in the box round any object, even grown by a hand's breadth, and all stand in the room.
#[test]
fn the_camera_flies_through_free_air() {
    const BREADTH: f32 = 0.8;
    let scene = lab();
    let mut boxes = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); scene.objects.len()];
    for t in &scene.mesh.triangles {
        let (low, high) = &mut boxes[t.object as usize];
        for v in t.vertices {
            let p = scene.mesh.positions[v as usize];
            (*low, *high) = (low.min(p), high.max(p));
        }
    }
    assert!(scene.cameras.len() >= 60);
    for (frame, camera) in scene.cameras.iter().enumerate() {
        let eye = camera.eye;
        assert!(eye.x.abs() < 24.0 && (1.0..15.0).contains(&eye.y) && (-7.0..25.0).contains(&eye.z), "frame {frame}");
        for ((low, high), name) in boxes.iter().zip(&scene.objects) {
            let outside = (*low - eye).max(eye - *high).max_element();
            assert!(outside > BREADTH, "frame {frame}: the eye is {outside} from {name}");
        }
    }
}

#[test]
fn the_path_is_smooth() {
    let cameras = &lab().cameras;
    let smooth = |get: fn(&rayreel_scenes::Camera) -> Vec3| {
        for (i, three) in cameras.windows(3).enumerate() {
            let (first, second) = (get(&three[1]) - get(&three[0]), get(&three[2]) - get(&three[1]));
            assert!(first.length() < 0.4, "frame {i}: a step of {}", first.length());
            assert!((second - first).length() < 0.03, "frame {i}: a jerk of {}", (second - first).length());
        }
    };
    smooth(|c| c.eye);
    smooth(|c| c.target);
}
