//! The report of a replay: what `rayreel replay --json` prints, and a table for people.
//!
//! No wall-clock figure stands here: the bytes are a pure function of trace and policy. Ratios are made here from the integer
//! counts, each by one division.

pub mod keys;
pub mod table;

use rayreel_formats::scene::Meta;
use serde::Serialize;
use serde_json::Value;

use crate::error::{ReplayError, Result};
use crate::frame::counts::{Counts, FrameStats, Quality, RayCounts, TileStats};
use crate::image::psnr::decibels;
use crate::policy::{NamedPolicy, Policy};

/// What the results are of, as the caller knows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Name of the trace.
    pub trace: String,
    /// Digest of the trace, if the caller has it.
    pub trace_digest: Option<String>,
}

/// The results of a replay. `keys` says what each key means, and in which unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the trace.
    pub trace: String,
    /// Digest of the trace.
    pub trace_digest: Option<String>,
    /// Scene of the trace.
    pub scene: String,
    /// Machine preset; null without a machine model.
    pub machine: Option<String>,
    /// Name of the policy.
    pub policy: String,
    /// Every value of the policy.
    pub policy_config: Policy,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Samples per pixel and axis.
    pub samples_per_axis: u32,
    /// Tile edge, samples.
    pub tile: u32,
    /// Sums and means over all frames.
    #[serde(flatten)]
    pub sum: Figures,
    /// Each frame.
    pub frames: Vec<FrameReport>,
    /// Unit and meaning of the keys.
    pub descriptions: Value,
}

/// The figures of one frame, or of all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays of the traced samples.
    pub rays_traced: u64,
    /// Rays of other tiles' samples, traced again.
    pub rays_apron: u64,
    /// Rays saved.
    pub rays_saved: i64,
    /// The same by kind.
    pub rays_by_kind: ByKind,
    /// Samples of the grid.
    pub samples_full: u64,
    /// R-samples.
    pub samples_reference: u64,
    /// Samples traced.
    pub samples_traced: u64,
    /// Samples interpolated.
    pub samples_interpolated: u64,
    /// Samples of other tiles, traced again.
    pub samples_apron: u64,
    /// Interpolated per I-sample.
    pub similarity_ratio: Option<f64>,
    /// PSNR, dB; null for identical pictures, or without a comparison.
    pub psnr_db: Option<f64>,
    /// SSIM; null for pictures below 11 pixels, or without a comparison.
    pub ssim: Option<f64>,
    /// True if the pictures are the same in all 8-bit values; null without a comparison.
    pub identical: Option<bool>,
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ByKind {
    /// Of all samples.
    pub full: RayCounts,
    /// Of the traced samples.
    pub traced: RayCounts,
    /// Of the apron samples.
    pub apron: RayCounts,
}

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameReport {
    /// Frame number.
    pub frame: u32,
    /// Its figures.
    #[serde(flatten)]
    pub figures: Figures,
    /// Its tiles, in order; left out if empty.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tiles: Vec<TileReport>,
}

/// One tile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TileReport {
    /// Tile number.
    pub tile: u32,
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays of the traced samples.
    pub rays_traced: u64,
    /// Rays of the apron samples.
    pub rays_apron: u64,
    /// Samples traced.
    pub samples_traced: u64,
    /// Samples interpolated.
    pub samples_interpolated: u64,
    /// Interpolated per I-sample.
    pub similarity_ratio: Option<f64>,
}

impl Report {
    /// The report of some replayed frames.
    pub fn new(origin: &Origin, policy: &NamedPolicy, meta: &Meta, frames: &[FrameStats]) -> Self {
        let qualities: Option<Vec<Quality>> = frames.iter().map(|f| f.quality).collect();
        let counts = frames.iter().map(|f| f.counts).sum();
        Self {
            trace: origin.trace.clone(),
            trace_digest: origin.trace_digest.clone(),
            scene: meta.scene.clone(),
            machine: None,
            policy: policy.name.clone(),
            policy_config: policy.policy.clone(),
            width: meta.width,
            height: meta.height,
            samples_per_axis: meta.samples,
            tile: meta.tile,
            sum: Figures::new(&counts, qualities.as_deref().unwrap_or_default()),
            frames: frames.iter().map(FrameReport::new).collect(),
            descriptions: keys::descriptions(),
        }
    }

    /// The same without the tiles of the frames, which make up most of the report of a long sequence.
    #[must_use]
    pub fn without_tiles(mut self) -> Self {
        self.frames.iter_mut().for_each(|frame| frame.tiles.clear());
        self
    }

    /// The report as JSON, indented, ending in a newline.
    ///
    /// # Errors
    /// Never for a report made by [`Report::new`]: all keys are strings and all numbers finite.
    pub fn to_json(&self) -> Result<String> {
        let text = serde_json::to_string_pretty(self).map_err(|e| ReplayError::Usage { detail: e.to_string() })?;
        Ok(text + "\n")
    }
}

impl Figures {
    /// `qualities` holds those of all frames, or nothing if they were not compared.
    fn new(counts: &Counts, qualities: &[Quality]) -> Self {
        let error: u64 = qualities.iter().map(|q| q.squared_error).sum();
        let values: u64 = qualities.iter().map(|q| q.values).sum();
        let ssims: Option<Vec<f64>> = qualities.iter().map(|q| q.ssim).collect();
        let ssim = ssims.filter(|s| !s.is_empty()).map(|s| s.iter().sum::<f64>() / s.len() as f64);
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
            psnr_db: decibels(error, values),
            ssim,
            identical: (!qualities.is_empty()).then_some(error == 0),
        }
    }
}

impl FrameReport {
    fn new(stats: &FrameStats) -> Self {
        Self {
            frame: stats.frame,
            figures: Figures::new(&stats.counts, stats.quality.as_slice()),
            tiles: stats.tiles.iter().map(TileReport::new).collect(),
        }
    }
}

impl TileReport {
    fn new(stats: &TileStats) -> Self {
        let counts = &stats.counts;
        Self {
            tile: stats.tile,
            rays_full: counts.rays_full.total(),
            rays_traced: counts.rays_traced.total(),
            rays_apron: counts.rays_apron.total(),
            samples_traced: counts.samples_traced,
            samples_interpolated: counts.samples_interpolated,
            similarity_ratio: counts.similarity_ratio(),
        }
    }
}
