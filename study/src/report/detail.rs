//! How much was simulated cycle by cycle, and how far the figures may be off where that is not all.
//!
//! No figure is named here: whatever a report says of the machine is computed again from each replicate of the estimate, and what
//! differs between them has an interval. So a figure that is added has one too.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::figures::RunFigures;
use crate::report::counters::counters;
use crate::report::flat::{cells, plain};
use crate::report::run::components;
use rayreel_machine::config::MachineConfig;
use rayreel_machine::functional::{counted_counters, exact_counters};
use rayreel_machine::stats::Stats;
use rayreel_replay::Detail;
use rayreel_replay::detail::{Estimate, WholeFrames, half_width};
use rayreel_replay::simulate::MachineRun;

/// Name of the bytes that DRAM read and wrote, among the intervals: no column by itself but the sum of some.
pub const DRAM_BYTES: &str = "dram_bytes";

/// Figures of which reports keep every replicate: the others of a run that matter to a comparison are ratios of these.
pub const BASE: &[&str] = &["cycles", "energy_mj", "ti_with_memory_energy_mj", "gpu_energy_mj", DRAM_BYTES];

/// What a report says of its detail.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DetailReport {
    /// `full`, `all`, `sampled`, `precision` or `counts`.
    pub mode: &'static str,
    /// The share of the tiles that was asked for; null if none was.
    pub asked: Option<f64>,
    /// The precision that was asked for; null if none was.
    pub precision: Option<f64>,
    /// The share of the tiles that was simulated cycle by cycle.
    pub fraction: f64,
    /// Windows that were simulated.
    pub windows: u64,
    /// Frames that were simulated whole.
    pub whole_frames: u64,
    /// How many of them for which reason, where a sample was asked for: a [`rayreel_replay::detail::WhyWhole`] by its name.
    pub whole_because: Map<String, Value>,
    /// Half the width of the 95 % interval of each figure that is estimated, in percent of its value, by the name of its column; null
    /// where nothing is known of it. What is not listed is exact.
    pub interval_percent: Map<String, Value>,
    /// Degrees of freedom of the intervals, and by how much the replicates of some figures differ from the estimate, in millionths
    /// of it: intervals of ratios between runs follow from these. Null where nothing is estimated.
    pub replicates: Value,
}

impl DetailReport {
    /// That of a run of so many frames; `whole` also gives the intervals of all that was counted.
    pub(super) fn new(config: &MachineConfig, run: &MachineRun, frames: usize, whole: bool) -> Self {
        let Some(estimate) = &run.estimate else { return Self::full(frames) };
        let known = Known { config, frames, whole };
        let mut report = Self {
            mode: estimate.detail.mode(),
            asked: None,
            precision: None,
            fraction: estimate.fraction(),
            windows: estimate.windows,
            whole_frames: estimate.whole_frames.total(),
            whole_because: because(&estimate.whole_frames),
            interval_percent: Map::new(),
            replicates: Value::Null,
        };
        match estimate.detail {
            Detail::Sampled(share) => report.asked = Some(share.fraction()),
            Detail::Precision(share) => report.precision = Some(share.fraction()),
            Detail::Full | Detail::All | Detail::Counts => {}
        }
        if report.is_estimated() {
            let value = known.figures(run);
            let replicates: Vec<BTreeMap<String, f64>> = replicates(run, estimate).map(|r| known.figures(&r)).collect();
            report.interval_percent = intervals(&value, &replicates, estimate, &known.counters());
            report.replicates = deviations(&value, &replicates, estimate);
        } else if report.is_counts() {
            report.interval_percent = known.approximate(run);
        }
        report
    }

    fn full(frames: usize) -> Self {
        Self {
            mode: Detail::Full.mode(),
            asked: None,
            precision: None,
            fraction: 1.0,
            windows: 0,
            whole_frames: frames as u64,
            whole_because: Map::new(),
            interval_percent: Map::new(),
            replicates: Value::Null,
        }
    }

    /// Whether any figure is an estimate. Without windows every cycle was simulated after all, or none.
    pub fn is_estimated(&self) -> bool {
        self.windows > 0
    }

    /// Whether no cycle was simulated.
    pub fn is_counts(&self) -> bool {
        self.mode == Detail::Counts.mode()
    }

    /// Half the width of the interval of the figure of a column, in percent of its value; none if it is exact.
    pub fn interval(&self, column: &str) -> Option<f64> {
        self.interval_percent.get(column)?.as_f64()
    }

    /// Whether nothing is known of how far a figure may be off: what windows say of it may be anything.
    pub fn is_unknown(&self, column: &str) -> bool {
        self.interval_percent.get(column).is_some_and(Value::is_null)
    }
}

/// The reasons of frames that were simulated whole, by their names.
fn because(frames: &WholeFrames) -> Map<String, Value> {
    frames.reasons().map(|(why, count)| (why.name().to_owned(), count.into())).collect()
}

/// The runs of which the replicates of an estimate tell.
fn replicates<'a>(run: &'a MachineRun, estimate: &'a Estimate) -> impl Iterator<Item = MachineRun> + 'a {
    estimate.replicates.iter().map(|replicate| MachineRun {
        stats: replicate.stats.clone(),
        energy: replicate.energy.clone(),
        paths: run.paths,
        estimate: None,
    })
}

/// Half the width of the interval of bytes of DRAM, as a part of the value, where all is simulated in windows: up to 1.3 % was seen.
const SEAMS_OF_DRAM: f64 = 0.015;

/// Cycles in which an SRP has nothing to do come at the ends of a frame and now and then between. Windows see few of these, and what they
/// say of the others was a quarter to two and a half times what there are (docs/detail.md).
const SELDOM: [&str; 2] = ["srp_activity_idle", "srp_activity_border"];

/// Whether windows tell nothing of a counter, for what it counts comes in bursts: few tiles bring most of it, and refusals
/// were estimated as a hundredth of what they are (docs/detail.md).
fn comes_in_bursts(name: &str) -> bool {
    SELDOM.contains(&name)
        || name.starts_with("dram_refused_")
        || ["_l1_full", "l2_full", "l2_blocked", "_mshr"].iter().any(|ending| name.ends_with(ending))
}

/// What figures are made with.
struct Known<'a> {
    config: &'a MachineConfig,
    frames: usize,
    /// Counters and components too.
    whole: bool,
}

impl Known<'_> {
    /// The counters by name, and whether they are the same whenever things happen.
    fn counters(&self) -> BTreeMap<String, bool> {
        let mut marks = self.marks(exact_counters(self.config));
        marks.iter_mut().for_each(|(name, mark)| *mark |= is_counted(name));
        marks
    }

    /// Whether a counter is marked, by its name.
    fn marks(&self, stats: Stats) -> BTreeMap<String, bool> {
        let marks = counters(&MachineRun { stats, ..MachineRun::default() });
        let marked =
            |(name, mark): (&String, &Value)| (plain(name), mark["value"].as_u64().is_some_and(|mark| mark > 0));
        marks.as_object().into_iter().flatten().map(marked).collect()
    }

    /// What a pass without time knows nearly, but not how nearly: what caches find, and energies, for which nothing waits.
    fn approximate(&self, run: &MachineRun) -> Map<String, Value> {
        let (exact, counted) = (self.counters(), self.marks(counted_counters(self.config)));
        let is_near = |name: &String| match exact.get(name) {
            Some(exact) => !exact && counted.get(name) == Some(&true),
            None => name == DRAM_BYTES || name.split('_').any(|word| word == "energy"),
        };
        self.figures(run).into_keys().filter(is_near).map(|name| (name, Value::Null)).collect()
    }

    /// Every number that a report says of a run, by the name of its column.
    fn figures(&self, run: &MachineRun) -> BTreeMap<String, f64> {
        let figures = RunFigures::new(self.config, run, self.frames);
        let mut value = json!(figures);
        if self.whole {
            value["counters"] = counters(run);
            let timeless = run.estimate.as_ref().is_some_and(|estimate| estimate.detail == Detail::Counts);
            value["energy"] = json!(components(self.config, &run.energy, figures.time_ms, timeless));
        }
        let numbers = cells(&value).filter_map(|cell| Some((cell.name, cell.value.as_f64()?)));
        numbers.chain([(DRAM_BYTES.to_owned(), run.stats.memory.traffic.total() as f64)]).collect()
    }
}

/// The interval of each figure in percent; none for those that are exact. `counters` says by name whether a counter is.
fn intervals(
    value: &BTreeMap<String, f64>,
    replicates: &[BTreeMap<String, f64>],
    estimate: &Estimate,
    counters: &BTreeMap<String, bool>,
) -> Map<String, Value> {
    let (mut all, floors) = (Map::new(), estimate.floors());
    for (name, value) in value {
        let values: Vec<f64> = replicates.iter().filter_map(|replicate| replicate.get(name).copied()).collect();
        let agree = values.iter().all(|v| v == value);
        let interval = || {
            let seams = if values.is_empty() && name == DRAM_BYTES { SEAMS_OF_DRAM } else { 0.0 };
            let floor = if needs_memory(name) { floors.with_memory } else { floors.alone };
            json!(rounded(100.0 * (half_width(*value, &values, estimate.freedom, floor) / value.abs()).max(seams)))
        };
        let known = match counters.get(name) {
            Some(true) => continue,
            // What moved in no window, or in those alone that stand for themselves, may have moved between them; how far seams move
            // counters where all is simulated was not measured; and of zero no part can be said.
            Some(false) if agree || *value == 0.0 || comes_in_bursts(name) => Value::Null,
            Some(false) => interval(),
            // A figure that all replicates agree on follows from what is exact.
            None if is_counted(name) || *value == 0.0 || (agree && !values.is_empty()) => continue,
            None => interval(),
        };
        all.insert(name.clone(), known);
    }
    all
}

/// Whether a figure is one of L2 and DRAM, or has their energy in it. Rays a second and area are of time alone, whatever the area.
pub fn needs_memory(name: &str) -> bool {
    let of_memory =
        ["ti_with_memory_", "gpu_", "l2_", "dram_", "traffic_", "energy_l2", "energy_network", "energy_dram"];
    name != "gpu_mrays_per_mm2" && of_memory.iter().any(|part| name.starts_with(part))
}

/// Whether a figure of the machine is counted in any case: known by its name where no replicate shows it.
fn is_counted(name: &str) -> bool {
    ["rays_machine", "run_tiles"].contains(&name) || name.starts_with("paths_") || name.ends_with("area_mm2")
}

/// To four digits behind the point: an interval is no measurement.
fn rounded(percent: f64) -> f64 {
    (percent * 1e4).round() * 1e-4
}

/// The replicates of the base figures.
fn deviations(value: &BTreeMap<String, f64>, replicates: &[BTreeMap<String, f64>], estimate: &Estimate) -> Value {
    let freedom = estimate.freedom;
    if replicates.len() < 2 || freedom == 0 {
        return Value::Null;
    }
    let floors = estimate.floors();
    let floors = [("floor", floors.alone), ("floor_with_memory", floors.with_memory)];
    let floors = floors.map(|(name, part)| (name.to_owned(), json!((part * 1e6).round())));
    let mut all = Map::from_iter([("freedom".to_owned(), json!(freedom))].into_iter().chain(floors));
    for name in BASE {
        let Some(estimate) = value.get(*name).filter(|v| **v != 0.0) else { continue };
        let millionths = |replicate: &BTreeMap<String, f64>| {
            let of = replicate.get(*name).copied().unwrap_or(*estimate);
            ((of / estimate - 1.0) * 1e6).round() as i64
        };
        all.insert((*name).to_owned(), replicates.iter().map(millionths).collect());
    }
    Value::Object(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_the_memory_in_it_is_known_by_name() {
        assert!(["gpu_energy_mj", "gpu_power_w", "l2_misses", "energy_dram_mj"].into_iter().all(needs_memory));
        assert!(
            !["cycles", "energy_mj", "mrays_per_s", "mrays_per_mm2", "gpu_mrays_per_mm2"].into_iter().any(needs_memory)
        );
    }
}
