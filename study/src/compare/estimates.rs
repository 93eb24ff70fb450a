//! How far the values of a table may be off, where they are estimates: a change within that is none.

use serde_json::Value;

use crate::point::estimates::RowEstimates;
use crate::point::known::{INTERVALS, REPLICATES};
use crate::table::{Cells, Results};

/// What is known of the estimates of a table, row by row.
pub struct Estimates(Vec<RowEstimates>);

impl Estimates {
    /// That of a table.
    pub fn new(results: &Results) -> Self {
        let text = |name: &str, row: usize| match results.field(name).map(|field| &field.cells) {
            Some(Cells::Text(cells)) => cells[row].as_deref(),
            _ => None,
        };
        let value = |name, row| text(name, row).and_then(|text| serde_json::from_str(text).ok()).unwrap_or(Value::Null);
        let of_row = |row| RowEstimates::new(&value(INTERVALS, row), &value(REPLICATES, row), text("policy", row));
        Self((0..results.rows()).map(of_row).collect())
    }

    /// Half the width of the 95 % interval of `b / a`, of column `name` in a row of two tables, relative to it; 0 if both are exact.
    pub fn of_ratio([a, b]: [&Self; 2], name: &str, rows: [usize; 2]) -> f64 {
        b.0[rows[1]].interval_of_ratio(&a.0[rows[0]], name)
    }
}
