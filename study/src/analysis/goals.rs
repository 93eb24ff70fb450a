//! Which way a result is better, and which results a reader asks for first.

use std::collections::BTreeMap;

use rayreel_replay::Detail;
use serde::Serialize;

use crate::figures::{Better, column};
use crate::table::{Cells, Results, Role};

/// Which way a result is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Goal {
    /// Less is better.
    Min,
    /// More is better.
    Max,
}

/// Results that a reader asks for first, in this order.
const HEADLINES: &[&str] =
    &["time_ms", "energy_mj", "gpu_energy_mj", "perf_per_watt", "gpu_perf_per_watt", "psnr_db", "flip", "rays_traced"];

/// How many of them a page shows without being asked.
const SHOWN: usize = 6;

/// Which way the result of this name is better. A chart needs a direction: what is neither better nor worse, and what the machine
/// counts, counts as work, of which less is better.
pub fn goal(name: &str) -> Goal {
    match column(name).map(|column| column.better) {
        Some(Better::More) => Goal::Max,
        Some(Better::Less | Better::Neither) | None => Goal::Min,
    }
}

/// The results to show first: those of `HEADLINES` that vary, or else the first columns of results that do. Where nothing varies, as
/// of a single point, those that are there.
pub fn headlines(results: &Results) -> Vec<&str> {
    let varying = varying(results);
    if varying.is_empty() { of_results(results, |name| known(results, name), known_cells) } else { varying }
}

/// The results to show first of those that vary.
fn varying(results: &Results) -> Vec<&str> {
    of_results(results, |name| varies_within(results, name), varies)
}

/// Results of `HEADLINES`, or else of all columns.
fn of_results(results: &Results, is_headline: impl Fn(&str) -> bool, is_wanted: impl Fn(&Cells) -> bool) -> Vec<&str> {
    let shown = HEADLINES.iter().copied().filter(|name| is_headline(name) && !lacks_part(results, name));
    let first: Vec<&str> = shown.take(SHOWN).collect();
    if !first.is_empty() {
        return first;
    }
    let other = results.fields.iter().filter(|f| matches!(f.role, Role::Figure | Role::Counter) && is_wanted(&f.cells));
    other.map(|field| field.name.as_str()).take(SHOWN).collect()
}

/// Points of which no cycle was simulated, if there are any.
pub fn counted_only(results: &Results) -> usize {
    let Some(field) = results.field("detail") else { return 0 };
    (0..field.cells.len()).filter(|row| field.cells.text(*row).as_deref() == Some(Detail::Counts.mode())).count()
}

/// Whether a result of some points is a part of what it is of others: without time nobody knows what leakage and waiting cost, so
/// no point is the best one in energy.
fn lacks_part(results: &Results, name: &str) -> bool {
    name.ends_with("energy_mj") && counted_only(results) > 0
}

/// Whether a result has a number.
fn known(results: &Results, name: &str) -> bool {
    results.field(name).is_some_and(|field| known_cells(&field.cells))
}

/// Whether a column has a number.
fn known_cells(cells: &Cells) -> bool {
    (0..cells.len()).any(|row| cells.number(row).is_some())
}

/// Whether a column holds two different numbers.
pub fn varies(cells: &Cells) -> bool {
    let mut numbers = (0..cells.len()).filter_map(|row| cells.number(row));
    let first = numbers.next();
    numbers.any(|other| Some(other) != first)
}

/// Whether a result has two different numbers on the same trace: what differs between traces says
/// nothing of machine or policy.
pub fn varies_within(results: &Results, name: &str) -> bool {
    let Some(field) = results.field(name) else { return false };
    let trace = |row: usize| results.field("trace").and_then(|field| field.cells.text(row));
    let mut known = BTreeMap::new();
    let numbers = (0..field.cells.len()).filter_map(|row| Some((row, field.cells.number(row)?)));
    numbers.into_iter().any(|(row, number)| *known.entry(trace(row)).or_insert(number) != number)
}

/// What the first chart may show; the first pair that varies.
fn first_pairs(whole_gpu: bool) -> [[&'static str; 2]; 4] {
    [
        ["psnr_db", "perf_per_watt"],
        ["time_ms", if whole_gpu { "gpu_energy_mj" } else { "energy_mj" }],
        ["cycles", "energy_mj"],
        ["psnr_db", "rays_traced"],
    ]
}

/// The two results of the first chart. If pictures differ it is quality against efficiency, else time against energy: the energy of
/// the whole GPU if the sweep changes more than the T&I units.
pub fn first_pair(results: &Results, whole_gpu: bool) -> Option<[&str; 2]> {
    let pairs = first_pairs(whole_gpu);
    let known = |name: &str| results.field(name).map(|field| field.name.as_str());
    let shown = |name: &&str| varies_within(results, name) && !lacks_part(results, name);
    let pair = pairs.iter().find(|pair| pair.iter().all(shown));
    if let Some([x, y]) = pair {
        return Some([known(x)?, known(y)?]);
    }
    let other = varying(results);
    Some([other.first()?, other.get(1).or(other.first())?])
}

#[cfg(test)]
mod tests {
    use super::super::tables::{figure, table, words};
    use super::*;
    use crate::figures::columns;

    #[test]
    fn every_goal_is_that_of_the_table_of_figures() {
        let more: Vec<&str> =
            columns().iter().map(|c| c.name.as_str()).filter(|name| goal(name) == Goal::Max).collect();
        assert_eq!(
            more,
            [
                "rays_saved",
                "samples_interpolated",
                "similarity_ratio",
                "audited_psnr_db",
                "psnr_db",
                "ssim",
                "worst_frame_psnr_db",
                "worst_tile_psnr_db",
                "flicker_db",
                "identical",
                "fps",
                "mrays_per_s",
                "perf_per_watt",
                "mrays_per_mm2",
                "gpu_mrays_per_mm2",
                "ti_with_memory_perf_per_watt",
                "gpu_perf_per_watt",
            ]
        );
        assert_eq!(goal("ti_trv_l1_hits"), Goal::Min, "a counter");
    }

    #[test]
    fn what_is_shown_first_is_a_figure_that_is_better_or_worse() {
        let pairs = [first_pairs(false), first_pairs(true)].concat().concat();
        for name in HEADLINES.iter().chain(&pairs) {
            assert!(column(name).is_some_and(|c| c.is_figure && c.better != Better::Neither), "{name}");
        }
    }

    /// What was counted without time lacks a part of its energy, and would come out as the best.
    #[test]
    fn energies_rank_nothing_where_some_were_only_counted() {
        let of = |details: &[&str]| {
            let varying = |name| figure(name, &[1.0, 2.0]);
            table(vec![
                words("detail", Role::Point, details),
                varying("energy_mj"),
                varying("gpu_energy_mj"),
                varying("psnr_db"),
            ])
        };
        assert_eq!(headlines(&of(&["full", "sampled"])), ["energy_mj", "gpu_energy_mj", "psnr_db"]);
        let mixed = of(&["full", "counts"]);
        assert_eq!((headlines(&mixed), counted_only(&mixed)), (vec!["psnr_db"], 1));
    }

    #[test]
    fn the_first_chart_depends_on_what_varies() {
        let (same, varying) = (|name| figure(name, &[1.0, 1.0]), |name| figure(name, &[1.0, 2.0]));
        let pictures = table(vec![varying("time_ms"), varying("perf_per_watt"), varying("psnr_db")]);
        assert_eq!(first_pair(&pictures, true), Some(["psnr_db", "perf_per_watt"]));
        let machines = table(vec![varying("time_ms"), varying("energy_mj"), varying("gpu_energy_mj"), same("psnr_db")]);
        assert_eq!(first_pair(&machines, false), Some(["time_ms", "energy_mj"]));
        assert_eq!(first_pair(&machines, true), Some(["time_ms", "gpu_energy_mj"]));
        assert_eq!(headlines(&machines), ["time_ms", "energy_mj", "gpu_energy_mj"]);
        assert_eq!(first_pair(&table(vec![varying("odd")]), true), Some(["odd", "odd"]));
        assert_eq!(first_pair(&table(vec![same("odd")]), true), None);
        // Of one point, or of equal ones, what there is.
        let none = figure("psnr_db", &[f64::NAN, f64::NAN]);
        assert_eq!(headlines(&table(vec![same("odd"), none.clone(), same("energy_mj")])), ["energy_mj"]);
        assert_eq!(headlines(&table(vec![same("odd"), none])), ["odd"]);
        // Another scene has another PSNR whatever the machine: that is no reason to show it first.
        let scenes = words("trace", Role::Point, &["a", "a", "b", "b"]);
        let four = |name, values: [f64; 4]| figure(name, &values);
        let two = table(vec![
            scenes,
            four("psnr_db", [30.0, 30.0, 40.0, 40.0]),
            four("perf_per_watt", [1.0, 2.0, 3.0, 4.0]),
            four("time_ms", [1.0, 2.0, 3.0, 4.0]),
            four("energy_mj", [1.0, 2.0, 3.0, 4.0]),
        ]);
        assert_eq!(first_pair(&two, false), Some(["time_ms", "energy_mj"]));
        assert_eq!(headlines(&two), ["time_ms", "energy_mj", "perf_per_watt"]);
        assert_eq!(
            [goal("gpu_perf_per_watt"), goal("worst_tile_psnr_db"), goal("energy_mj")],
            [Goal::Max, Goal::Max, Goal::Min]
        );
    }
}
