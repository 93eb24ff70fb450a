//! Camera paths: from a CSV file, from keyframes, and round an object.

use std::path::Path;

use glam::{DVec3, Vec3};

use crate::{
    error::SceneError,
    scene::Camera,
    validate::{check_camera, is_direction},
};

/// The header that a camera path must have.
pub const PATH_HEADER: &str = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,up_x,up_y,up_z,vfov_deg";
/// More frames than anyone records; a typing error in a frame number must not fill the memory.
pub(crate) const MAX_FRAMES: u64 = 1_000_000;

/// A camera at a frame number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// Frame number.
    pub frame: u64,
    /// The camera there.
    pub camera: Camera,
}

/// How cameras between keyframes are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Through the keyframes without a kink.
    #[default]
    CatmullRom,
    /// Straight from one to the next.
    Linear,
}

/// Reads a camera path: one row per frame, frame numbers rising by one.
///
/// # Errors
/// A header, number or camera that cannot be used, with its line.
pub fn read_path(path: &Path) -> Result<Vec<Camera>, SceneError> {
    let text = std::fs::read_to_string(path).map_err(|source| SceneError::Io {
        path: path.to_owned(),
        what: "camera path",
        source,
    })?;
    let bad = |line, what, fix: &str| SceneError::Syntax { path: path.to_owned(), line, what, fix: fix.into() };
    let mut lines =
        text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let header: String = lines
        .next()
        .unwrap_or((1, ""))
        .1
        .trim_start_matches('\u{feff}')
        .split(',')
        .map(str::trim)
        .collect::<Vec<_>>()
        .join(",");
    if header != PATH_HEADER {
        return Err(bad(
            1,
            "this is not the header of a camera path".into(),
            &format!("the first line must be {PATH_HEADER}"),
        ));
    }
    let mut cameras = Vec::new();
    let mut last: Option<u64> = None;
    for (line, row) in lines {
        let (frame, camera) = parse_row(row).map_err(|(what, fix)| bad(line, what, fix))?;
        if last.is_some_and(|l| l.checked_add(1) != Some(frame)) {
            return Err(bad(
                line,
                format!("frame {frame} follows frame {}", last.unwrap_or(0)),
                "frame numbers rise by one",
            ));
        }
        check_camera(&camera, || format!("{}:{line}", path.display()))?;
        last = Some(frame);
        cameras.push(camera);
    }
    if cameras.is_empty() {
        return Err(bad(1, "the camera path has no frame".into(), "add at least one row"));
    }
    Ok(cameras)
}

fn parse_row(row: &str) -> Result<(u64, Camera), (String, &'static str)> {
    let fields: Vec<&str> = row.split(',').map(str::trim).collect();
    if fields.len() != 11 {
        return Err((format!("the row has {} fields", fields.len()), "a camera needs 11"));
    }
    let frame = fields[0].parse().map_err(|_| (format!("`{}` is no frame number", fields[0]), "use a whole number"))?;
    let mut n = [0.0_f32; 10];
    for (value, field) in n.iter_mut().zip(&fields[1..]) {
        *value = field
            .parse()
            .ok()
            .filter(|v: &f32| v.is_finite())
            .ok_or_else(|| (format!("`{field}` is no finite number"), "correct the number"))?;
    }
    let at = |i: usize| Vec3::new(n[i], n[i + 1], n[i + 2]);
    Ok((frame, Camera { eye: at(0), target: at(3), up: at(6), vfov_deg: n[9] }))
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

/// A full turn round the vertical axis through the hero camera's target; frame 0 is the hero camera
/// itself.
pub(crate) fn orbit(hero: Camera, frames: u32, lift: f64) -> Vec<Camera> {
    let arm = (hero.eye - hero.target).as_dvec3();
    (0..frames)
        .map(|frame| {
            let angle = std::f64::consts::TAU * f64::from(frame) / f64::from(frames);
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            // Half a turn away the camera stands `lift` higher, so that the far side is not all
            // shadow and table edge.
            let y = arm.y + lift * (1.0 - cos) / 2.0;
            let turned = DVec3::new(arm.x * cos + arm.z * sin, y, arm.z * cos - arm.x * sin);
            let eye = if frame == 0 { hero.eye } else { (hero.target.as_dvec3() + turned).as_vec3() };
            Camera { eye, ..hero }
        })
        .collect()
}
