//! The result of a point: a pure function of its key.
//!
//! Who computed it, when and how long it took is no part of a row: that is what makes a second attempt harmless.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::figures::{self, COMPONENT_PARTS};
use crate::point::key::Key;
use crate::report::Report;
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

/// Whether a column of a row is a figure or a counter.
pub fn role_of(name: &str) -> Role {
    if figures::column(name).is_some_and(|column| column.is_figure) { Role::Figure } else { Role::Counter }
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
        let mut row = Builder::default();
        for column in figures::columns() {
            row.add(&column.name, column.unit, &column.description, column.value(value));
        }
        for component in value["energy"].as_array().into_iter().flatten() {
            row.add_component(component);
        }
        for (name, counter) in value["counters"].as_object().into_iter().flatten() {
            let word = |key: &str| counter[key].as_str().unwrap_or_default();
            row.add(&plain(name), word("unit"), word("description"), &counter["value"]);
        }
        (Self { key, error: None, figures: row.values }, row.columns)
    }
}

/// A name that needs no quotes in SQL.
pub(crate) fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect()
}

/// The values of a row in the making, and what its columns are.
#[derive(Default)]
struct Builder {
    values: Map<String, Value>,
    columns: Vec<Column>,
}

impl Builder {
    /// Adds a value; of two of one name the first stands.
    fn add(&mut self, name: &str, unit: &str, description: &str, value: &Value) {
        if self.values.contains_key(name) {
            return;
        }
        self.values.insert(name.to_owned(), value.clone());
        self.columns.push(Column { name: name.into(), unit: unit.into(), description: description.into() });
    }

    /// Adds the energy of a component.
    fn add_component(&mut self, component: &Value) {
        let name = component["name"].as_str().unwrap_or_default();
        for part in COMPONENT_PARTS {
            let text = format!("energy of {name}, {}", part.word);
            self.add(&format!("energy_{}_{}", plain(name), part.key), "mJ", &text, &component[part.key]);
        }
    }
}
