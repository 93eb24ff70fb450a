//! A study: many replays side by side, as `study.json` holds them beside their pictures.
//!
//! `rayreel paper` writes one and `rayreel report` makes a page of it; nothing but this file stands between them. Whatever was not
//! measured is null or an empty list. Ratios are plain numbers (0.25, not 25 %), pictures are PNG files named relative to the
//! study's folder, frames count from 1.

use serde::{Deserialize, Serialize};

/// Version of the structs below; a reader refuses any other.
pub const SCHEMA: u32 = 1;

/// Name of the file in the study's folder.
pub const FILE: &str = "study.json";

/// All results of one experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The program that wrote it, with its version.
    pub tool: String,
    /// What it is called.
    pub title: String,
    /// The command line that repeats it.
    pub command: String,
    /// The machine; null without one.
    pub machine: Option<String>,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Sentences that a reader needs: what was sub-sampled, what differs from the paper and why.
    pub notes: Vec<String>,
    /// The preset that the summary speaks of; null lets the report choose.
    pub headline_policy: Option<String>,
    /// The scenes, in the order in which they are shown.
    pub scenes: Vec<Scene>,
    /// The policies, in the order in which they are shown; `full` first.
    pub policies: Vec<Policy>,
    /// One scene under one policy each.
    pub points: Vec<Point>,
    /// What the paper states.
    pub references: References,
    /// Similarity and rate over the frames of a path.
    pub maps: Vec<Map>,
    /// Figures over the frames of a path.
    pub tracks: Vec<Track>,
    /// One choice changed at a time.
    pub ablations: Vec<Ablation>,
    /// Pictures to look at closely.
    pub viewer: Vec<ViewerSet>,
    /// Every value of the machine.
    pub config: Vec<ConfigValue>,
}

/// A scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name, as the points use it.
    pub name: String,
    /// Triangles.
    pub triangles: u64,
    /// Triangles of the paper's scene of this kind.
    pub paper_triangles: Option<u64>,
    /// Light sources.
    pub lights: u32,
    /// The frame of the points.
    pub frame: u32,
    /// Rays of all samples, by mode.
    pub rays_full: Vec<ModeRays>,
}

/// Rays in a mode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModeRays {
    /// `2x2` (supersampling) or `1x1` (undersampling).
    pub mode: String,
    /// Rays.
    pub rays: u64,
}

/// A sampling policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Policy {
    /// Name, as the points use it.
    pub name: String,
    /// One sentence.
    pub summary: String,
    /// Every value, as a policy file.
    pub config_toml: String,
}

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
    /// What the policy is: `full`, `adaptive`, `multirate`, `foveated`.
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

/// What the paper states.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct References {
    /// Which policy does what the paper evaluated, by mode.
    pub policies: Vec<ModePolicy>,
    /// Performance per watt over full, T&I units alone (Figure 7), for both modes.
    pub gains: Vec<GainBand>,
    /// Power over full, mean of all scenes.
    pub power: Option<f64>,
    /// Table 1.
    pub psnr: Vec<PaperPsnr>,
    /// SRP cycles by kernel, mean of all scenes.
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
    /// Name of the kernel, as in [`Kernel`].
    pub kernel: String,
    /// Share of the cycles.
    pub share: f64,
}

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
    /// PSNR, dB; null for identical pictures or without a comparison.
    pub psnr_db: Option<f64>,
    /// Traced samples per sample of the grid.
    pub mean_rate: f64,
    /// Interpolated samples per sample that could have been; null where there are none.
    pub similarity_ratio: Option<f64>,
}

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
    /// PSNR, dB; null for identical pictures or without a comparison.
    pub psnr_db: Option<f64>,
}

/// The pictures of one scene under one policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewerSet {
    /// Name of the scene.
    pub scene: String,
    /// `2x2` or `1x1`.
    pub mode: String,
    /// Name of the policy.
    pub policy: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Tile edge, pixels; the last column and row of tiles may be cut off.
    pub tile_px: u32,
    /// The files.
    pub images: ViewerImages,
    /// The tiles, row by row; empty if not known.
    pub tiles: Vec<TileFigures>,
}

/// Picture files of a set. Each is shown at the size of the set, whatever its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewerImages {
    /// `full` in the same mode.
    pub reference: Option<String>,
    /// The policy's picture.
    pub result: Option<String>,
    /// Their difference.
    pub error: Option<String>,
    /// Similarity map.
    pub similarity: Option<String>,
    /// Rate map.
    pub rate: Option<String>,
}

/// A tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TileFigures {
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays traced.
    pub rays_traced: u64,
    /// Traced samples per sample of the grid.
    pub mean_rate: f64,
    /// Interpolated samples per sample that could have been; null where there are none.
    pub similarity_ratio: Option<f64>,
    /// PSNR, dB; null if nothing differs.
    pub psnr_db: Option<f64>,
}

/// A value of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfigValue {
    /// Key, such as `ti.trv`.
    pub key: String,
    /// Value.
    pub value: String,
    /// Unit; may be empty.
    pub unit: String,
    /// How well it is known, such as `paper`.
    pub class: String,
    /// Where it is from.
    pub source: String,
}
