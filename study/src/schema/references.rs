//! What the paper states, for the same scenes and modes.

use serde::{Deserialize, Serialize};

/// What the paper states.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct References {
    /// Which policy does what the paper evaluated, by mode.
    pub policies: Vec<ModePolicy>,
    /// Performance per watt over full, T&I units alone (Figure 7), for both modes.
    pub gains: Vec<GainBand>,
    /// Power over full; of which scenes, and whether it is a mean, is not stated.
    pub power: Option<f64>,
    /// Table 1.
    pub psnr: Vec<PaperPsnr>,
    /// SRP cycles by kernel; of which scenes, and whether they are means, is not stated.
    pub srp: Vec<PaperKernel>,
}

/// The paper's policy of a mode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModePolicy {
    /// `2x2` or `1x1`.
    pub mode: String,
    /// Name of the policy.
    pub policy: String,
}

/// Performance per watt over full in the paper.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainBand {
    /// Name of the scene.
    pub scene: String,
    /// Least.
    pub least: f64,
    /// Most; null if not stated.
    pub most: Option<f64>,
}

/// PSNR in the paper.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperPsnr {
    /// Name of the scene.
    pub scene: String,
    /// `2x2` or `1x1`.
    pub mode: String,
    /// PSNR, dB.
    pub psnr_db: f64,
}

/// Share of an SRP kernel in the paper.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperKernel {
    /// Name of the kernel, as in [`Kernel`](crate::schema::Kernel).
    pub kernel: String,
    /// Share of the cycles.
    pub share: f64,
}
