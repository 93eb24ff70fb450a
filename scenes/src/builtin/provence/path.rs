//! The flight: 700 frames round the farm and back to where it began.

use glam::{DVec2, DVec3, Vec3};

use crate::{builtin::provence::land, modelling::part::sin_cos, scene::Camera};

/// Frames of the flight.
pub const FRAMES: usize = 700;

/// A place of the flight: frame, eye (height over the ground), target (height over the ground),
/// vertical field of view.
type Key = (usize, [f64; 3], [f64; 3], f64);

/// Frame 0 is the hero view.
const KEYS: [Key; 16] = [
    (0, [-6.6, 3.2, 55.0], [-1.0, 0.6, 8.0], 32.0),
    (50, [-7.2, 2.5, 47.0], [-2.0, 0.9, 8.0], 34.0),
    (100, [-7.4, 2.0, 37.0], [-3.0, 1.6, 4.0], 37.0),
    (150, [-5.6, 1.9, 26.5], [1.5, 2.0, 2.0], 41.0),
    (200, [-4.0, 1.7, 19.5], [6.0, 1.6, 3.0], 42.0),
    (250, [-0.8, 1.6, 15.0], [-4.5, 2.4, 2.0], 42.0),
    (300, [-2.6, 1.65, 10.8], [-6.0, 2.3, 3.0], 42.0),
    (340, [1.6, 1.75, 9.4], [-4.0, 2.3, 3.0], 42.0),
    (400, [9.4, 1.30, 22.0], [1.5, 1.1, 2.0], 44.0),
    (440, [14.3, 1.7, 25.2], [24.0, 1.5, 19.0], 43.0),
    (470, [17.6, 1.8, 31.0], [26.0, 1.5, 37.0], 43.0),
    (500, [17.4, 2.0, 41.0], [16.0, 1.2, 56.0], 42.0),
    (540, [14.6, 2.4, 53.5], [5.0, 0.9, 66.0], 41.0),
    (570, [15.0, 3.0, 62.0], [-4.0, 0.4, 56.0], 39.0),
    (600, [15.2, 3.4, 67.5], [9.0, 0.8, 40.0], 37.0),
    (650, [4.0, 4.4, 68.0], [-1.0, 0.3, 12.0], 34.0),
];

/// The cameras of the flight.
#[must_use]
pub fn cameras() -> Vec<Camera> {
    (0..FRAMES).map(camera).collect()
}

/// Where the flight passes over the ground.
#[must_use]
pub fn eyes() -> Vec<DVec2> {
    (0..FRAMES).step_by(5).map(|frame| pose(frame).eye).map(|eye| DVec2::new(eye.x, eye.z)).collect()
}

/// Distance of a place from the flight, both seen from above.
#[must_use]
pub fn distance(eyes: &[DVec2], x: f64, z: f64) -> f64 {
    eyes.iter().map(|eye| (*eye - DVec2::new(x, z)).length_squared()).fold(f64::MAX, f64::min).sqrt()
}

/// Place and direction of a camera: turn from north to east, rise, field of view, all in degrees.
#[derive(Clone, Copy, Debug)]
struct Pose {
    eye: DVec3,
    angles: DVec3,
}

impl Pose {
    fn of(key: &Key) -> Self {
        let place = |p: [f64; 3]| land::ground(p[0], p[2]) + DVec3::Y * p[1];
        let (eye, to) = (place(key.1), place(key.2));
        let way = to - eye;
        let turn = libm::atan2(way.x, -way.z).to_degrees();
        let rise = libm::atan2(way.y, libm::hypot(way.x, way.z)).to_degrees();
        Self { eye, angles: DVec3::new(turn, rise, key.3) }
    }
}

/// Key number `k`, counted round and round the closed flight, with its frame; its turn is moved by whole turns to lie
/// near `turn`.
fn key(k: usize, turn: f64) -> (f64, Pose) {
    let (round, k) = (k / KEYS.len(), k % KEYS.len());
    let mut pose = Pose::of(&KEYS[k]);
    pose.angles.x += 360.0 * libm::round((turn - pose.angles.x) / 360.0);
    ((KEYS[k].0 + FRAMES * round) as f64, pose)
}

/// A smooth curve through the keys. Directions are interpolated, not targets: on its way between two
/// targets a point may pass close by the eye, and the view would whirl.
fn pose(frame: usize) -> Pose {
    let k = KEYS.iter().rposition(|k| k.0 <= frame).unwrap_or(0) + KEYS.len();
    let now = (frame + FRAMES) as f64;
    let (t0, a) = key(k, 0.0);
    let (before, z) = key(k - 1, a.angles.x);
    let (t1, b) = key(k + 1, a.angles.x);
    let (after, c) = key(k + 2, b.angles.x);
    let t = (now - t0) / (t1 - t0);
    let (t2, t3) = (t * t, t * t * t);
    let mix = |pick: fn(&Pose) -> DVec3| {
        let m0 = (pick(&b) - pick(&z)) * ((t1 - t0) / (t1 - before));
        let m1 = (pick(&c) - pick(&a)) * ((t1 - t0) / (after - t0));
        pick(&a) * (2.0 * t3 - 3.0 * t2 + 1.0)
            + m0 * (t3 - 2.0 * t2 + t)
            + pick(&b) * (3.0 * t2 - 2.0 * t3)
            + m1 * (t3 - t2)
    };
    Pose { eye: mix(|p| p.eye), angles: mix(|p| p.angles) }
}

fn camera(frame: usize) -> Camera {
    let Pose { eye, angles } = pose(frame);
    let (sin, cos) = sin_cos(angles.x.to_radians());
    let (rise, flat) = sin_cos(angles.y.to_radians());
    let target = eye + DVec3::new(sin * flat, rise, -cos * flat) * 10.0;
    Camera { eye: eye.as_vec3(), target: target.as_vec3(), up: Vec3::Y, vfov_deg: angles.z as f32 }
}
