//! The result of a point: a pure function of its key.
//!
//! Who computed it, when and how long it took is no part of a row: that is what makes a second attempt harmless.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::figures;
use crate::point::key::Key;
use crate::point::known;
use crate::report::Report;
use crate::report::flat::cells;
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
    /// Figures and counters by column: numbers, flags or null. A row of estimates also has what is known of them, of which some
    /// are objects.
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

/// What a column of a row is.
pub fn role_of(name: &str) -> Role {
    if let Some(role) = known::role(name) {
        return role;
    }
    if figures::column(name).is_some_and(|column| column.is_figure) { Role::Figure } else { Role::Counter }
}

impl Row {
    /// The row of a point that cannot be computed, whoever tries.
    pub fn failed(key: Key, error: String) -> Self {
        Self { key, error: Some(error), figures: Map::new() }
    }

    /// The row of a report, with what its columns are.
    pub fn new(key: Key, report: &Report) -> (Self, Vec<Column>) {
        Self::of_json(key, &serde_json::to_value(report).expect("keys are words, and numbers are no maps"))
    }

    /// The row of a report as `rayreel replay --json` prints it.
    pub fn of_json(key: Key, value: &Value) -> (Self, Vec<Column>) {
        let mut row = Builder::default();
        for cell in cells(value) {
            row.add(&cell.name, cell.unit, &cell.description, cell.value);
        }
        known::add(&value["detail"], |name, unit, description, value| row.add(name, unit, description, value));
        (Self { key, error: None, figures: row.values }, row.columns)
    }
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
}
