//! Traversal against a loop over all triangles: the closest hit has the same `t` to the last bit, and any-hit agrees
//! on whether there is a hit at all.
//!
//! Bare loops over 430,000 triangles are too slow, so triangles are put into groups, and a group is left out where
//! the ray's line stays clear of a generous sphere around it. That cull is checked against the bare loop on some rays
//! of every scene. Normally scenes above [`SMALL`] triangles get fewer rays; `RAYREEL_LONG=1` gives every scene the
//! full [`RAYS`].

mod support;

use rayon::prelude::*;
use rayreel_formats::bvh::Aabb;
use rayreel_formats::intersect::intersect;
use rayreel_formats::math::{Vec3, vec3};
use rayreel_formats::rays::Ray;
use rayreel_scenes::Scene;
use rayreel_tracer::traverse::{TraversalBvh, TraversalScratch};
use rayreel_tracer::{Built, build};
use support::{Draws, Random, builtin, shared_models};

/// Rays per scene.
const RAYS: usize = 100_000;
/// Rays for scenes of more than [`SMALL`] triangles, unless RAYREEL_LONG is set.
const RAYS_ON_LARGE: usize = 10_000;
const SMALL: usize = 20_000;
/// Rays per scene that check the cull itself.
const RAYS_BARE: usize = 200;
/// Triangles in a group.
const GROUP: usize = 16;

/// All triangles in groups, each with a sphere around it.
struct Brute {
    corners: Vec<[Vec3; 3]>,
    /// Centre and squared radius per group.
    spheres: Vec<(Vec3, f32)>,
}

impl Brute {
    fn new(built: &Built) -> Self {
        let corners: Vec<[Vec3; 3]> = (0..built.bvh.triangles.len()).map(|t| built.bvh.corners(t)).collect();
        let sphere = |group: &[[Vec3; 3]]| {
            let Aabb { min, max } = group.iter().flatten().fold(Aabb::EMPTY, |b, &p| b.with(p));
            let (centre, half) = ((min + max) * 0.5, (max - min) * 0.5);
            (centre, half.dot(half))
        };
        let spheres = corners.chunks(GROUP).map(sphere).collect();
        Self { corners, spheres }
    }

    /// The smallest `t` below `ray.t_max` and its triangle, over the groups that `keep` keeps.
    fn closest(&self, ray: &Ray, keep: impl Fn(&Ray, Vec3, f32) -> bool) -> Option<(u32, f32)> {
        let mut best = None;
        let mut t_max = ray.t_max;
        for (group, &(centre, radius2)) in self.spheres.iter().enumerate() {
            if !keep(ray, centre, radius2) {
                continue;
            }
            let first = group * GROUP;
            for (i, &corners) in self.corners[first..].iter().take(GROUP).enumerate() {
                if let Some(hit) = intersect(ray, corners, t_max) {
                    t_max = hit.t;
                    best = Some(((first + i) as u32, hit.t));
                }
            }
        }
        best
    }
}

/// Whether the line of a ray of unit direction may touch a sphere. The slack, 0.3 % of the distance, is far above any
/// rounding of the intersection test or of this one.
fn near(ray: &Ray, centre: Vec3, radius2: f32) -> bool {
    let to = centre - ray.origin;
    let (along, length2) = (to.dot(ray.direction), to.dot(to));
    length2 - along * along <= 2.0 * radius2 + 1.0e-5 * length2
}

fn every(_: &Ray, _: Vec3, _: f32) -> bool {
    true
}

/// From inside or around the scene: anywhere, at a point of the bounds, at a vertex, at the middle of an edge. A
/// quarter of the rays run along one axis or in one of its planes, where slabs are degenerate.
fn random_ray(random: &mut Random, built: &Built) -> Ray {
    let Aabb { min, max } = built.bvh.bounds();
    let slack = (max - min) * random.range(0.0, 1.5);
    let origin = random.point(min - slack, max + slack);
    let corners = built.bvh.corners(random.index(built.bvh.triangles.len()));
    let side = random.index(3);
    let target = match random.index(4) {
        0 => origin + random.direction(),
        1 => random.point(min, max),
        2 => corners[side],
        _ => (corners[side] + corners[(side + 1) % 3]) * 0.5,
    };
    let (mut origin, mut to) = (origin, target - origin);
    if random.index(8) == 0 {
        // In the plane of two axes through the target, or along one of them.
        (to.x, origin.x) = (0.0, target.x);
        if random.index(2) == 0 {
            (to.z, origin.z) = (0.0, target.z);
        }
    }
    if to.length() <= 0.0 {
        to = vec3(0.0, 1.0, 0.0);
    }
    Ray { origin, direction: to.normalized(), t_max: f32::MAX }
}

/// What a ray that was checked came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Found {
    Hit,
    Miss,
    /// The BVH disagrees on a triangle seen edge-on.
    Excused,
}

/// Whether a hit at `t` lies outside of the triangle's box, by `f64` and with the box grown by the least that boxes are padded: 2^-20 of
/// the distance to their farthest corner. The ray is then seen to run nearly along the triangle, where rounding puts hits before the
/// box or beside it, as far off as it likes.
fn edge_on(ray: &Ray, corners: [Vec3; 3], t: f32) -> bool {
    let of = |v: Vec3| v.to_array().map(f64::from);
    let (o, d, [a, b, c]) = (of(ray.origin), of(ray.direction), corners.map(of));
    let low: [f64; 3] = std::array::from_fn(|i| a[i].min(b[i]).min(c[i]) - o[i]);
    let high: [f64; 3] = std::array::from_fn(|i| a[i].max(b[i]).max(c[i]) - o[i]);
    let pad = low.iter().chain(&high).fold(0.0_f64, |reach, v| reach.max(v.abs())) / 1_048_576.0;
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for i in 0..3 {
        let (from, to) = (low[i] - pad, high[i] + pad);
        if d[i] == 0.0 {
            if from > 0.0 || to < 0.0 {
                return true;
            }
            continue;
        }
        let (p, q) = (from / d[i], to / d[i]);
        (enter, leave) = (enter.max(p.min(q)), leave.min(p.max(q)));
    }
    // Half of what the traversal allows distances, for what itself rounds.
    enter > leave.min(f64::from(t) * (1.0 + 1.0 / 1_048_576.0))
}

/// What is wrong with one ray, if anything.
fn check(
    ray: &Ray,
    brute: &Brute,
    traversal: &TraversalBvh,
    scratch: &mut TraversalScratch,
    random: &mut Random,
) -> Result<Found, String> {
    let want = brute.closest(ray, near);
    let found = traversal.closest_hit::<false>(ray, scratch, |_, _, _| false).map(|hit| (hit.triangle, hit.t));
    let t = |hit: Option<(u32, f32)>| hit.map(|(_, t)| t.to_bits());
    if want.is_some_and(|(triangle, t)| edge_on(ray, brute.corners[triangle as usize], t)) {
        // The distance is wrong by itself; counted, and only few may be.
        return Ok(if t(want) == t(found) { Found::Hit } else { Found::Excused });
    }
    if t(want) != t(found) {
        let ulps = want.zip(found).map(|(a, b)| i64::from(b.1.to_bits()) - i64::from(a.1.to_bits()));
        return Err(format!("closest: brute force {want:?}, BVH {found:?}, {ulps:?} ulps, {ray:?}"));
    }
    // A shadow ray that ends before, at, or behind the closest hit, or somewhere else. Not closer behind it: on a
    // triangle seen nearly edge-on `t` can be so far off that the box, which is exact, starts behind the end of the
    // ray.
    let scale = [0.5, 1.0, 1.000_1, 2.0][random.index(4)];
    let t_max = want.map_or(random.unit() * 10.0, |(_, t)| t * scale);
    let short = Ray { t_max, ..*ray };
    let want_any = brute.closest(&short, near).is_some();
    let found_any = traversal.any_hit::<false>(&short, scratch, |_, _, _| false).is_some();
    if want_any != found_any {
        return Err(format!("any: brute force {want_any}, BVH {found_any}, {short:?}, closest {want:?}"));
    }
    Ok(if want.is_some() { Found::Hit } else { Found::Miss })
}

fn check_scene(name: &str, scene: &Scene) -> Vec<String> {
    let start = std::time::Instant::now();
    let built = build(scene).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (brute, traversal) = (Brute::new(&built), TraversalBvh::new(&built.bvh));
    for seed in 0..RAYS_BARE as u64 {
        let ray = random_ray(&mut Random(seed << 20), &built);
        assert_eq!(brute.closest(&ray, near), brute.closest(&ray, every), "{name}: the cull of this test, {ray:?}");
    }
    let small = brute.corners.len() <= SMALL || std::env::var_os("RAYREEL_LONG").is_some();
    let rays = if small { RAYS } else { RAYS_ON_LARGE };
    let run = |scratch: &mut TraversalScratch, seed: usize| {
        let mut random = Random((seed as u64) << 20);
        let ray = random_ray(&mut random, &built);
        check(&ray, &brute, &traversal, scratch, &mut random)
    };
    let results: Vec<_> = (0..rays).into_par_iter().map_init(TraversalScratch::default, run).collect();
    let count = |found| results.iter().filter(|r| **r == Ok(found)).count();
    let (hits, excused) = (count(Found::Hit), count(Found::Excused));
    let wrong: Vec<String> = results.into_iter().filter_map(Result::err).map(|e| format!("{name}: {e}")).collect();
    let (triangles, seconds) = (brute.corners.len(), start.elapsed().as_secs_f32());
    eprintln!(
        "{name}: {triangles} triangles, {rays} rays, {hits} hits, {excused} edge-on, {} wrong, {seconds:.1} s",
        wrong.len()
    );
    assert!(excused <= rays / 20_000, "{name}: {excused} rays disagree on triangles seen edge-on");
    assert!(hits > rays / 4, "{name}: rays that hit nothing show nothing");
    wrong
}

fn assert_none(wrong: &[String]) {
    let first: Vec<&String> = wrong.iter().take(20).collect();
    assert!(wrong.is_empty(), "{} mismatches: {first:#?}", wrong.len());
}

#[test]
fn built_in_scenes() {
    let wrong: Vec<String> =
        ["cornell", "teapot", "chess"].iter().flat_map(|name| check_scene(name, &builtin(name))).collect();
    assert_none(&wrong);
}

#[test]
fn shared_scenes() {
    let mut wrong = Vec::new();
    for path in shared_models() {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let scene = rayreel_scenes::load(&path.to_string_lossy()).unwrap_or_else(|e| panic!("{name}: {e}"));
        wrong.extend(check_scene(&name, &scene));
    }
    assert_none(&wrong);
}
