//! Secondary rays against the laws of optics in `f64`, and primary rays against a pinhole camera in `f64`.

mod support;

use glam::{DVec3, Vec3 as GlamVec3};
use rayreel_formats::math::{Vec3, vec3};
use rayreel_formats::oct::Oct;
use rayreel_formats::rays::{self, Ray, Surface};
use rayreel_formats::scene::{Light, Material, Optics};
use rayreel_scenes::Camera;
use rayreel_tracer::convert;
use support::Random;

const CASES: u64 = 200_000;

fn wide(v: Vec3) -> DVec3 {
    DVec3::from(v.to_array().map(f64::from))
}

/// A ray that meets a random triangle of ordinary shape somewhere inside, and its surface there; `bend` is how far
/// shading normals lean away from the face.
fn meeting(random: &mut Random, bend: f32) -> (Ray, Surface) {
    loop {
        let scale = [0.01, 1.0, 300.0][random.below(3)];
        let one = Vec3::splat(scale);
        let corners = [(); 3].map(|()| random.point(-one, one));
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        if normal.length() < 0.1 * scale * scale {
            continue;
        }
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let target = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
        let origin = random.point(one * -3.0, one * 3.0);
        let ray = Ray { origin, direction: (target - origin).normalized(), t_max: f32::MAX };
        let sine = ray.direction.dot(normal.normalized()).abs();
        let t = (target - origin).length();
        if sine < 0.02 || t < scale * 0.05 {
            continue;
        }
        let shading = normal.normalized() + random.direction() * bend;
        return (ray, rays::surface(&ray, t, corners, Oct::encode(shading)));
    }
}

fn material(random: &mut Random) -> Material {
    Material {
        name: String::new(),
        optics: Optics::Dielectric,
        ior: random.range(1.01, 2.6),
        specular: Vec3::ONE,
        transmission: Vec3::ONE,
        cutout: false,
    }
}

/// The surface faces the ray, and its frame is of unit length.
#[test]
fn surfaces_face_the_ray() {
    for seed in 0..CASES {
        let (ray, s) = meeting(&mut Random(seed), 0.8);
        assert!(s.face.dot(ray.direction) < 0.0 && s.normal.dot(ray.direction) < 0.0, "seed {seed}: {s:?}");
        assert!((s.face.length() - 1.0).abs() < 1e-5 && (s.normal.length() - 1.0).abs() < 1e-5, "seed {seed}");
        assert!(s.cosine > 0.0 && s.cosine <= 1.0 + 1e-6 && s.offset > 0.0, "seed {seed}: {s:?}");
    }
}

/// Angle of incidence is angle of reflection, in one plane; with bent normals at least the ray leaves on the side it
/// came from.
#[test]
fn reflections_obey_the_law_and_leave_on_the_near_side() {
    for seed in 0..CASES {
        let bend = if seed % 2 == 0 { 0.0 } else { 0.8 };
        let (ray, s) = meeting(&mut Random(seed), bend);
        let out = rays::reflection(&s, ray.direction);
        let d = out.direction;
        assert!((d.length() - 1.0).abs() < 1e-5 && d.dot(s.face) > 0.0, "seed {seed}: {out:?} at {s:?}");
        assert!((wide(out.origin) - wide(s.point)).dot(wide(s.face)) > 0.0, "seed {seed}: starts behind the surface");
        let law = |n: DVec3| (wide(ray.direction) - 2.0 * wide(ray.direction).dot(n) * n - wide(d)).length();
        let error = law(wide(s.normal).normalize()).min(law(wide(s.face).normalize()));
        assert!(error < 1e-5, "seed {seed}: off by {error}");
    }
}

/// What Snell's law gives in `f64`: the direction, or `None` at total reflection; `k` is the squared cosine on the
/// far side.
fn snell(direction: DVec3, normal: DVec3, eta: f64) -> (f64, DVec3) {
    let cosine = -direction.dot(normal);
    let k = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (k, direction * eta + normal * (eta * cosine - k.max(0.0).sqrt()))
}

#[test]
fn refractions_obey_snell_and_leave_on_the_far_side() {
    let (mut bent, mut total) = (0, 0);
    for seed in 0..CASES {
        let random = &mut Random(seed);
        let (ray, s) = meeting(random, if seed % 2 == 0 { 0.0 } else { 0.8 });
        let material = material(random);
        let eta = if s.front { 1.0 / f64::from(material.ior) } else { f64::from(material.ior) };
        let law = |n: Vec3| snell(wide(ray.direction).normalize(), wide(n).normalize(), eta);
        let (near, face) = (law(s.normal), law(s.face));
        let children = rays::children(&s, ray.direction, &material);
        let refracted = rays::refraction(&s, ray.direction, material.ior);
        assert_eq!(children.refract.is_some(), refracted.is_some(), "seed {seed}: {s:?} of {}", material.ior);
        assert!(children.reflect.is_some(), "seed {seed}: a dielectric always reflects");
        let Some(out) = refracted else {
            // Total, by the shading normal, or by the face normal where that takes over.
            assert!(near.0 < 1e-5 || face.0 < 1e-5, "seed {seed}: k {} and {}", near.0, face.0);
            total += 1;
            continue;
        };
        let d = wide(out.direction);
        assert!((d.length() - 1.0).abs() < 1e-5 && out.direction.dot(s.face) < 0.0, "seed {seed}: {out:?} at {s:?}");
        assert!((wide(out.origin) - wide(s.point)).dot(wide(s.face)) < 0.0, "seed {seed}: starts before the surface");
        // Near the critical angle the cosine is the root of a difference: its error grows as 1 / cosine.
        let off = |(k, want): (f64, DVec3)| (want - d).length() * k.max(1e-6).sqrt();
        let error = off(near).min(off(face));
        assert!(error < 1e-5, "seed {seed}: off by {error}, k {} and {}", near.0, face.0);
        bent += 1;
    }
    assert!(bent > CASES / 3 && total > CASES / 20, "{bent} refractions, {total} total reflections");
}

fn fresnel(cosine: f64, far: f64, eta: f64) -> f64 {
    let s = (eta * cosine - far) / (eta * cosine + far);
    let p = (cosine - eta * far) / (cosine + eta * far);
    (s * s + p * p) / 2.0
}

/// Fresnel's equations within 1e-5, but for the rounding of a half float; reflected and refracted parts are one.
#[test]
fn weights_are_those_of_fresnel() {
    for seed in 0..CASES {
        let random = &mut Random(seed);
        let (ray, s) = meeting(random, 0.4);
        let material = material(random);
        let eta = if s.front { 1.0 / f64::from(material.ior) } else { f64::from(material.ior) };
        let children = rays::children(&s, ray.direction, &material);
        let weight = |h: rayreel_formats::half::Half3| f64::from(h.to_vec3().x);
        let reflect = weight(children.reflect.expect("a dielectric always reflects"));
        assert!((0.0..=1.0).contains(&reflect), "seed {seed}: {reflect}");
        let Some(refract) = children.refract.map(weight) else {
            assert!(reflect >= 1.0, "seed {seed}: total reflection of {reflect}");
            continue;
        };
        assert!((0.0..=1.0).contains(&refract) && (reflect + refract - 1.0).abs() < 2e-3, "seed {seed}");
        let cosine = f64::from(s.cosine);
        let k = 1.0 - eta * eta * (1.0 - cosine * cosine);
        // The far cosine carries the rounding of k, magnified near the critical angle.
        let slack = 1e-5 + 3e-7 * eta * eta * 4.0 / k.max(1e-6).sqrt();
        let want = fresnel(cosine, k.max(0.0).sqrt(), eta);
        let error = (want - reflect).abs() - want / 2048.0;
        assert!(error < slack, "seed {seed}: {reflect}, want {want}, k {k}");
    }
}

#[test]
fn shadow_rays_start_above_the_surface_and_end_at_the_light() {
    for seed in 0..CASES {
        let random = &mut Random(seed);
        let (_, s) = meeting(random, 0.4);
        let reach = Vec3::splat(s.point.max_abs() * 4.0);
        let position = random.point(-reach, reach);
        let point = rays::shadow(&s, &Light::Point { position, colour: Vec3::ONE });
        let end = wide(point.origin) + wide(point.direction) * f64::from(point.t_max);
        let error = (end - wide(position)).length() / f64::from(reach.x);
        assert!(error < 1e-6, "seed {seed}: ends {error} off the light");
        let to_light = random.direction();
        let sun = rays::shadow(&s, &Light::Directional { to_light, colour: Vec3::ONE });
        assert_eq!((sun.direction, sun.t_max, sun.origin), (to_light, f32::MAX, point.origin), "seed {seed}");
        let height = (wide(sun.origin) - wide(s.point)).dot(wide(s.face));
        assert!(height > 0.0, "seed {seed}: starts {height} above the surface");
    }
}

/// A camera that sees the point `target` of a random picture through sample (x, y), worked out backwards in `f64`.
#[test]
fn primary_rays_hit_their_pixels() {
    for seed in 0..CASES / 10 {
        let random = &mut Random(seed);
        let glam = |v: Vec3| GlamVec3::from(v.to_array());
        let eye = random.point(Vec3::splat(-50.0), Vec3::splat(50.0));
        let forward = random.direction();
        let up = random.direction();
        if forward.cross(up).length() < 0.05 {
            continue;
        }
        let target = eye + forward * random.range(0.5, 100.0);
        let vfov_deg = random.range(5.0, 120.0);
        let camera = Camera { eye: glam(eye), target: glam(target), up: glam(up), vfov_deg };
        let rows = 1 + random.below(2048);
        let (columns, rows) = (1 + random.below(3 * rows) as u32, rows as u32);
        let (x, y) = (random.below(columns as usize) as u32, random.below(rows as usize) as u32);
        let ray = rays::primary(&convert::camera(&camera, columns, rows), x, y);
        // The ray's direction in the camera's frame, which looks along -z.
        let back = (wide(eye) - wide(target)).normalize();
        let right = wide(up).cross(back).normalize();
        let seen = DVec3::from([right, back.cross(right), back].map(|axis| axis.dot(wide(ray.direction))));
        let focal = 1.0 / (f64::from(vfov_deg).to_radians() / 2.0).tan();
        let (height, width) = (f64::from(rows), f64::from(columns));
        let across = (seen.x / -seen.z * focal * height / width + 1.0) * width / 2.0;
        let down = (1.0 - seen.y / -seen.z * focal) * height / 2.0;
        let error = (across - f64::from(x) - 0.5).abs().max((down - f64::from(y) - 0.5).abs());
        assert!(error < 0.02, "seed {seed}: sample {x}, {y} of {columns} x {rows} is at {across}, {down}");
        assert_eq!((ray.origin, ray.t_max), (eye, f32::MAX));
    }
    let square = Camera { eye: GlamVec3::ZERO, target: GlamVec3::NEG_Z, up: GlamVec3::Y, vfov_deg: 90.0 };
    let first = rays::primary(&convert::camera(&square, 2, 2), 0, 0).direction;
    assert!((first - vec3(-0.5, 0.5, -1.0).normalized()).length() < 1e-6, "the first sample is the top left one");
}
