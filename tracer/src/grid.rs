//! Which samples of which frames are traced, and the metadata that a trace keeps of that.

use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::{Error, Result};
use rayreel_scenes::Scene;

use crate::convert;

/// How deep a ray tree grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceSettings {
    /// Secondary bounces allowed.
    pub max_depth: u32,
    /// Largest component of the weight from the eye at which a child ray is no longer traced.
    pub min_weight: f32,
}

impl TraceSettings {
    /// The settings that a trace was, or will be, captured with.
    pub fn of(meta: &Meta) -> Self {
        Self { max_depth: meta.max_depth, min_weight: meta.min_weight }
    }
}

impl Default for TraceSettings {
    fn default() -> Self {
        Self { max_depth: 4, min_weight: 0.01 }
    }
}

/// The sample grid and the frames of a capture or a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleGrid {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Samples per pixel and axis.
    pub samples: u32,
    /// Tile edge in samples.
    pub tile: u32,
    /// First frame of the camera path.
    pub first_frame: u32,
    /// Number of frames.
    pub frames: u32,
}

impl SampleGrid {
    /// The metadata of a trace of `scene` over this grid; `tool` is the name and version of the program.
    pub fn meta(&self, scene: &Scene, settings: TraceSettings, tool: &str) -> Meta {
        self.meta_of((scene, scene.content_hash()), settings, tool)
    }

    /// As [`SampleGrid::meta`], of a scene with its content hash: many grids of one scene need that once.
    pub fn meta_of(&self, (scene, scene_hash): (&Scene, [u8; 32]), settings: TraceSettings, tool: &str) -> Meta {
        Meta {
            tool: tool.to_string(),
            scene: scene.name.clone(),
            scene_hash,
            width: self.width,
            height: self.height,
            samples: self.samples,
            tile: self.tile,
            first_frame: self.first_frame,
            frames: self.frames,
            max_depth: settings.max_depth,
            min_weight: settings.min_weight,
            lights: scene.lights.iter().map(convert::light).collect(),
        }
    }
}

/// Refuses frames that the camera path of the scene does not have.
pub(crate) fn check_frames(scene: &Scene, meta: &Meta) -> Result<()> {
    let (end, have) = (meta.frame_numbers().end, scene.cameras.len());
    if end as usize <= have {
        return Ok(());
    }
    Err(Error::usage(format!("frame {} is outside the camera path of scene {}, which has {have}", end - 1, scene.name)))
}

/// The camera of a frame, over the sample grid of `meta`.
pub(crate) fn frame_camera(scene: &Scene, meta: &Meta, frame: u32) -> Camera {
    let (columns, rows) = meta.grid();
    convert::camera(&scene.cameras[frame as usize], columns, rows)
}

/// Tiles that are in flight at once: enough per thread that one slow tile does not leave the others waiting.
pub(crate) fn tiles_in_flight() -> usize {
    48 * rayon::current_num_threads()
}
