//! The report of a replay: what `rayreel replay --json` prints, and a table for people.
//!
//! No wall-clock figure stands here: the bytes are a pure function of trace, policy and machine. Ratios are made here from the
//! integer counts.

mod counters;
mod format;
pub mod keys;
mod page;
pub mod run;
pub mod table;

use rayreel_formats::scene::Meta;
use serde::Serialize;
use serde_json::{Map, Value, json};

use self::run::{ComponentReport, RunFigures};

use crate::error::{Result, StudyError};
use rayreel_machine::config::{MachineConfig, NamedMachine};
use rayreel_replay::counts::{Counts, FrameStats, RayCounts, TileStats};
use rayreel_replay::image::compare::{Quality, WorstTile};
use rayreel_replay::image::psnr::{SquaredError, decibels};
use rayreel_replay::policy::{NamedPolicy, Policy};
use rayreel_replay::simulate::MachineRun;

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
    /// Name of the machine; null without one.
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
    /// What the machine made of all frames.
    #[serde(flatten)]
    pub run: RunFigures,
    /// Each frame.
    pub frames: Vec<FrameReport>,
    /// What the machine counted, by name; null without a machine.
    pub counters: Value,
    /// What each issue stage of each unit did; null without a machine.
    pub units: Value,
    /// Energy by component; null without a machine.
    pub energy: Option<Vec<ComponentReport>>,
    /// Every value of the machine; null without one.
    pub machine_config: Value,
    /// Unit and meaning of the keys.
    pub descriptions: Value,
    /// The machine and what it did, for the printed page.
    #[serde(skip)]
    pub machine_run: Option<(MachineConfig, MachineRun)>,
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
    /// Factor on the colour limit, mean over the tiles.
    pub limit_factor: Option<f64>,
    /// Pixels that the policy traced whole to see its error.
    pub audited_pixels: u64,
    /// PSNR of these before they were traced, dB: what the policy takes its PSNR for; null if nothing differed, or without audits.
    pub audited_psnr_db: Option<f64>,
    /// PSNR, dB; null for identical pictures, or without a comparison.
    pub psnr_db: Option<f64>,
    /// SSIM; null for pictures below 11 pixels, or without a comparison.
    pub ssim: Option<f64>,
    /// Mean FLIP value; null without a comparison.
    pub flip: Option<f64>,
    /// PSNR of the worst tile, dB; null for identical pictures, or without a comparison.
    pub worst_tile_psnr_db: Option<f64>,
    /// Number of the worst tile in its frame.
    pub worst_tile: Option<u32>,
    /// Frame of the worst tile.
    pub worst_tile_frame: Option<u32>,
    /// Flicker, 8-bit levels; null without two consecutive frames.
    pub flicker: Option<f64>,
    /// The same in dB; null also without flicker.
    pub flicker_db: Option<f64>,
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
    /// What the machine made of it.
    #[serde(flatten)]
    pub run: RunFigures,
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
    /// Factor on the colour limit.
    pub limit_factor: f64,
    /// PSNR, dB; null if nothing differs, or without a comparison.
    pub psnr_db: Option<f64>,
}

impl Report {
    /// The report of some replayed frames.
    pub fn new(origin: &Origin, policy: &NamedPolicy, meta: &Meta, frames: &[FrameStats]) -> Self {
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
            sum: Figures::new(frames),
            run: RunFigures::default(),
            frames: frames.iter().map(FrameReport::new).collect(),
            counters: Value::Null,
            units: Value::Null,
            energy: None,
            machine_config: Value::Null,
            descriptions: keys::descriptions(),
            machine_run: None,
        }
    }

    /// The same with what `machine` did with each of the frames.
    #[must_use]
    pub fn with_machine(mut self, machine: &NamedMachine, runs: &[MachineRun]) -> Self {
        let mut all = MachineRun::default();
        for (frame, run) in self.frames.iter_mut().zip(runs) {
            frame.run = RunFigures::new(&machine.config, run, 1);
            all.add(run);
        }
        self.run = RunFigures::new(&machine.config, &all, runs.len());
        self.machine = Some(machine.name.clone());
        self.counters = counters::counters(&all);
        self.units = counters::units(&all.stats);
        self.energy = Some(run::components(&all.energy, self.run.time_ms));
        self.machine_config = machine_config(machine);
        self.machine_run = Some((machine.config.clone(), all));
        self
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
        let text = serde_json::to_string_pretty(self).map_err(|e| StudyError::Usage { detail: e.to_string() })?;
        Ok(text + "\n")
    }
}

/// Every value of a machine with what is known about it.
fn machine_config(machine: &NamedMachine) -> Value {
    let value = |v: &rayreel_machine::config::Sourced| {
        (v.key.to_owned(), json!({ "value": v.value, "class": v.class.name(), "source": v.source }))
    };
    Value::Object(machine.values.iter().map(value).collect::<Map<_, _>>())
}

impl Figures {
    fn new(frames: &[FrameStats]) -> Self {
        let counts: Counts = frames.iter().map(|f| f.counts).sum();
        // Of all frames, or of none.
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

/// The mean; nothing of nothing. All frames have the same number of pixels.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

impl FrameReport {
    fn new(stats: &FrameStats) -> Self {
        Self {
            frame: stats.frame,
            figures: Figures::new(std::slice::from_ref(stats)),
            run: RunFigures::default(),
            tiles: stats.tiles.iter().map(|tile| TileReport::new(tile, &stats.tile_errors)).collect(),
        }
    }
}

impl TileReport {
    /// `errors` holds those of all tiles, or nothing if they were not compared.
    fn new(stats: &TileStats, errors: &[SquaredError]) -> Self {
        let counts = &stats.counts;
        Self {
            tile: stats.tile,
            rays_full: counts.rays_full.total(),
            rays_traced: counts.rays_traced.total(),
            rays_apron: counts.rays_apron.total(),
            samples_traced: counts.samples_traced,
            samples_interpolated: counts.samples_interpolated,
            similarity_ratio: counts.similarity_ratio(),
            limit_factor: stats.factor,
            psnr_db: errors.get(stats.tile as usize).and_then(|error| error.decibels()),
        }
    }
}
