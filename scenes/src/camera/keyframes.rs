//! Cameras between keyframes.

use glam::DVec3;

use crate::{scene::Camera, validate::is_direction};

/// More frames than anyone records; a typing error in a frame number must not fill the memory.
pub(crate) const MAX_FRAMES: u64 = 1_000_000;

/// A camera at a frame number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Keyframe {
    /// Frame number.
    pub frame: u64,
    /// The camera there.
    pub camera: Camera,
}

/// How cameras between keyframes are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Interpolation {
    /// Through the keyframes without a kink.
    #[default]
    CatmullRom,
    /// Straight from one to the next.
    Linear,
}

/// One camera per frame from the first keyframe to the last; `keys` has rising frame numbers and at
/// least one entry.
pub(crate) fn interpolate(keys: &[Keyframe], how: Interpolation) -> Vec<Camera> {
    let mut cameras = Vec::new();
    for (i, pair) in keys.windows(2).enumerate() {
        let around = [keys[i.saturating_sub(1)], pair[0], pair[1], keys[(i + 2).min(keys.len() - 1)]];
        for frame in pair[0].frame..pair[1].frame {
            cameras.push(between(&around, frame, how));
        }
    }
    cameras.extend(keys.last().map(|k| k.camera));
    cameras
}

fn between(around: &[Keyframe; 4], frame: u64, how: Interpolation) -> Camera {
    let [before, a, b, after] = around;
    let span = (b.frame - a.frame) as f64;
    let t = (frame - a.frame) as f64 / span;
    // Tangents per frame, so that unevenly spaced keyframes do not overshoot.
    let slope = |p: DVec3, q: DVec3, frames: u64| (q - p) * (span / frames.max(1) as f64);
    let mix = |get: &dyn Fn(&Camera) -> DVec3| {
        let [pa, pb] = [get(&a.camera), get(&b.camera)];
        if how == Interpolation::Linear {
            return pa + (pb - pa) * t;
        }
        let ma = slope(get(&before.camera), pb, b.frame - before.frame);
        let mb = slope(pa, get(&after.camera), after.frame - a.frame);
        let (t2, t3) = (t * t, t * t * t);
        pa * (2.0 * t3 - 3.0 * t2 + 1.0) + ma * (t3 - 2.0 * t2 + t) + pb * (3.0 * t2 - 2.0 * t3) + mb * (t3 - t2)
    };
    let up = mix(&|c| c.up.as_dvec3()).as_vec3();
    let vfov = mix(&|c| DVec3::splat(f64::from(c.vfov_deg))).x as f32;
    Camera {
        eye: mix(&|c| c.eye.as_dvec3()).as_vec3(),
        target: mix(&|c| c.target.as_dvec3()).as_vec3(),
        up: if is_direction(up) { up } else { a.camera.up },
        vfov_deg: vfov.clamp(a.camera.vfov_deg.min(b.camera.vfov_deg), a.camera.vfov_deg.max(b.camera.vfov_deg)),
    }
}
