//! Capture: traces every sample of every frame into a trace file.
//!
//! Tiles are traced and coded in parallel and written in order, a batch at a time. Memory stays at the scene, the BVH
//! and the tiles in flight, and the bytes of the file do not depend on the number of threads.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rayreel_formats::bvh::Bvh;
use rayreel_formats::container::EncodedChunk;
use rayreel_formats::error::first_error;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, Started, TileCodec, Trace, TraceWriter};
use rayreel_formats::{Error, Limits, Result};
use rayreel_scenes::Scene;

use crate::accel::Built;
use crate::grid::{self, TraceSettings};
use crate::trace::Tracer;

/// How to write the trace.
#[derive(Clone, Debug)]
pub struct CaptureOutput {
    /// The file; `NAME.partial` stands beside it until it is finished.
    pub path: PathBuf,
    /// Codec of the tiles.
    pub codec: Codec,
    /// zstd level of metadata, BVH and cameras.
    pub level: i32,
    /// Go on with `NAME.partial` if there is one.
    pub resume: bool,
    /// For reading what is there already, and the finished trace.
    pub limits: Limits,
}

impl CaptureOutput {
    /// A new capture, within the default limits.
    pub fn new(path: PathBuf, codec: Codec, level: i32) -> Self {
        Self { path, codec, level, resume: false, limits: Limits::default() }
    }
}

/// How far a capture has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CaptureProgress {
    /// Tiles in the file.
    pub tiles: u64,
    /// Tiles that the finished file will have.
    pub tiles_total: u64,
    /// Rays traced in this run.
    pub rays: u64,
    /// Bytes written in this run.
    pub bytes: u64,
    /// Whole tiles of the run before that lay behind damage: they were cut off, and are traced again.
    pub dropped_tiles: u64,
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
pub enum CaptureOutcome {
    /// The file is complete.
    Finished(Captured),
    /// Stopped by the progress callback; `NAME.partial` holds what was traced.
    Interrupted(CaptureProgress),
}

/// Captures the frames of `meta`. After each batch of tiles `progress` is told, and stops the capture by returning
/// false.
///
/// Frame numbers are positions in the camera path of the scene.
///
/// # Errors
/// When a frame is outside the camera path, or the file cannot be written.
pub fn capture(
    scene: &Scene,
    built: &Built,
    meta: &Meta,
    output: &CaptureOutput,
    mut progress: impl FnMut(&CaptureProgress) -> bool,
) -> Result<CaptureOutcome> {
    meta.check(&Limits::default()).map_err(Error::usage)?;
    grid::check_frames(scene, meta)?;
    let job = TileJob {
        tracer: Tracer::new(scene, built, TraceSettings::of(meta)),
        bvh: &built.bvh,
        topology: BvhTopology::new(&built.bvh),
        meta,
        codec: output.codec,
    };
    let (mut writer, dropped_tiles) = start(output, meta, &built.bvh)?;
    let at_start = writer.bytes_written();
    let tiles_total = u64::from(meta.tile_count()) * u64::from(meta.frames);
    let mut now = CaptureProgress { tiles_total, dropped_tiles, ..CaptureProgress::default() };
    let mut kept = Vec::new();
    for frame in meta.frame_numbers() {
        let camera = grid::frame_camera(scene, meta, frame);
        writer.frame(frame, &camera)?;
        let (done, todo): (Vec<u32>, Vec<u32>) = (0..meta.tile_count()).partition(|&t| writer.has_tile(frame, t));
        now.tiles += done.len() as u64;
        kept.extend(done.into_iter().map(|tile| (frame, tile)));
        for batch in todo.chunks(grid::tiles_in_flight()) {
            for (chunk, rays) in job.batch(&camera, frame, batch)? {
                writer.tile(&chunk)?;
                now.rays += rays;
            }
            writer.flush()?;
            now.tiles += batch.len() as u64;
            now.bytes = writer.bytes_written() - at_start;
            if !progress(&now) {
                return Ok(CaptureOutcome::Interrupted(now));
            }
        }
    }
    let finished = writer.finish()?;
    summary((&finished.path, &output.limits), finished.len, now.rays, &kept).map(CaptureOutcome::Finished)
}

/// The writer, and how many tiles it has cut off.
fn start(output: &CaptureOutput, meta: &Meta, bvh: &Bvh) -> Result<(TraceWriter, u64)> {
    if output.resume {
        let Started { writer, dropped_tiles, .. } =
            TraceWriter::resume(&output.path, meta, bvh, output.level, output.codec, &output.limits)?;
        return Ok((writer, dropped_tiles));
    }
    Ok((TraceWriter::create(&output.path, meta, bvh, output.level)?, 0))
}

/// What every tile of a capture shares.
struct TileJob<'a> {
    tracer: Tracer<'a>,
    bvh: &'a Bvh,
    topology: BvhTopology,
    meta: &'a Meta,
    codec: Codec,
}

impl TileJob<'_> {
    /// Traces and codes tiles in parallel; gives each one's chunk and number of rays, in the order of `tiles`.
    fn batch(&self, camera: &Camera, frame: u32, tiles: &[u32]) -> Result<Vec<(EncodedChunk, u64)>> {
        let code = |scratch: &mut Scratch, &tile: &u32| self.tile(camera, frame, tile, scratch);
        first_error(tiles.par_iter().map_init(Scratch::default, code))
    }

    fn tile(&self, camera: &Camera, frame: u32, index: u32, scratch: &mut Scratch) -> Result<(EncodedChunk, u64)> {
        let tile = self.tracer.tile::<true>(camera, self.meta.tile_rect(index), frame, index);
        let limits = Limits::default();
        let codec = TileCodec { meta: self.meta, bvh: self.bvh, topology: &self.topology, camera, limits: &limits };
        Ok((codec.encode_traced(&tile, self.codec, scratch)?, tile.tree.ray_count()))
    }
}

/// Totals of a finished trace. Tiles that were kept from an earlier run are counted from their trees.
fn summary(
    (path, limits): (&Path, &Limits),
    file_bytes: u64,
    rays_this_run: u64,
    kept: &[(u32, u32)],
) -> Result<Captured> {
    let trace = Trace::open(path, limits.clone())?;
    let count = |&(frame, tile): &(u32, u32)| trace.tile(frame, tile, &[Column::Tree]).map(|t| t.tree.ray_count());
    let rays = rays_this_run + first_error(kept.par_iter().map(count))?.iter().sum::<u64>();
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
