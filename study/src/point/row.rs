//! The result of a point: a pure function of its key.
//!
//! Who computed it, when and how long it took is no part of a row: that is what makes a second attempt harmless.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::point::key::Key;
use crate::report::Report;
use crate::report::keys::FIGURES;
use crate::table::Role;

/// A result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The key of its point.
    pub key: Key,
    /// Why there are no figures, for a point that cannot be computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Figures and counters by column: numbers, flags or null.
    pub figures: Map<String, Value>,
}

/// A column of figures.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
    /// What they are.
    pub description: String,
}

/// Figures of a report that stand in no row: they are no single value, or stand in a row under another name.
const LEFT_OUT: &[&str] = &[
    "trace",
    "trace_digest",
    "scene",
    "machine",
    "policy",
    "policy_config",
    "width",
    "height",
    "samples_per_axis",
    "tile",
    "frames",
    "tiles",
    "frame",
    "rays_by_kind",
    "counters",
    "units",
    "energy",
    "machine_config",
    "descriptions",
];

/// Groups of figures that become columns `group_name`.
const GROUPS: &[&str] = &["ti_with_memory", "gpu"];

/// Ray kinds of `rays_by_kind`, as columns `rays_KIND_full` and so on.
const KINDS: &[&str] = &["primary", "reflection", "refraction", "shadow"];

/// Whether results have a figure of this name.
pub fn is_figure(name: &str) -> bool {
    FIGURES.iter().any(|(key, ..)| *key == name)
}

/// Whether a column of a row is a figure or a counter.
pub fn role_of(name: &str) -> Role {
    let grouped = GROUPS.iter().any(|group| name.strip_prefix(group).is_some_and(|rest| rest.starts_with('_')));
    if is_figure(name) || grouped { Role::Figure } else { Role::Counter }
}

impl Row {
    /// The row of a point that cannot be computed, whoever tries.
    pub fn failed(key: Key, error: String) -> Self {
        Self { key, error: Some(error), figures: Map::new() }
    }

    /// The row of a report, with what its columns are.
    pub fn new(key: Key, report: &Report) -> (Self, Vec<Column>) {
        Self::of_json(key, &serde_json::to_value(report).unwrap_or_default())
    }

    /// The row of a report as `rayreel replay --json` prints it.
    pub fn of_json(key: Key, value: &Value) -> (Self, Vec<Column>) {
        let mut own = Figures::default();
        for (name, unit, text) in FIGURES {
            if !LEFT_OUT.contains(name) && !GROUPS.contains(name) {
                own.add(name, unit, text, value[*name].clone());
            }
        }
        for group in GROUPS {
            for name in ["power_w", "energy_mj", "energy_per_ray_nj", "perf_per_watt"] {
                let of = FIGURES.iter().find(|(key, ..)| key == &name).map_or(("", ""), |(_, unit, text)| (unit, text));
                let what = if *group == "gpu" { "whole GPU" } else { "T&I units with their L2 and DRAM energy" };
                let text = format!(
                    "{what}: {}",
                    of.1.replace(", the group ti of energy", "").replace(" of the T&I units alone", "")
                );
                own.add(&format!("{group}_{name}"), of.0, &text, value[*group][name].clone());
            }
        }
        for kind in KINDS {
            for which in ["full", "traced", "apron"] {
                let name = format!("rays_{kind}_{which}");
                let text = format!("{kind} rays of rays_{which}");
                own.add(&name, "rays", &text, value["rays_by_kind"][which][*kind].clone());
            }
        }
        for component in value["energy"].as_array().into_iter().flatten() {
            let name = component["name"].as_str().unwrap_or_default();
            for part in ["dynamic_mj", "leakage_mj"] {
                let text = format!("energy of {name}, {}", if part == "dynamic_mj" { "dynamic" } else { "leakage" });
                own.add(&format!("energy_{}_{part}", plain(name)), "mJ", &text, component[part].clone());
            }
        }
        for (name, counter) in value["counters"].as_object().into_iter().flatten() {
            let word = |key: &str| counter[key].as_str().unwrap_or_default().to_owned();
            own.add(&plain(name), &word("unit"), &word("description"), counter["value"].clone());
        }
        (Self { key, error: None, figures: own.values }, own.columns)
    }
}

/// A name that needs no quotes in SQL.
pub(crate) fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect()
}

#[derive(Default)]
struct Figures {
    values: Map<String, Value>,
    columns: Vec<Column>,
}

impl Figures {
    /// Adds a figure. Of two of one name the first stands: `run/cycles` is `cycles` under its full name.
    fn add(&mut self, name: &str, unit: &str, description: &str, value: Value) {
        if self.values.contains_key(name) {
            return;
        }
        self.values.insert(name.to_owned(), value);
        self.columns.push(Column { name: name.into(), unit: unit.into(), description: description.into() });
    }
}
