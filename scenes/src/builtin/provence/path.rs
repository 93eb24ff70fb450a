//! The flight: 700 frames round the farm and back to where it began.

use glam::{DVec3, Vec3};

use crate::{builtin::provence::land, scene::Camera};

/// Frames of the flight.
pub const FRAMES: usize = 700;

/// A place of the flight: frame, eye (height over the ground), target (height over the ground),
/// vertical field of view.
type Key = (usize, [f64; 3], [f64; 3], f64);

/// Frame 0 is the hero view.
const KEYS: [Key; 14] = [
    (0, [-6.6, 3.3, 60.0], [-0.5, 0.2, 8.0], 31.0),
    (50, [-7.2, 2.5, 50.0], [-2.0, 0.9, 8.0], 33.0),
    (100, [-7.6, 1.9, 38.0], [-3.0, 1.6, 4.0], 36.0),
    (150, [-5.4, 1.9, 26.0], [1.5, 2.2, 2.0], 40.0),
    (200, [-3.4, 1.7, 19.5], [6.5, 1.6, 4.0], 42.0),
    (250, [0.5, 1.5, 15.0], [-4.5, 2.4, 2.0], 42.0),
    (300, [-2.6, 1.65, 10.6], [-7.0, 2.2, 3.0], 42.0),
    (340, [1.6, 1.8, 9.6], [-4.0, 2.4, 3.0], 42.0),
    (400, [9.2, 1.35, 21.8], [1.0, 1.2, 2.0], 44.0),
    (450, [16.5, 2.1, 24.0], [19.5, 1.4, 38.0], 42.0),
    (500, [20.8, 1.9, 31.0], [17.0, 1.2, 48.0], 42.0),
    (560, [16.3, 2.2, 49.0], [10.5, 0.9, 66.0], 40.0),
    (600, [14.6, 3.2, 63.0], [8.0, 1.0, 40.0], 38.0),
    (650, [2.4, 4.6, 70.0], [-1.0, 0.3, 12.0], 34.0),
];

/// The cameras of the flight.
#[must_use]
pub fn cameras() -> Vec<Camera> {
    (0..FRAMES).map(camera).collect()
}

fn camera(frame: usize) -> Camera {
    let count = KEYS.len();
    let i = KEYS.iter().rposition(|k| k.0 <= frame).unwrap_or(0);
    let value = |k: usize, pick: fn(&Key) -> DVec3| pick(&KEYS[k % count]);
    // Frame numbers go on rising across the seam of the loop.
    let when = |k: usize| (KEYS[k % count].0 + FRAMES * (k / count)) as f64;
    let k = i + count;
    let now = (frame + FRAMES) as f64;
    let mix = |pick: fn(&Key) -> DVec3| {
        let (t0, t1) = (when(k), when(k + 1));
        let slope = |k: usize| (value(k + 1, pick) - value(k - 1, pick)) * ((t1 - t0) / (when(k + 1) - when(k - 1)));
        let t = (now - t0) / (t1 - t0);
        let (t2, t3) = (t * t, t * t * t);
        value(k, pick) * (2.0 * t3 - 3.0 * t2 + 1.0)
            + slope(k) * (t3 - 2.0 * t2 + t)
            + value(k + 1, pick) * (3.0 * t2 - 2.0 * t3)
            + slope(k + 1) * (t3 - t2)
    };
    let eye = mix(|k| land::ground(k.1[0], k.1[2]) + DVec3::Y * k.1[1]);
    let target = mix(|k| land::ground(k.2[0], k.2[2]) + DVec3::Y * k.2[1]);
    let fov = mix(|k| DVec3::splat(k.3)).x;
    Camera { eye: eye.as_vec3(), target: target.as_vec3(), up: Vec3::Y, vfov_deg: fov as f32 }
}
