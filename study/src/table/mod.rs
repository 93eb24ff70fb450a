//! The results of a sweep as a table: one row a point, typed columns with units.

#[cfg(feature = "parquet")]
mod bounded;
pub mod csv;
#[cfg(any(feature = "html", feature = "parquet"))]
pub(crate) mod guard;
#[cfg(feature = "parquet")]
pub mod parquet;

use serde::{Deserialize, Serialize};

/// What a column is to a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// What the point is: trace, machine, policy, frames, its number and key.
    Point,
    /// An axis of the plan.
    Axis,
    /// Whether it could be computed.
    Status,
    /// A result.
    Figure,
    /// A count of the machine or of the energy model.
    Counter,
    /// The resolved configuration.
    Config,
}

/// The values of a column; none where a point has no such value.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Whole numbers.
    Int(Vec<Option<i64>>),
    /// Numbers.
    Float(Vec<Option<f64>>),
    /// Flags.
    Flag(Vec<Option<bool>>),
    /// Words.
    Text(Vec<Option<String>>),
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name: letters, digits and underscores.
    pub name: String,
    /// Unit of its values; empty for words.
    pub unit: String,
    /// What they are.
    pub description: String,
    /// What it is to a reader.
    pub role: Role,
    /// Its values, one a row.
    pub cells: Cells,
}

/// What the results are of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heading {
    /// Name of the plan.
    pub name: String,
    /// Id of the plan.
    pub plan: String,
    /// Version of the model.
    pub model_version: u32,
    /// Points of the plan; more than rows if some are missing.
    pub points: usize,
}

/// The table: all columns have the same number of rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// What they are of.
    pub heading: Heading,
    /// The columns.
    pub fields: Vec<Field>,
}

impl Cells {
    /// How many rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Int(cells) => cells.len(),
            Self::Float(cells) => cells.len(),
            Self::Flag(cells) => cells.len(),
            Self::Text(cells) => cells.len(),
        }
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number in a row, if there is one: flags are 0 and 1.
    pub fn number(&self, row: usize) -> Option<f64> {
        match self {
            Self::Int(cells) => cells[row].map(|i| i as f64),
            Self::Float(cells) => cells[row],
            Self::Flag(cells) => cells[row].map(f64::from),
            Self::Text(_) => None,
        }
    }

    /// The value in a row as text; nothing where there is none. Floats are written so that they read back the same.
    pub fn text(&self, row: usize) -> Option<String> {
        match self {
            Self::Int(cells) => cells[row].map(|i| i.to_string()),
            Self::Float(cells) => {
                cells[row].map(|f| serde_json::Number::from_f64(f).map_or_else(|| f.to_string(), |n| n.to_string()))
            }
            Self::Flag(cells) => cells[row].map(|flag| flag.to_string()),
            Self::Text(cells) => cells[row].clone(),
        }
    }
}

impl Results {
    /// How many rows.
    pub fn rows(&self) -> usize {
        self.fields.first().map_or(0, |field| field.cells.len())
    }

    /// The column of this name.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }
}
