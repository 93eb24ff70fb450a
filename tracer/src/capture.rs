//! Capture: traces every sample of every frame into a trace file; and render, which traces the same and keeps only colours.
//!
//! Tiles are traced and coded in parallel and written in order, a batch at a time. Memory stays at the scene, the BVH and the
//! tiles in flight, and the file's bytes do not depend on the number of threads.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rayreel_formats::bvh::Bvh;
use rayreel_formats::container::EncodedChunk;
use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Meta, Rect};
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, Started, Trace, TraceWriter};
use rayreel_formats::{Error, Limits, Result};
use rayreel_scenes::Scene;

use crate::accel::Built;
use crate::convert;
use crate::trace::{Settings, Tracer};

/// The sample grid and frames to capture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
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

/// How to write the trace.
#[derive(Clone, Debug)]
pub struct Output {
    /// The file; `NAME.partial` stands beside it until it is finished.
    pub path: PathBuf,
    /// Codec of the tiles.
    pub codec: Codec,
    /// zstd level of metadata, BVH and index.
    pub level: i32,
    /// Go on with `NAME.partial` if there is one.
    pub resume: bool,
}

/// How far a capture has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Tiles in the file.
    pub tiles: u64,
    /// Tiles that the finished file will have.
    pub tiles_total: u64,
    /// Rays traced in this run.
    pub rays: u64,
    /// Bytes written in this run.
    pub bytes: u64,
}

/// What a capture came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Captured {
    /// Samples in the trace.
    pub samples: u64,
    /// Rays in the trace.
    pub rays: u64,
    /// Rays traced in this run: fewer than `rays` when it was resumed.
    pub rays_this_run: u64,
    /// Traversal steps in the trace.
    pub steps: u64,
    /// Length of the file.
    pub file_bytes: u64,
    /// Bytes of the paths column in the file.
    pub path_bytes: u64,
}

/// How a capture ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The file is complete.
    Finished(Captured),
    /// Stopped by the progress callback; `NAME.partial` holds what was traced.
    Interrupted(Progress),
}

/// The metadata of a capture.
pub fn meta(scene: &Scene, grid: Grid, settings: Settings, tool: &str) -> Meta {
    Meta {
        tool: tool.to_string(),
        scene: scene.name.clone(),
        scene_hash: scene.content_hash(),
        width: grid.width,
        height: grid.height,
        samples: grid.samples,
        tile: grid.tile,
        first_frame: grid.first_frame,
        frames: grid.frames,
        max_depth: settings.max_depth,
        min_weight: settings.min_weight,
        lights: scene.lights.iter().map(convert::light).collect(),
    }
}

/// Tiles that are in flight at once, per thread: enough that one slow tile does not leave the others waiting.
const TILES_IN_FLIGHT: usize = 48;

/// Captures `meta`'s frames of a scene. After each batch of tiles `progress` is told, and stops the capture by returning false.
///
/// Frame numbers are positions in the scene's camera path.
///
/// # Errors
/// When a frame is outside the camera path, or the file cannot be written.
pub fn capture(
    scene: &Scene,
    built: &Built,
    meta: &Meta,
    output: &Output,
    mut progress: impl FnMut(&Progress) -> bool,
) -> Result<Outcome> {
    meta.check(&Limits::default()).map_err(Error::usage)?;
    check_frames(scene, meta)?;
    let settings = Settings { max_depth: meta.max_depth, min_weight: meta.min_weight };
    let job = Job {
        tracer: Tracer::new(scene, built, settings),
        bvh: &built.bvh,
        topology: BvhTopology::new(&built.bvh),
        meta,
        codec: output.codec,
    };
    let mut writer = start(output, meta, &built.bvh)?;
    let at_start = writer.bytes_written();
    let mut now =
        Progress { tiles_total: u64::from(meta.tile_count()) * u64::from(meta.frames), ..Progress::default() };
    let mut kept = Vec::new();
    for frame in meta.frame_numbers() {
        let (columns, rows) = meta.grid();
        let camera = convert::camera(&scene.cameras[frame as usize], columns, rows);
        writer.frame(frame, &camera)?;
        let (done, todo): (Vec<u32>, Vec<u32>) = (0..meta.tile_count()).partition(|&t| writer.has_tile(frame, t));
        now.tiles += done.len() as u64;
        kept.extend(done.into_iter().map(|tile| (frame, tile)));
        for batch in todo.chunks(TILES_IN_FLIGHT * rayon::current_num_threads()) {
            let code = |scratch: &mut Scratch, &tile: &u32| job.tile(&camera, frame, tile, scratch);
            let chunks: Vec<(EncodedChunk, u64)> =
                batch.par_iter().map_init(Scratch::default, code).collect::<Result<_>>()?;
            for (chunk, rays) in &chunks {
                writer.tile(chunk)?;
                now.rays += rays;
            }
            writer.flush()?;
            now.tiles += chunks.len() as u64;
            now.bytes = writer.bytes_written() - at_start;
            if !progress(&now) {
                return Ok(Outcome::Interrupted(now));
            }
        }
    }
    let finished = writer.finish()?;
    summary(&finished.path, finished.len, now.rays, &kept).map(Outcome::Finished)
}

fn check_frames(scene: &Scene, meta: &Meta) -> Result<()> {
    let (end, have) = (meta.frame_numbers().end, scene.cameras.len());
    if end as usize <= have {
        return Ok(());
    }
    Err(Error::usage(format!("frame {} is outside the camera path of scene {}, which has {have}", end - 1, scene.name)))
}

fn start(output: &Output, meta: &Meta, bvh: &Bvh) -> Result<TraceWriter> {
    if output.resume {
        let Started { writer, .. } =
            TraceWriter::resume(&output.path, meta, bvh, output.level, output.codec, &Limits::default())?;
        return Ok(writer);
    }
    TraceWriter::create(&output.path, meta, bvh, output.level)
}

/// What every tile of a capture shares.
struct Job<'a> {
    tracer: Tracer<'a>,
    bvh: &'a Bvh,
    topology: BvhTopology,
    meta: &'a Meta,
    codec: Codec,
}

impl Job<'_> {
    /// Traces and codes a tile; gives the chunk and the number of rays.
    fn tile(
        &self,
        camera: &rayreel_formats::scene::Camera,
        frame: u32,
        index: u32,
        scratch: &mut Scratch,
    ) -> Result<(EncodedChunk, u64)> {
        let tile = self.tracer.tile::<true>(camera, self.meta.tile_rect(index), frame, index);
        let limits = Limits::default();
        let codec = rayreel_formats::trace::TileCodec {
            meta: self.meta,
            bvh: self.bvh,
            topology: &self.topology,
            camera,
            limits: &limits,
        };
        Ok((codec.encode(&tile, self.codec, scratch)?, tile.tree.ray_count()))
    }
}

/// Totals of a finished trace. Tiles that were kept from an earlier run are counted from their trees.
fn summary(path: &Path, file_bytes: u64, rays_this_run: u64, kept: &[(u32, u32)]) -> Result<Captured> {
    let trace = Trace::open(path, Limits::default())?;
    let count = |&(frame, tile): &(u32, u32)| trace.tile(frame, tile, &[Column::Tree]).map(|t| t.tree.ray_count());
    let rays_kept: Vec<u64> = kept.par_iter().map(count).collect::<Result<_>>()?;
    let rays = rays_this_run + rays_kept.iter().sum::<u64>();
    let paths = trace.column_totals().iter().find(|c| c.id == Column::Paths as u8);
    let (path_bytes, path_raw) = paths.map_or((0, 0), |c| (c.packed_bytes, c.raw_bytes));
    let meta = trace.meta();
    let (columns, rows) = meta.grid();
    Ok(Captured {
        samples: u64::from(columns) * u64::from(rows) * u64::from(meta.frames),
        rays,
        rays_this_run,
        // Canonical paths are a length of four bytes a ray and a byte a step.
        steps: path_raw.saturating_sub(4 * rays),
        file_bytes,
        path_bytes,
    })
}

/// Traces one frame without recording. `tile` gets the colours of each tile's samples, row by row, in tile order.
///
/// # Errors
/// When the frame is outside the camera path.
pub fn render(
    scene: &Scene,
    built: &Built,
    meta: &Meta,
    frame: u32,
    mut tile: impl FnMut(Rect, Vec<Vec3>),
) -> Result<()> {
    check_frames(scene, &Meta { first_frame: frame, frames: 1, ..meta.clone() })?;
    let settings = Settings { max_depth: meta.max_depth, min_weight: meta.min_weight };
    let tracer = Tracer::new(scene, built, settings);
    let (columns, rows) = meta.grid();
    let camera = convert::camera(&scene.cameras[frame as usize], columns, rows);
    let tiles: Vec<u32> = (0..meta.tile_count()).collect();
    for batch in tiles.chunks(TILES_IN_FLIGHT * rayon::current_num_threads()) {
        let colours: Vec<_> = batch.par_iter().map(|&t| tracer.colours(&camera, meta.tile_rect(t))).collect();
        for (&index, colours) in batch.iter().zip(colours) {
            tile(meta.tile_rect(index), colours);
        }
    }
    Ok(())
}
