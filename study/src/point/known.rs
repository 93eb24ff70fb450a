//! What a row says of its figures where not every cycle was simulated: how much was, and how far they may be off.
//!
//! A row of every cycle has none of these columns: it is what it was before there were estimates.

use serde_json::Value;

use crate::report::detail::DRAM_BYTES;
use crate::table::Role;
use rayreel_replay::Detail;

/// Share of the tiles, windows and frames that were simulated: column, key in a report, unit, meaning.
const EXTENT: [(&str, &str, &str, &str); 3] = [
    ("detail_fraction", "fraction", "1", "share of the tiles that was simulated cycle by cycle; the rest is estimated"),
    ("detail_windows", "windows", "windows", "windows of tiles that were simulated cycle by cycle"),
    ("detail_whole_frames", "whole_frames", "frames", "frames that were simulated whole though a sample was asked for"),
];

/// Figures that have a column for their interval; those of all others stand in [`INTERVALS`].
const KEYS: [&str; 10] = [
    "cycles",
    "time_ms",
    "fps",
    "power_w",
    "energy_mj",
    "perf_per_watt",
    "gpu_power_w",
    "gpu_energy_mj",
    "gpu_perf_per_watt",
    DRAM_BYTES,
];

/// The end of their names.
const ENDING: &str = "_interval_percent";

/// The column of a figure's interval, if it has one by itself.
pub fn interval_of(figure: &str) -> String {
    format!("{figure}{ENDING}")
}

/// Intervals of all figures and counters, percent by column, as JSON.
pub const INTERVALS: &str = "interval_percent";

/// Replicates of some figures, as JSON: [`DetailReport::replicates`](crate::report::detail::DetailReport::replicates).
pub const REPLICATES: &str = "replicates";

/// Gives the columns of the `detail` of a report to `add`: name, unit, meaning, value. None where every cycle was simulated.
pub(crate) fn add(detail: &Value, mut add: impl FnMut(&str, &str, &str, &Value)) {
    if detail["mode"].as_str().is_none_or(|mode| mode == Detail::Full.mode()) {
        return;
    }
    for (column, key, unit, description) in EXTENT {
        add(column, unit, description, &detail[key]);
    }
    for name in KEYS {
        let description =
            format!("half the width of the 95 % interval of {name}, in percent of it; null if it is exact");
        add(&interval_of(name), "%", &description, &detail["interval_percent"][name]);
    }
    add(INTERVALS, "%", "the same of every figure and counter that is estimated, JSON", &detail["interval_percent"]);
    let description = "by how much each replicate of a figure differs from its estimate, in millionths, JSON: equal windows of \
                       two runs stand at equal places, so ratios of them have intervals of their own";
    add(REPLICATES, "1e-6", description, &detail["replicates"]);
}

/// What such a column is to a reader.
pub(crate) fn role(name: &str) -> Option<Role> {
    let is_extent = EXTENT.iter().any(|(column, ..)| *column == name);
    let is_interval = name.strip_suffix(ENDING).is_some_and(|figure| KEYS.contains(&figure));
    match name {
        INTERVALS | REPLICATES => Some(Role::Config),
        _ => (is_extent || is_interval).then_some(Role::Status),
    }
}

/// The detail that a report as JSON was made with, as a plan or a command line would ask for it; none without a machine.
pub fn detail_text(report: &Value) -> Option<String> {
    let detail = &report["detail"];
    let mode = detail["mode"].as_str()?;
    let text = match (detail["asked"].as_f64(), detail["precision"].as_f64()) {
        (Some(share), _) => share.to_string(),
        (_, Some(share)) => format!("precision {share}"),
        _ => mode.to_owned(),
    };
    Some(text)
}
