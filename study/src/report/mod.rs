//! The report of a replay: what `rayreel replay --json` prints, and a table for people.
//!
//! No wall-clock figure stands here: the bytes are a pure function of trace, policy and machine. Ratios are made here from the
//! integer counts.

mod counters;
pub mod detail;
pub mod extent;
pub(crate) mod flat;
mod format;
mod page;
pub mod run;
mod sampling;
mod text;

use rayreel_formats::scene::Meta;
use serde::Serialize;
use serde_json::{Map, Value, json};

use self::detail::DetailReport;
use self::run::ComponentReport;

use crate::error::{Result, StudyError};
use crate::figures::{self, RunFigures, SamplingFigures};
use rayreel_machine::config::{MachineConfig, NamedMachine};
use rayreel_replay::counts::{FrameStats, TileStats};
use rayreel_replay::image::psnr::SquaredError;
use rayreel_replay::policy::{NamedPolicy, Policy};
use rayreel_replay::simulate::MachineRun;

/// What the results are of, as the caller knows it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// What made them.
    pub made: Option<Made>,
    /// Name of the trace.
    pub trace: String,
    /// What the trace holds ([`rayreel_formats::trace::Trace::fingerprint`]), if the caller has it.
    pub trace_fingerprint: Option<String>,
    /// Digest of the trace, if the caller has it: making it reads the trace once more.
    pub trace_digest: Option<String>,
}

/// What made results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Made {
    /// The program and its version.
    pub program: String,
    /// Version of everything between a trace and a result ([`crate::point::version::MODEL_VERSION`]): results of one version may be
    /// compared.
    pub model_version: u32,
    /// A command line that gives these results, in a folder that holds the trace and the files that it names. What changes no result
    /// is left out of it.
    pub command: String,
}

/// The results of a replay. [`crate::figures`] says what each figure means, and in which unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// What made them; left out where the caller does not say.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub made: Option<Made>,
    /// Name of the trace.
    pub trace: String,
    /// What the trace holds, known without reading its tiles: the same as in a sweep's table.
    pub trace_fingerprint: Option<String>,
    /// Digest of the trace, as `rayreel digest` prints it; null where not every cycle of every frame was asked for.
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
    pub sum: SamplingFigures,
    /// Time, speed and cost of all frames on the machine.
    #[serde(flatten)]
    pub run: RunFigures,
    /// Each frame.
    pub frames: Vec<FrameReport>,
    /// How much of the frames the machine simulated, and how far the figures may be off; null without one.
    pub detail: Option<DetailReport>,
    /// What the machine counted, by name; null without a machine.
    pub counters: Value,
    /// What each issue stage of each unit did; null without a machine.
    pub units: Value,
    /// Energy by component; null without a machine.
    pub energy: Option<Vec<ComponentReport>>,
    /// Area by component, mm2; null without a machine.
    pub area_mm2: Value,
    /// Every value of the machine; null without one.
    pub machine_config: Value,
    /// Unit and meaning of the keys.
    pub descriptions: Value,
    /// The machine and what it did, for the printed page.
    #[serde(skip)]
    pub machine_run: Option<(MachineConfig, MachineRun)>,
}

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameReport {
    /// Frame number.
    pub frame: u32,
    /// Its figures.
    #[serde(flatten)]
    pub figures: SamplingFigures,
    /// Time, speed and cost of it on the machine.
    #[serde(flatten)]
    pub run: RunFigures,
    /// How far its figures may be off, counters left out; left out if they are not estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detail: Option<DetailReport>,
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
            made: origin.made.clone(),
            trace: origin.trace.clone(),
            trace_fingerprint: origin.trace_fingerprint.clone(),
            trace_digest: origin.trace_digest.clone(),
            scene: meta.scene.clone(),
            machine: None,
            policy: policy.name.clone(),
            policy_config: policy.policy.clone(),
            width: meta.width,
            height: meta.height,
            samples_per_axis: meta.samples,
            tile: meta.tile,
            sum: SamplingFigures::new(frames),
            run: RunFigures::default(),
            frames: frames.iter().map(FrameReport::new).collect(),
            detail: None,
            counters: Value::Null,
            units: Value::Null,
            energy: None,
            area_mm2: Value::Null,
            machine_config: Value::Null,
            descriptions: descriptions(),
            machine_run: None,
        }
    }

    /// The same with what `machine` did with each of the frames.
    #[must_use]
    pub fn with_machine(mut self, machine: &NamedMachine, runs: &[MachineRun]) -> Self {
        let mut all = MachineRun::default();
        for (frame, run) in self.frames.iter_mut().zip(runs) {
            frame.run = RunFigures::new(&machine.config, run, 1);
            frame.detail = run.estimate.as_ref().map(|_| DetailReport::new(&machine.config, run, 1, false));
            all.add(run);
        }
        self.run = RunFigures::new(&machine.config, &all, runs.len());
        self.machine = Some(machine.name.clone());
        let detail = DetailReport::new(&machine.config, &all, runs.len(), true);
        let timeless = detail.is_counts();
        self.counters = if timeless { counters::timeless(&machine.config, &all) } else { counters::counters(&all) };
        self.units = if timeless { Value::Null } else { counters::units(&all.stats) };
        self.energy = Some(run::components(&machine.config, &all.energy, self.run.time_ms, timeless));
        self.area_mm2 = run::area(&machine.config);
        self.detail = Some(detail);
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

/// Unit and meaning of the figures, by key.
fn descriptions() -> Value {
    let entry = |figure: &figures::Figure| {
        (figure.name.to_owned(), json!({ "unit": figure.unit, "description": figure.description }))
    };
    Value::Object(figures::figures().iter().map(entry).collect::<Map<_, _>>())
}

/// Every value of a machine with what is known about it.
fn machine_config(machine: &NamedMachine) -> Value {
    let value = |v: &rayreel_machine::config::Sourced| {
        (v.key.to_owned(), json!({ "value": v.value, "class": v.class.name(), "source": v.source }))
    };
    Value::Object(machine.values.iter().map(value).collect::<Map<_, _>>())
}

impl FrameReport {
    fn new(stats: &FrameStats) -> Self {
        Self {
            frame: stats.frame,
            figures: SamplingFigures::new(std::slice::from_ref(stats)),
            run: RunFigures::default(),
            detail: None,
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
