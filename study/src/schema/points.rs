//! Points: one scene in one mode under one policy each, with what it cost and how the picture came out.

use serde::{Deserialize, Serialize};

/// One scene in one mode under one policy on one machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Name of the scene.
    pub scene: String,
    /// `2x2` (supersampling) or `1x1` (undersampling).
    pub mode: String,
    /// Name of the policy.
    pub policy: String,
    /// Name of the machine; null without one.
    pub machine: Option<String>,
    /// Block edge, samples; null for `full` and where it varies.
    pub block: Option<u32>,
    /// What the policy is: `full`, `adaptive`, `multirate`, `foveated`, `whitted1980`, `mitchell1987`, `jin2009`.
    pub kind: String,
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays traced, rays traced again for neighbouring tiles included.
    pub rays_traced: u64,
    /// Samples of the grid.
    pub samples_full: u64,
    /// Samples traced.
    pub samples_traced: u64,
    /// Traced samples per sample of the grid.
    pub mean_rate: f64,
    /// The T&I units alone, on a machine whose SRP takes no time: the paper's Figure 7.
    pub ti: Option<Cost>,
    /// The whole GPU.
    pub gpu: Option<Cost>,
    /// `ti` relative to `full` of the same scene and mode.
    pub ti_gain: Option<Gain>,
    /// `gpu` relative to `full` of the same scene and mode.
    pub gpu_gain: Option<Gain>,
    /// `ti` relative to `full` of the same scene in mode `2x2`.
    pub fsaa_gain: Option<Gain>,
    /// The picture against that of `full` in the same mode; null without a comparison.
    pub quality: Option<Quality>,
    /// What each unit of the whole GPU did with its cycles.
    pub units: Vec<Unit>,
    /// Energy of the whole GPU by component.
    pub energy: Vec<Component>,
    /// Cycles of the SRPs of the whole GPU by kernel.
    pub srp: Vec<Kernel>,
}

/// Kernels of the SRP that sampling adds: tests with what they decide, and interpolation.
pub const SAMPLING_KERNELS: [&[&str]; 2] =
    [&["similarity", "colour", "look_back", "control"], &["interpolate", "attributes", "reshade"]];

impl Point {
    /// Shares of the busy cycles of the SRPs that tests (inspector included) and interpolation take; nothing without a machine.
    pub fn sampling_shares(&self) -> [Option<f64>; 2] {
        SAMPLING_KERNELS.map(|kernels| {
            let shares = self.srp.iter().filter(|kernel| kernels.contains(&kernel.kernel.as_str()));
            (!self.srp.is_empty()).then(|| shares.map(|kernel| kernel.share).sum())
        })
    }
}

/// What a run costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cost {
    /// Cycles of the T&I clock.
    pub cycles: u64,
    /// Simulated time, ms.
    pub time_ms: f64,
    /// Mean power, W.
    pub power_w: f64,
    /// Energy, mJ.
    pub energy_mj: f64,
    /// Frames a second and watt.
    pub perf_per_watt: f64,
    /// How far they may be off; null if every cycle was simulated.
    pub interval: Option<CostInterval>,
}

/// Half the width of the 95 % interval of each figure of a cost, as a part of the figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostInterval {
    /// Of cycles and time.
    pub cycles: f64,
    /// Of power.
    pub power_w: f64,
    /// Of energy.
    pub energy_mj: f64,
    /// Of frames a second and watt.
    pub perf_per_watt: f64,
}

/// Factors over a reference; more than 1 is more than the reference has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gain {
    /// Frames a second.
    pub performance: f64,
    /// Mean power.
    pub power: f64,
    /// Frames a second and watt.
    pub perf_per_watt: f64,
    /// How far they may be off; null if every cycle of both was simulated.
    pub interval: Option<GainInterval>,
}

/// Half the width of the 95 % interval of each factor of a gain, as a part of the factor. What both runs share has cancelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainInterval {
    /// Of frames a second.
    pub performance: f64,
    /// Of mean power.
    pub power: f64,
    /// Of frames a second and watt.
    pub perf_per_watt: f64,
}

/// A picture against its reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// PSNR, dB; null for identical pictures.
    pub psnr_db: Option<f64>,
    /// SSIM, 1 for identical pictures; null where the picture is too small.
    pub ssim: Option<f64>,
    /// Mean FLIP error, 0 for identical pictures; null if not measured.
    pub flip: Option<f64>,
    /// PSNR of the worst tile, dB; null if no tile differs.
    pub worst_tile_psnr_db: Option<f64>,
}

/// A unit's account of its cycles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unit {
    /// Name, such as `trv/inner`.
    pub unit: String,
    /// Share of the cycles by state; they add up to 1.
    pub shares: Vec<StateShare>,
}

/// Share of cycles in a state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateShare {
    /// The state, such as `busy`.
    pub state: String,
    /// Share of all cycles.
    pub share: f64,
}

/// Energy of a component.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Component {
    /// Name.
    pub component: String,
    /// `ti`, `srp` or `memory`.
    pub group: String,
    /// Dynamic energy and leakage, mJ.
    pub mj: f64,
}

/// Cycles of an SRP kernel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    /// Name, such as `similarity`.
    pub kernel: String,
    /// SRP cycles, all SRPs together.
    pub cycles: u64,
    /// Share of the busy cycles.
    pub share: f64,
}
