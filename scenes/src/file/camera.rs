//! The `[camera]` table of a scene file: one camera, a path file, or keyframes.

use std::path::{Path, PathBuf};

use glam::Vec3;
use serde::Deserialize;

use crate::{
    camera::{self, Interpolation, Keyframe, MAX_FRAMES},
    defaults,
    error::{Location, SceneError},
    file::value::{Triple, bad_value},
    scene::Camera,
    validate::check_camera,
    view::View,
    warnings::Warning,
};

/// `[camera]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraTable {
    eye: Option<Triple>,
    target: Option<Triple>,
    up: Option<Triple>,
    vfov_deg: Option<f32>,
    path: Option<PathBuf>,
    keyframes: Option<Vec<KeyframeTable>>,
    interpolation: Option<Interpolation>,
}

impl CameraTable {
    /// The camera path that the table of the scene file `file` names.
    pub fn path_file(&self, file: &Path) -> Option<PathBuf> {
        self.path.as_ref().map(|path| file.parent().unwrap_or(Path::new("")).join(path))
    }
}

/// `[[camera.keyframes]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyframeTable {
    frame: u64,
    eye: Triple,
    target: Triple,
    up: Option<Triple>,
    vfov_deg: Option<f32>,
}

/// Where a camera stands that the table does not place.
pub(crate) enum Placed<'a> {
    /// As the model says, frame by frame.
    Model(&'a [Camera]),
    /// Where the model is seen well.
    View(&'a View),
}

/// The cameras that the table asks for. Beside keyframes, `up` and `vfov_deg` are the defaults of the keyframes; beside `placed`
/// cameras they change these.
pub(crate) fn cameras(
    file: &Path,
    table: &CameraTable,
    placed: Placed<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Camera>, SceneError> {
    let up = table.up.map_or(Vec3::Y, |up| up.0);
    let vfov_deg = table.vfov_deg.unwrap_or(defaults::DEFAULT_VFOV_DEG);
    check_kind(file, table)?;
    if let Some(keyframes) = &table.keyframes {
        let cameras = from_keyframes(file, keyframes, up, vfov_deg, table.interpolation.unwrap_or_default())?;
        tell_first(file, keyframes[0].frame, warnings);
        return Ok(cameras);
    }
    if let Some(path) = table.path_file(file) {
        let (first, cameras) = camera::read_numbered(&path)?;
        tell_first(&path, first, warnings);
        return Ok(cameras);
    }
    let cameras = match (table.eye, table.target, placed) {
        (Some(eye), Some(target), _) => vec![Camera { eye: eye.0, target: target.0, up, vfov_deg }],
        (None, None, Placed::View(view)) => vec![Camera { up, ..view.camera(table.vfov_deg) }],
        (None, None, Placed::Model(cameras)) => {
            let change = |camera: &Camera| Camera {
                up: table.up.map_or(camera.up, |up| up.0),
                vfov_deg: table.vfov_deg.unwrap_or(camera.vfov_deg),
                ..*camera
            };
            cameras.iter().map(change).collect()
        }
        _ => {
            return Err(bad_value(file, "[camera] has only one of eye and target", "give both or neither"));
        }
    };
    cameras.iter().try_for_each(|camera| check_camera(camera, || part_of(file, "[camera]".into())))?;
    Ok(cameras)
}

/// A scene counts its frames from 0: tells where a file does not.
fn tell_first(file: &Path, first: u64, warnings: &mut Vec<Warning>) {
    if first > 0 {
        let message = format!("{}: its frame numbers begin at {first}, which is frame 0 of the scene", file.display());
        warnings.push(Warning { message, count: 1 });
    }
}

fn part_of(file: &Path, part: String) -> Location {
    Location::Part { path: file.to_owned(), part }
}

/// Refuses keys that contradict each other.
fn check_kind(file: &Path, table: &CameraTable) -> Result<(), SceneError> {
    let single = table.eye.is_some() || table.target.is_some();
    if usize::from(single) + usize::from(table.path.is_some()) + usize::from(table.keyframes.is_some()) > 1 {
        return Err(bad_value(file, "[camera] has more than one of eye/target, path and keyframes", "keep one"));
    }
    if table.interpolation.is_some() && table.keyframes.is_none() {
        return Err(bad_value(
            file,
            "[camera] has interpolation but no keyframes",
            "remove it or add [[camera.keyframes]]",
        ));
    }
    if table.path.is_some() && (table.up.is_some() || table.vfov_deg.is_some()) {
        return Err(bad_value(
            file,
            "[camera] has a path and also up or vfov_deg",
            "the path file has its own; remove them",
        ));
    }
    Ok(())
}

fn from_keyframes(
    file: &Path,
    tables: &[KeyframeTable],
    up: Vec3,
    vfov_deg: f32,
    how: Interpolation,
) -> Result<Vec<Camera>, SceneError> {
    let mut keys: Vec<Keyframe> = Vec::with_capacity(tables.len());
    for (index, table) in tables.iter().enumerate() {
        let camera = Camera {
            eye: table.eye.0,
            target: table.target.0,
            up: table.up.map_or(up, |up| up.0),
            vfov_deg: table.vfov_deg.unwrap_or(vfov_deg),
        };
        check_camera(&camera, || part_of(file, format!("camera.keyframes[{index}]")))?;
        if keys.last().is_some_and(|last| last.frame >= table.frame) {
            return Err(bad_value(
                file,
                format!("camera.keyframes[{index}] has frame {} after a frame as late", table.frame),
                "put the keyframes in order, each frame once",
            ));
        }
        keys.push(Keyframe { frame: table.frame, camera });
    }
    let (Some(first), Some(last)) = (keys.first(), keys.last()) else {
        return Err(bad_value(file, "camera.keyframes is empty", "add [[camera.keyframes]] tables"));
    };
    if last.frame - first.frame >= MAX_FRAMES {
        return Err(SceneError::Limit {
            at: Location::File(file.to_owned()),
            what: format!("the keyframes span {} frames", last.frame - first.frame),
            fix: "at most a million are possible".into(),
        });
    }
    let cameras = camera::interpolate(&keys, how);
    for (index, camera) in cameras.iter().enumerate() {
        let frame = first.frame + index as u64;
        check_camera(camera, || part_of(file, format!("camera at frame {frame}, between keyframes")))?;
    }
    Ok(cameras)
}
