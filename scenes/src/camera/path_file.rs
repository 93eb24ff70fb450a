//! Camera paths from CSV files.

use std::path::Path;

use glam::Vec3;
use rayreel_settings::files;

use crate::{
    error::{Location, SceneError},
    scene::Camera,
    validate::check_camera,
};

/// The header that a camera path must have.
pub const PATH_HEADER: &str = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,up_x,up_y,up_z,vfov_deg";

/// Reads a camera path: one row per frame, frame numbers rising by one. Whatever the first number, it is frame 0 of the scene.
///
/// # Errors
/// A header, number or camera that cannot be used, with its line.
pub fn read_path(path: &Path) -> Result<Vec<Camera>, SceneError> {
    read_numbered(path).map(|(_, cameras)| cameras)
}

/// As [`read_path`], with the number of the first row.
pub(crate) fn read_numbered(path: &Path) -> Result<(u64, Vec<Camera>), SceneError> {
    let text = files::read_text(path, files::TEXT_MAX).map_err(|source| SceneError::Io {
        path: path.to_owned(),
        what: "camera path",
        source,
    })?;
    let bad = |line, what: String, fix: &str| SceneError::input(Location::line(path, line), what, fix);
    let mut lines =
        text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let (line, header) = lines.next().unwrap_or((1, ""));
    if !is_header(header) {
        let fix = format!("the first line must be {PATH_HEADER}");
        return Err(bad(line, "this is not the header of a camera path".into(), &fix));
    }
    let mut cameras = Vec::new();
    let mut last: Option<u64> = None;
    for (line, row) in lines {
        let (frame, camera) = parse_row(row).map_err(|(what, fix)| bad(line, what, fix))?;
        if let Some(last) = last.filter(|last| last.checked_add(1) != Some(frame)) {
            return Err(bad(line, format!("frame {frame} follows frame {last}"), "frame numbers rise by one"));
        }
        check_camera(&camera, || Location::line(path, line))?;
        last = Some(frame);
        cameras.push(camera);
    }
    match last {
        Some(last) => Ok((last - (cameras.len() as u64 - 1), cameras)),
        None => Err(bad(1, "the camera path has no frame".into(), "add at least one row")),
    }
}

/// Whether a line is the header, up to blanks round the names and a byte order mark.
fn is_header(line: &str) -> bool {
    let names = line.trim_start_matches('\u{feff}').split(',').map(str::trim);
    names.eq(PATH_HEADER.split(','))
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
