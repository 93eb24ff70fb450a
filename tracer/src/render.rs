//! Render: traces what a capture would, and keeps only the colours.

use rayon::prelude::*;
use rayreel_formats::Result;
use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Meta, Rect};
use rayreel_scenes::Scene;

use crate::accel::Built;
use crate::grid::{self, TraceSettings};
use crate::trace::Tracer;

/// Traces one frame without recording. `tile` gets the colours of the samples of each tile, row by row, in tile order.
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
    grid::check_frames(scene, &Meta { first_frame: frame, frames: 1, ..meta.clone() })?;
    let tracer = Tracer::new(scene, built, TraceSettings::of(meta));
    let camera = grid::frame_camera(scene, meta, frame);
    let tiles: Vec<u32> = (0..meta.tile_count()).collect();
    for batch in tiles.chunks(grid::tiles_in_flight()) {
        let colours: Vec<_> = batch.par_iter().map(|&t| tracer.colours(&camera, meta.tile_rect(t))).collect();
        for (&index, colours) in batch.iter().zip(colours) {
            tile(meta.tile_rect(index), colours);
        }
    }
    Ok(())
}
