//! The built-in scenes: sizes, closed glass, orientation, normals, hashes.

use std::{collections::BTreeMap, sync::LazyLock};

use glam::Vec3;
use rayreel_scenes::{Optics, Scene, builtin, builtin_names};

/// Triangle counts that the paper's scenes have; `cornell` only has to stay small.
const COUNTS: [(&str, usize); 5] =
    [("teapot", 15_000), ("chess", 42_000), ("car", 55_000), ("lab", 98_000), ("provence", 600_000)];

/// Content hashes, the same on every machine.
const HASHES: [(&str, &str); 5] = [
    ("cornell", "4787d3825e3f7c394bd0ecddcc06882997850f728ecad76333ed163107ccce24"),
    ("teapot", "f9168be8130f9dd35b08eb42d6218710c6eca7ef22ff12dc7b3de323c02c38a0"),
    ("chess", "a5528fcb14f46c65d7ba7318b35b15f1d74bf7f926c40b242f4365b451e1db37"),
    ("car", "fcd6adcbcace82b7b94fae6ce3c1f2c5a15ca8265e7e46065fc62c7ee792847a"),
    ("provence", "d35220f6d8605e3e21f491238cfff5ed32095bb5eafcc470ba3f4f3a701d8a89"),
];

/// A scene, generated once for all tests: the big ones take seconds in a debug build.
fn scene(name: &str) -> &'static Scene {
    static SCENES: LazyLock<BTreeMap<&str, LazyScene>> = LazyLock::new(|| {
        builtin_names().iter().map(|name| (*name, LazyScene::new(Box::new(|| generate(name))))).collect()
    });
    SCENES.get(name).unwrap_or_else(|| panic!("no scene {name}"))
}

type LazyScene = LazyLock<Scene, Box<dyn FnOnce() -> Scene + Send>>;

fn generate(name: &str) -> Scene {
    builtin(name).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn triangle_counts_are_within_two_percent() {
    for (name, wanted) in COUNTS {
        let count = scene(name).mesh.triangles.len();
        assert!(count.abs_diff(wanted) * 50 <= wanted, "{name} has {count} triangles, not {wanted}");
    }
    let cornell = scene("cornell").mesh.triangles.len();
    assert!((300..=700).contains(&cornell), "cornell has {cornell}");
}

/// Triangles of connected solids, found by joining corners at the same place within an object;
/// `which` picks materials. A vessel and what is in it are two objects and one solid.
fn solids(scene: &Scene, which: impl Fn(Optics) -> bool) -> Vec<(String, Vec<[Vec3; 3]>)> {
    let mut by_object: Vec<Vec<[Vec3; 3]>> = vec![Vec::new(); scene.objects.len()];
    for t in scene.mesh.triangles.iter().filter(|t| which(scene.materials[t.material as usize].optics)) {
        by_object[t.object as usize].push(t.vertices.map(|v| scene.mesh.positions[v as usize]));
    }
    let mut groups: Vec<(String, Vec<[Vec3; 3]>)> = Vec::new();
    for (object, name) in scene.objects.iter().enumerate().filter(|(_, name)| !name.ends_with(": liquid")) {
        let liquid = format!("{name}: liquid");
        let liquid = scene.objects.iter().position(|other| *other == liquid).unwrap_or(object);
        let mut triangles = std::mem::take(&mut by_object[object]);
        if liquid != object {
            triangles.append(&mut by_object[liquid]);
        }
        let mut parent: Vec<usize> = (0..triangles.len()).collect();
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        let mut first: BTreeMap<[u32; 3], usize> = BTreeMap::new();
        for (i, triangle) in triangles.iter().enumerate() {
            for corner in triangle {
                let other = *first.entry(key(*corner)).or_insert(i);
                let (a, b) = (root(&mut parent, i), root(&mut parent, other));
                parent[a] = b;
            }
        }
        let mut parts: BTreeMap<usize, Vec<[Vec3; 3]>> = BTreeMap::new();
        for (i, triangle) in triangles.iter().enumerate() {
            parts.entry(root(&mut parent, i)).or_default().push(*triangle);
        }
        groups.extend(parts.into_values().map(|p| (name.clone(), p)));
    }
    groups
}

/// A place, bit by bit; -0 is 0.
fn key(p: Vec3) -> [u32; 3] {
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// Edges that are not shared by exactly two triangles in opposite directions.
fn open_edges(triangles: &[[Vec3; 3]]) -> usize {
    let mut edges: BTreeMap<([u32; 3], [u32; 3]), i32> = BTreeMap::new();
    for t in triangles {
        for k in 0..3 {
            *edges.entry((key(t[k]), key(t[(k + 1) % 3]))).or_default() += 1;
        }
    }
    edges.iter().filter(|((a, b), count)| **count != 1 || edges.get(&(*b, *a)) != Some(&1)).count()
}

fn volume(triangles: &[[Vec3; 3]]) -> f64 {
    triangles.iter().map(|t| t.map(|p| p.as_dvec3())).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

#[test]
fn glass_is_closed_and_faces_outwards() {
    for name in builtin_names() {
        let scene = scene(name);
        let glass = solids(scene, |o| o == Optics::Dielectric);
        assert!(!glass.is_empty(), "{name} has no glass");
        for (object, triangles) in glass {
            assert_eq!(
                open_edges(&triangles),
                0,
                "{name}: `{object}` has open edges in a solid of {} triangles",
                triangles.len()
            );
            assert!(volume(&triangles) > 0.0, "{name}: `{object}` is inside out");
        }
    }
}

#[test]
fn chess_has_32_closed_pieces() {
    let scene = scene("chess");
    let pieces = solids(scene, |_| true);
    let named = |side: &str| scene.objects.iter().filter(|n| n.starts_with(side)).count();
    assert_eq!((named("glass "), named("ebony "), named("square ")), (16, 16, 64));
    for (object, triangles) in pieces.iter().filter(|(n, _)| n.starts_with("ebony ") || n.starts_with("glass ")) {
        assert_eq!(open_edges(triangles), 0, "`{object}`");
        assert!(volume(triangles) > 0.0, "`{object}` is inside out");
    }
}

#[test]
fn the_teapot_faces_outwards() {
    let scene = scene("teapot");
    let pot: Vec<_> =
        solids(scene, |o| o == Optics::FresnelMirror).into_iter().filter(|(n, _)| n == "teapot").collect();
    assert!(pot.len() >= 4, "lid, body, handle and spout are separate solids");
    for (_, triangles) in pot {
        // None of them is closed, so the volume is taken about the middle of each.
        let corners = triangles.iter().flatten();
        let middle = corners.clone().sum::<Vec3>() / corners.count() as f32;
        let moved: Vec<_> = triangles.iter().map(|t| t.map(|p| p - middle)).collect();
        // The ring between lid and rim is flat: its volume is nothing.
        assert!(volume(&moved) > -1e-3, "a part with {} triangles is inside out", moved.len());
    }
}

#[test]
fn each_scene_shows_shadows_reflections_and_refractions() {
    for name in builtin_names() {
        let scene = scene(name);
        let used = |o: Optics| scene.mesh.triangles.iter().any(|t| scene.materials[t.material as usize].optics == o);
        assert!(used(Optics::Dielectric) && (used(Optics::Mirror) || used(Optics::FresnelMirror)), "{name}");
        assert!(!scene.lights.is_empty(), "{name}");
        scene.validate().unwrap_or_else(|e| panic!("{e}"));
        if *name != "cornell" {
            assert!(scene.cameras.len() >= 60, "{name} has a path");
        }
    }
}

#[test]
fn normals_agree_with_the_faces() {
    for name in builtin_names() {
        let mesh = &scene(name).mesh;
        for t in &mesh.triangles {
            let [a, b, c] = t.vertices.map(|v| mesh.positions[v as usize].as_dvec3());
            let face = (b - a).cross(c - a).normalize();
            for v in t.vertices {
                let normal = mesh.normals[v as usize].as_dvec3();
                assert!(
                    (normal.length() - 1.0).abs() < 1e-5 && normal.dot(face) > 0.2,
                    "{name}: normal {normal} on face {face}"
                );
            }
        }
    }
}

#[test]
fn hashes_are_stable_and_see_one_vertex() {
    for name in builtin_names() {
        let (first, mut second) = (scene(name), generate(name));
        assert_eq!(first.content_hash(), second.content_hash(), "{name}");
        second.mesh.positions[7].x = f32::from_bits(second.mesh.positions[7].x.to_bits() ^ 1);
        assert_ne!(first.content_hash(), second.content_hash(), "{name}");
        let mut renamed = first.clone();
        renamed.name = "other".into();
        renamed.materials[0].name = "other".into();
        assert_eq!(first.content_hash(), renamed.content_hash(), "names are no content");
    }
}

/// Golden traces hang on these bytes: a change here is a change of the scene, on purpose or not.
#[test]
fn built_in_scenes_are_the_same_everywhere() {
    for (name, wanted) in HASHES {
        let hash: String = scene(name).content_hash().iter().map(|b| format!("{b:02x}")).collect();
        assert_eq!(hash, wanted, "{name} has changed");
    }
}

/// The pictures of frame A and of frame A plus one belong together: no jump in the path.
#[test]
fn orbits_are_closed_and_smooth() {
    for name in ["teapot", "chess", "car"] {
        let cameras = &scene(name).cameras;
        let steps: Vec<f32> =
            (0..cameras.len()).map(|i| (cameras[i].eye - cameras[(i + 1) % cameras.len()].eye).length()).collect();
        let (low, high) = steps.iter().fold((f32::MAX, 0.0_f32), |(l, h), s| (l.min(*s), h.max(*s)));
        assert!(high < 1.2 * low, "{name}: steps from {low} to {high}");
    }
}
