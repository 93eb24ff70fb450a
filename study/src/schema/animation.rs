//! Frames of a camera path: maps of single ones, figures over all of them.

use serde::{Deserialize, Serialize};

use crate::schema::points::CostInterval;

/// A frame as maps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Map {
    /// Name of the scene.
    pub scene: String,
    /// Name of the policy.
    pub policy: String,
    /// Frame, from 1.
    pub frame: u32,
    /// Similarity map (yellow interpolated, blue traced).
    pub similarity: String,
    /// Rate map.
    pub rate: Option<String>,
    /// The frame itself.
    pub picture: Option<String>,
    /// Interpolated samples per sample that could have been; null where there are none.
    pub similarity_ratio: Option<f64>,
    /// Traced samples per sample of the grid.
    pub mean_rate: f64,
    /// Similarity ratio in the paper's Figure 4, as far as it can be read there.
    pub paper_ratio: Option<f64>,
}

/// An animation under one policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Track {
    /// Name of the scene.
    pub scene: String,
    /// Name of the policy.
    pub policy: String,
    /// `2x2` or `1x1`.
    pub mode: String,
    /// Its frames, in order.
    pub frames: Vec<TrackFrame>,
    /// How far the means of time, power and energy over the frames may be off; null if every frame was simulated, or none, or some but
    /// the others not estimated. Not in studies of schema 3, which `examples/between.rs` reads.
    #[serde(default)]
    pub interval: Option<CostInterval>,
    /// Flicker: temporal difference error against `full`; smaller is steadier; null if not measured.
    pub flicker: Option<f64>,
    /// PSNR of the mean squared error over all frames, dB; null for identical pictures or without a comparison.
    pub psnr_db: Option<f64>,
}

/// A frame of an animation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackFrame {
    /// Frame, from 1.
    pub frame: u32,
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays traced.
    pub rays_traced: u64,
    /// Mean power of the T&I units alone, W; null without a machine.
    pub power_w: Option<f64>,
    /// Simulated time, ms; null without a machine.
    pub time_ms: Option<f64>,
    /// Energy of the T&I units alone, mJ; null without a machine.
    pub energy_mj: Option<f64>,
    /// How far time, power and energy may be off; null if every cycle was simulated. A frame that was not simulated may be estimated
    /// from the frames before and after it.
    pub interval: Option<CostInterval>,
    /// PSNR, dB; null for identical pictures or without a comparison.
    pub psnr_db: Option<f64>,
    /// Traced samples per sample of the grid.
    pub mean_rate: f64,
    /// Interpolated samples per sample that could have been; null where there are none.
    pub similarity_ratio: Option<f64>,
}
