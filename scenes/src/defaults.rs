//! What a scene gets when its file says nothing: camera, lights and sky.

use glam::{DVec3, Vec3};

use crate::scene::{Camera, Light, Sky};

/// Vertical field of view where none is given, degrees.
pub const DEFAULT_VFOV_DEG: f32 = 35.0;
/// Ambient fraction where none is given.
pub const DEFAULT_AMBIENT: f32 = 0.35;

/// Centre and radius of the sphere around a box; the radius of a single point is one, so that there
/// is something to stand back from.
fn sphere((low, high): (Vec3, Vec3)) -> (DVec3, f64) {
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let radius = (high - low).length() / 2.0;
    ((low + high) / 2.0, if radius > 0.0 { radius } else { 1.0 })
}

/// A camera from the front, the right and above that has the whole box in view. Y is up.
pub(crate) fn framing_camera(bounds: (Vec3, Vec3), vfov_deg: f32) -> Camera {
    let (centre, radius) = sphere(bounds);
    let half = f64::from(vfov_deg).to_radians() / 2.0;
    let distance = radius / libm::sin(half.clamp(0.02, 1.5));
    let towards = DVec3::new(0.5, 0.42, 0.76).normalize();
    Camera {
        eye: (centre + towards * distance).as_vec3(),
        target: centre.as_vec3(),
        up: Vec3::Y,
        vfov_deg,
    }
}

/// A warm key light from the right and a cool fill light from the left, as strong together as one.
pub(crate) fn two_lights(bounds: (Vec3, Vec3)) -> Vec<Light> {
    let (centre, radius) = sphere(bounds);
    let point = |x, y, z, colour| Light::Point {
        position: (centre + DVec3::new(x, y, z) * radius).as_vec3(),
        colour,
    };
    vec![
        point(1.8, 2.6, 1.6, Vec3::new(0.82, 0.79, 0.74)),
        point(-2.2, 1.9, 0.9, Vec3::new(0.31, 0.34, 0.38)),
    ]
}

/// A soft blue sky over pale ground.
pub(crate) fn soft_sky() -> Sky {
    Sky {
        zenith: Vec3::new(0.25, 0.42, 0.72),
        horizon: Vec3::new(0.78, 0.84, 0.9),
        ground: Vec3::new(0.3, 0.28, 0.26),
        ambient: DEFAULT_AMBIENT,
    }
}

/// A gentle gradient around one colour: deeper above, paler at the horizon, darker below.
pub(crate) fn sky_around(colour: Vec3) -> Sky {
    Sky {
        zenith: colour * 0.75,
        horizon: colour * 0.6 + Vec3::splat(colour.max_element() * 0.4),
        ground: colour * 0.4,
        ambient: DEFAULT_AMBIENT,
    }
}
