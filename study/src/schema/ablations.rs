//! One choice changed at a time.

use serde::{Deserialize, Serialize};

use crate::schema::points::{CostInterval, GainInterval};

/// One choice changed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ablation {
    /// What is varied, such as `block size`.
    pub group: String,
    /// The choice.
    pub name: String,
    /// What it means; may be empty.
    pub note: String,
    /// Name of the scene.
    pub scene: String,
    /// `2x2` or `1x1`.
    pub mode: String,
    /// Name of the policy that was varied.
    pub policy: String,
    /// Whether this is the unchanged one that the others of its group, scene and mode are compared with.
    pub base: bool,
    /// Rays traced.
    pub rays_traced: u64,
    /// Rays of all samples.
    pub rays_full: u64,
    /// Cycles of the T&I clock, whole GPU; null without a machine.
    pub cycles: Option<u64>,
    /// Mean power of the whole GPU, W; null without a machine.
    pub power_w: Option<f64>,
    /// Frames a second and watt, whole GPU; null without a machine.
    pub perf_per_watt: Option<f64>,
    /// How far cycles, power and frames a second and watt may be off; null if every cycle was simulated.
    pub interval: Option<CostInterval>,
    /// The same of their factors over the base, with time's inverse for cycles; null if every cycle of both was simulated.
    pub gain_interval: Option<GainInterval>,
    /// PSNR, dB; null for identical pictures or without a comparison.
    pub psnr_db: Option<f64>,
}
