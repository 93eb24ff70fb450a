//! Figures of rays, samples and quality, from the counts of one frame or of several.

use crate::figures::{ByKind, SamplingFigures};
use rayreel_replay::counts::{Counts, FrameStats};
use rayreel_replay::image::compare::{Quality, WorstTile};
use rayreel_replay::image::psnr::{SquaredError, decibels};

impl SamplingFigures {
    /// The figures of some frames, of consecutive numbers where flicker is to count.
    pub(super) fn new(frames: &[FrameStats]) -> Self {
        let counts: Counts = frames.iter().map(|f| f.counts).sum();
        // Quality is known for all frames or for none.
        let qualities: Option<Vec<Quality>> = frames.iter().map(|f| f.quality).collect();
        let qualities = qualities.unwrap_or_default();
        let tiles = || frames.iter().flat_map(|frame| &frame.tiles);
        let audited: SquaredError = tiles().map(|tile| tile.audited).sum();
        let factors: Vec<f64> = tiles().map(|tile| tile.factor).collect();
        let error: u64 = qualities.iter().map(|q| q.squared_error).sum();
        let values: u64 = qualities.iter().map(|q| q.values).sum();
        let ssims: Option<Vec<f64>> = qualities.iter().map(|q| q.ssim).collect();
        let flips: Option<Vec<f64>> = qualities.iter().map(|q| q.flip).collect();
        let worst = worst_tile(&qualities);
        // All frames have the same number of values.
        let worst_frame = qualities.iter().max_by_key(|q| q.squared_error);
        let flicker: Option<SquaredError> = qualities.iter().filter_map(|q| q.flicker).reduce(|sum, frame| sum + frame);
        let (full, traced, apron) = (counts.rays_full, counts.rays_traced, counts.rays_apron);
        Self {
            rays_full: full.total(),
            rays_traced: traced.total(),
            rays_apron: apron.total(),
            rays_saved: counts.rays_saved(),
            rays_by_kind: ByKind { full, traced, apron },
            samples_full: counts.samples_full,
            samples_reference: counts.samples_reference,
            samples_traced: counts.samples_traced,
            samples_interpolated: counts.samples_interpolated,
            samples_apron: counts.samples_apron,
            similarity_ratio: counts.similarity_ratio(),
            limit_factor: mean(&factors),
            audited_pixels: audited.values / 3,
            audited_psnr_db: audited.decibels(),
            psnr_db: decibels(error, values),
            ssim: ssims.and_then(|s| mean(&s)),
            flip: flips.and_then(|f| mean(&f)),
            worst_frame_psnr_db: worst_frame.and_then(|q| decibels(q.squared_error, q.values)),
            worst_tile_psnr_db: worst.and_then(|w| w.error.decibels()),
            worst_tile: worst.map(|w| w.tile),
            worst_tile_frame: worst.map(|w| w.frame),
            flicker: flicker.map(SquaredError::rms),
            flicker_db: flicker.and_then(SquaredError::decibels),
            identical: (!qualities.is_empty()).then_some(error == 0),
        }
    }
}

/// The worst of the worst tiles of all frames, the first of equals.
fn worst_tile(qualities: &[Quality]) -> Option<WorstTile> {
    let tiles = qualities.iter().filter_map(|q| q.worst_tile);
    tiles.reduce(|worst, tile| if tile.error.is_worse_than(worst.error) { tile } else { worst })
}

/// The mean; none without values. All frames have the same number of pixels.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
