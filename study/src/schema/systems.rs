//! Policies on machines.

use serde::{Deserialize, Serialize};

use crate::schema::points::{Cost, Gain};

/// A scene under a policy on a machine, 2x2 samples a pixel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SystemPoint {
    /// Name of the scene.
    pub scene: String,
    /// Name of the machine.
    pub machine: String,
    /// Name of the policy.
    pub policy: String,
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays traced.
    pub rays_traced: u64,
    /// PSNR, dB; null for identical pictures.
    pub psnr_db: Option<f64>,
    /// Cost of the whole GPU.
    pub gpu: Option<Cost>,
    /// Cost of the T&I units alone, whose SRP takes no time; null on machines without such units.
    pub ti: Option<Cost>,
    /// The whole GPU over that under `full` on the same machine.
    pub gpu_gain: Option<Gain>,
    /// The T&I units alone over those under `full` on the same machine.
    pub ti_gain: Option<Gain>,
}
