//! How far the values of a table may be off, where they are estimates: a change within that is none.

use serde_json::Value;

use crate::analysis::dims::DETAIL;
use crate::point::estimates::{RowEstimates, Sampled};
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
        let number = |name: &str, row: usize| results.field(name).and_then(|field| field.cells.number(row));
        let sampled = |row| {
            let [first, frames] = ["first_frame", "frames"].map(|name| number(name, row).map(|number| number as u32));
            let (source, policy) = (text("trace_fingerprint", row), text("policy_config", row));
            let told = source.zip(first.zip(frames)).zip(policy);
            told.map_or_else(Sampled::default, |((source, frames), policy)| {
                Sampled::new(source, frames, text(DETAIL, row).unwrap_or_default(), policy)
            })
        };
        let of_row = |row| RowEstimates::new(&value(INTERVALS, row), &value(REPLICATES, row), sampled(row));
        Self((0..results.rows()).map(of_row).collect())
    }

    /// Half the width of the 95 % interval of `b / a`, of column `name` in a row of two tables, relative to it; 0 if both are exact.
    pub fn of_ratio([a, b]: [&Self; 2], name: &str, rows: [usize; 2]) -> f64 {
        b.0[rows[1]].interval_of_ratio(&a.0[rows[0]], name)
    }

    /// Whether the windows of either tell nothing of the column.
    pub fn are_unknown([a, b]: [&Self; 2], name: &str, rows: [usize; 2]) -> bool {
        a.0[rows[0]].is_unknown(name) || b.0[rows[1]].is_unknown(name)
    }
}
