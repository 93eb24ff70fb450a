//! No ray leaves a closed mesh without a hit: not in any direction, not at the middle of an edge, not at any point of
//! one.
//!
//! Edge tests agree between the two triangles of an edge, but not all round a vertex: of the rays aimed at the very
//! corner of a mesh, to the last bit, a few in a thousand find every edge on its wrong side and slip through. The
//! test bounds their number.

mod support;

use std::collections::HashMap;

use rayon::prelude::*;
use rayreel_formats::intersect::intersect;
use rayreel_formats::math::{Vec3, vec3};
use rayreel_formats::rays::Ray;
use rayreel_scenes::{Mesh, Scene};
use rayreel_tracer::build;
use rayreel_tracer::traverse::{TraversalBvh, TraversalScratch};
use support::{Draws, Random, builtin};

const RAYS: usize = 100_000;
const ORIGINS: usize = 500;

/// One object of a scene, alone.
fn alone(scene: &Scene, object: u32) -> Scene {
    let triangles = scene.mesh.triangles.iter().filter(|t| t.object == object).copied().collect();
    Scene { mesh: Mesh { triangles, ..scene.mesh.clone() }, ..scene.clone() }
}

/// The corners of all triangles of area.
fn corners(scene: &Scene) -> Vec<[Vec3; 3]> {
    let position = |v: u32| Vec3::from(scene.mesh.positions[v as usize].to_array());
    scene.mesh.triangles.iter().map(|t| t.vertices.map(position)).collect()
}

/// Every edge, by the bits of its ends, has as many triangles on one side as on the other.
fn is_closed(corners: &[[Vec3; 3]]) -> bool {
    let bits = |v: Vec3| v.to_array().map(|x| (x + 0.0).to_bits());
    let mut balance: HashMap<_, i32> = HashMap::new();
    for c in corners {
        for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (bits(c[i]), bits(c[j]))) {
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    balance.values().all(|&sum| sum == 0)
}

/// How often the surface winds round a point: the sum of solid angles, in `f64`.
fn winding(corners: &[[Vec3; 3]], point: Vec3) -> f64 {
    let solid_angle = |corners: &[Vec3; 3]| {
        let [a, b, c] = corners.map(|p| (p - point).to_array().map(f64::from));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let length = |a: [f64; 3]| dot(a, a).sqrt();
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let (la, lb, lc) = (length(a), length(b), length(c));
        2.0 * f64::atan2(dot(a, cross), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    };
    corners.iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// In any direction, along an axis, at a point of an edge, and one in eight at a vertex; true for those.
fn direction(random: &mut Random, corners: &[[Vec3; 3]], origin: Vec3) -> (Vec3, bool) {
    let triangle = corners[random.index(corners.len())];
    let side = random.index(3);
    let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
    let axes = [vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0), vec3(0.0, 0.0, 1.0), vec3(-0.0, 1.0, -0.0)];
    let kind = random.index(8);
    let towards = match kind {
        0 => axes[random.index(4)],
        1 => (a - origin).normalized(),
        2 | 3 => ((a + b) * 0.5 - origin).normalized(),
        4 | 5 => (a + (b - a) * random.range(0.01, 0.99) - origin).normalized(),
        _ => random.direction(),
    };
    (towards, kind == 1)
}

fn assert_watertight(name: &str, scene: &Scene) {
    let corners = corners(scene);
    assert!(is_closed(&corners), "{name} is not closed: choose another object");
    let built = build(scene).unwrap_or_else(|e| panic!("{name}: {e}"));
    let traversal = TraversalBvh::new(&built.bvh);
    let bounds = built.bvh.bounds();
    let mut random = Random(1);
    let mut inside = Vec::new();
    for _ in 0..20_000 {
        let point = random.point(bounds.min, bounds.max);
        if inside.len() < ORIGINS && winding(&corners, point).abs() > 0.99 {
            inside.push(point);
        }
    }
    assert!(inside.len() > 50, "{name}: {} points inside", inside.len());
    let run = |scratch: &mut TraversalScratch, seed: usize| {
        let mut random = Random((seed as u64) << 20);
        let origin = inside[seed % inside.len()];
        let (direction, at_vertex) = direction(&mut random, &corners, origin);
        let ray = Ray { origin, direction, t_max: f32::MAX };
        let hit = traversal.closest_hit::<false>(&ray, scratch, |_, _, _| false);
        let any = traversal.any_hit::<false>(&ray, scratch, |_, _, _| false).is_some();
        // What the BVH loses is never forgiven.
        let lost = || corners.iter().any(|&c| intersect(&ray, c, ray.t_max).is_some());
        (hit.is_none() || !any).then(|| (ray, at_vertex && !lost()))
    };
    let escaped: Vec<(Ray, bool)> =
        (0..RAYS).into_par_iter().map_init(TraversalScratch::default, run).flatten().collect();
    let (at_vertex, others): (Vec<_>, Vec<_>) = escaped.into_iter().partition(|&(_, at_vertex)| at_vertex);
    let (triangles, points, slips) = (corners.len(), inside.len(), at_vertex.len());
    eprintln!("{name}: {triangles} triangles, {points} points inside, {} escapes, {slips} at vertices", others.len());
    assert!(others.is_empty(), "{name}: {} rays escape, such as {:?}", others.len(), others[0]);
    assert!(slips < RAYS / 8 / 100, "{name}: {slips} of {} rays at vertices escape", RAYS / 8);
}

fn assert_object(scene: &Scene, name: &str) {
    let object = scene.objects.iter().position(|o| o == name);
    let object = object.unwrap_or_else(|| panic!("no {name} among {:?}", scene.objects));
    assert_watertight(name, &alone(scene, object as u32));
}

#[test]
fn the_glass_sphere_of_the_cornell_box() {
    assert_object(&builtin("cornell"), "glass sphere");
}

#[test]
fn six_closed_glass_chess_pieces() {
    let scene = builtin("chess");
    let glass = scene.objects.iter().enumerate().filter(|(_, name)| name.starts_with("glass"));
    let pieces = glass.map(|(object, name)| (name, alone(&scene, object as u32)));
    let closed: Vec<_> = pieces.filter(|(_, piece)| is_closed(&corners(piece))).take(6).collect();
    assert_eq!(closed.len(), 6, "closed glass pieces among {:?}", scene.objects);
    closed.iter().for_each(|(name, piece)| assert_watertight(name, piece));
}
