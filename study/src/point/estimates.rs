//! How far the figures of a row may be off, and their ratios to those of another.
//!
//! Two runs that were estimated from the same windows of the picture have much in common, and replicates at equal places leave out
//! equal windows: so the ratio of the two is known better than each. Only under one policy do they read alike from DRAM. Where the
//! windows are of other tiles, or replicates are missing or of another number, the intervals add up as those of independent values.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use crate::point::known::{INTERVALS, REPLICATES};
use crate::report::detail::needs_memory;
use rayreel_replay::detail::{Floors, half_width, replicates_of_ratio};

/// The widest interval of a ratio, relative to it: an estimate that may be off by more is worth nothing, and a ratio whose reference may
/// be 0 would have none that can be written down.
const WIDEST: f64 = 100.0;

/// What a run was estimated from; nothing where that is not told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// Whose tiles the windows were laid over: the source, its frames, and the share of them that was asked for.
    pub tiles: Option<String>,
    /// Every value of the policy.
    pub policy: Option<Value>,
}

impl Sampled {
    /// What it is of some frames of a source (first, number) with a detail, under a policy as results keep it.
    pub fn new(source: &str, frames: (u32, u32), detail: &str, policy: &str) -> Self {
        let tiles = Some(format!("{source} {} {} {detail}", frames.0, frames.1));
        Self { tiles, policy: serde_json::from_str(policy).ok() }
    }
}

/// What is known of the estimates of a row; nothing of a row of every cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowEstimates {
    /// Half widths in percent by column.
    intervals: Map<String, Value>,
    freedom: u32,
    floors: Floors,
    /// Replicates over the estimate, by base figure.
    replicates: BTreeMap<String, Vec<f64>>,
    sampled: Sampled,
}

impl RowEstimates {
    /// What the figures of a row say.
    pub fn of_row(row: &Map<String, Value>, sampled: Sampled) -> Self {
        Self::new(row.get(INTERVALS).unwrap_or(&Value::Null), row.get(REPLICATES).unwrap_or(&Value::Null), sampled)
    }

    /// What two columns say, intervals and replicates, of a run.
    pub fn new(intervals: &Value, replicates: &Value, sampled: Sampled) -> Self {
        let freedom = replicates["freedom"].as_u64().unwrap_or(0);
        let part = |name: &str, least: f64| replicates[name].as_f64().map_or(least, |millionths| millionths * 1e-6);
        let least = Floors::default();
        let alone = part("floor", least.alone);
        let floors = Floors { alone, with_memory: part("floor_with_memory", least.with_memory) };
        let over = |millionths: &Value| 1.0 + millionths.as_f64().unwrap_or(0.0) * 1e-6;
        let list = |(name, list): (&String, &Value)| Some((name.clone(), list.as_array()?.iter().map(over).collect()));
        Self {
            intervals: intervals.as_object().cloned().unwrap_or_default(),
            freedom: u32::try_from(freedom).unwrap_or(u32::MAX),
            floors,
            replicates: replicates.as_object().into_iter().flatten().filter_map(list).collect(),
            sampled,
        }
    }

    /// Half the width of the 95 % interval of a column, relative to its value; 0 if it is exact or [unknown](Self::is_unknown).
    pub fn interval(&self, name: &str) -> f64 {
        self.intervals.get(name).and_then(Value::as_f64).map_or(0.0, |percent| percent / 100.0)
    }

    /// Whether the windows tell nothing of a column, which may be off by anything.
    pub fn is_unknown(&self, name: &str) -> bool {
        self.intervals.get(name).is_some_and(Value::is_null)
    }

    /// Half the width of the 95 % interval of its ratio to the column of another row, relative to that ratio.
    pub fn interval_of_ratio(&self, other: &Self, name: &str) -> f64 {
        let (of_self, of_other) = (&self.sampled, &other.sampled);
        // What is not told may be another.
        let same_tiles = of_self.tiles.is_some() && of_self.tiles == of_other.tiles;
        let alike = of_self.policy.is_some() && of_self.policy == of_other.policy;
        let width = match (self.of(name), other.of(name)) {
            (Some(of_self), Some(of_other)) if same_tiles && of_self.len() == of_other.len() => {
                let ratios = replicates_of_ratio((1.0, &of_self), (1.0, &of_other), alike);
                let of = |floors: &Floors| if needs_memory(name) { floors.with_memory } else { floors.alone };
                let floor = of(&self.floors).max(of(&other.floors));
                half_width(1.0, &ratios, self.freedom.min(other.freedom), floor)
            }
            _ => self.interval(name).hypot(other.interval(name)),
        };
        if width.is_finite() { width.min(WIDEST) } else { WIDEST }
    }

    /// Replicates of a column over its estimate: of a base figure, or of one that is a ratio of such.
    fn of(&self, name: &str) -> Option<Vec<f64>> {
        let named = |part: &'static str| Some((part, name.strip_prefix(part)?));
        let (part, cost) = named("ti_with_memory_").or_else(|| named("gpu_")).unwrap_or(("", name));
        let base = |name: &str| self.replicates.get(name);
        let (cycles, energy) = (base("cycles"), base(&format!("{part}energy_mj")));
        let each = |of: fn(f64, f64) -> f64| {
            Some(cycles?.iter().zip(energy?).map(|(cycles, energy)| of(*cycles, *energy)).collect())
        };
        match (part, cost) {
            ("", "cycles" | "time_ms") => cycles.cloned(),
            ("", "fps" | "mrays_per_s" | "mrays_per_mm2") | ("gpu_", "mrays_per_mm2") => each(|cycles, _| 1.0 / cycles),
            (_, "energy_mj" | "energy_per_ray_nj") => energy.cloned(),
            (_, "power_w") => each(|cycles, energy| energy / cycles),
            (_, "perf_per_watt") => each(|_, energy| 1.0 / energy),
            _ => base(name).cloned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use rayreel_replay::detail::FLOOR;

    fn run(replicates: Value) -> RowEstimates {
        let sampled = Sampled { tiles: Some("teapot".into()), policy: None };
        RowEstimates::new(&json!({ "cycles": 3.0, "perf_per_watt": 4.0 }), &replicates, sampled)
    }

    /// Replicates of which the last four say how far what is read from DRAM may be off.
    #[test]
    fn policies_do_not_share_what_they_read_from_dram() {
        let row = |source: &str, policy: &str| {
            let energy = [0, 0, 0, 9000, -9000, 0, 0];
            let replicates = json!({ "freedom": 4, "cycles": [0, 0, 0, 0, 0, 0, 0], "energy_mj": energy });
            let row = json!({ INTERVALS: { "energy_mj": 2.0 }, REPLICATES: replicates });
            RowEstimates::of_row(row.as_object().unwrap(), Sampled::new(source, (0, 1), "0.05", policy))
        };
        let full = row("teapot", r#"{"kind":"full","a":1}"#);
        let within = |source, policy| row(source, policy).interval_of_ratio(&full, "energy_mj");
        // Written in whatever order.
        assert!((within("teapot", r#"{"a": 1, "kind": "full"}"#) - FLOOR).abs() < 1e-12);
        let other = within("teapot", r#"{"kind":"full","a":2}"#);
        assert!(other > 4.0 * FLOOR, "{other}");
        // Of other tiles nothing cancels.
        assert!((within("chess", r#"{"kind":"full","a":1}"#) - 0.02 * 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_two_runs_share_cancels() {
        let a = run(json!({ "freedom": 4, "cycles": [9000, -9000, 0], "energy_mj": [10000, -10000, 0] }));
        let b = run(json!({ "freedom": 9, "cycles": [9000, -9000, 100], "energy_mj": [10000, -10000, 0] }));
        let within = |b: &RowEstimates, name| b.interval_of_ratio(&a, name);
        assert!(within(&b, "cycles") < 2.0 * FLOOR && within(&b, "cycles") > FLOOR);
        assert_eq!(within(&b, "perf_per_watt"), FLOOR);
        // Time and its inverse are known as well.
        assert!((within(&b, "time_ms") - within(&b, "fps")).abs() < 1e-5);
        let other = run(json!({ "freedom": 4, "cycles": [9000, -9000], "energy_mj": [10000, -10000] }));
        assert!((within(&other, "cycles") - 0.03 * 2f64.sqrt()).abs() < 1e-12, "other windows");
        let exact = RowEstimates::default();
        assert!((within(&exact, "perf_per_watt") - 0.04).abs() < 1e-12);
        assert_eq!((exact.interval_of_ratio(&exact, "cycles"), within(&b, "rays_traced")), (0.0, 0.0));
        assert_eq!((a.interval("cycles"), a.interval("rays_traced")), (0.03, 0.0));
        // A reference that may be nothing.
        let lost = run(json!({ "freedom": 4, "cycles": [-1_000_000, 900_000, 0], "energy_mj": [0, 0, 0] }));
        assert_eq!(a.interval_of_ratio(&lost, "cycles"), WIDEST);
    }
}
