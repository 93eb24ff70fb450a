//! The dimensions of a sweep: what somebody chose and what differs between its points, such as the axes of the plan.

use std::collections::BTreeMap;

use crate::table::{Cells, Field, Results, Role};
use rayreel_machine::config::units::Bytes;

/// Columns that say what a point is, beside the axes of the plan. Scene and picture size are not among them: they follow from the
/// trace.
pub const IDENTITY: &[&str] = &["trace", "first_frame", "frames", "machine", "policy", DETAIL];

/// The column that says how much was simulated.
pub const DETAIL: &str = "detail";

/// A dimension: its values, and which of them each point has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dimension {
    /// Name of its column.
    pub name: String,
    /// What it is.
    pub description: String,
    /// Its values for people: numbers ascending, words as they first come.
    pub values: Vec<String>,
    /// For each row the index of its value; none where the dimension does not apply.
    pub of: Vec<Option<usize>>,
}

/// The columns that say which frames of a trace a point is of.
const OF_FRAMES: [&str; 2] = ["first_frame", "frames"];

/// The dimensions with more than one value, in the order of the columns. Where each trace has its own frames these are none: they would
/// tell the same as the trace.
pub fn dimensions(results: &Results) -> Vec<Dimension> {
    let chosen = |field: &&Field| field.role == Role::Axis || IDENTITY.contains(&field.name.as_str());
    let all = results.fields.iter().filter(chosen).map(Dimension::new).filter(|dimension| dimension.values.len() > 1);
    let mut all: Vec<Dimension> = all.collect();
    if let Some(trace) = all.iter().find(|dimension| dimension.name == "trace").cloned() {
        all.retain(|dimension| !(OF_FRAMES.contains(&dimension.name.as_str()) && dimension.follows(&trace)));
    }
    all
}

impl Dimension {
    /// Whether the value of another dimension decides about that of this one.
    pub(super) fn follows(&self, other: &Self) -> bool {
        let mut known = BTreeMap::new();
        self.of.iter().zip(&other.of).all(|(value, decides)| known.entry(decides).or_insert(value) == &value)
    }

    /// The dimension of a column.
    pub fn new(field: &Field) -> Self {
        let rows = field.cells.len();
        let mut order: Vec<usize> = (0..rows).collect();
        if !matches!(field.cells, Cells::Text(_)) {
            let number = |row: usize| field.cells.number(row).unwrap_or(f64::INFINITY);
            order.sort_by(|a, b| number(*a).total_cmp(&number(*b)));
        }
        let (mut values, mut known, mut of) = (Vec::new(), BTreeMap::new(), vec![None; rows]);
        for row in order {
            let Some(label) = label(field, row) else { continue };
            let index = *known.entry(label.clone()).or_insert_with(|| {
                values.push(label);
                values.len() - 1
            });
            of[row] = Some(index);
        }
        Self { name: field.name.clone(), description: field.description.clone(), values, of }
    }
}

/// A value for people: sizes as plans write them.
pub fn label(field: &Field, row: usize) -> Option<String> {
    match &field.cells {
        Cells::Int(cells) if field.unit == "bytes" => {
            cells[row].map(|i| u64::try_from(i).map_or_else(|_| i.to_string(), |i| Bytes(i).to_string()))
        }
        cells => cells.text(row),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tables::{axis, table, words};
    use super::*;

    #[test]
    fn numbers_ascend_and_words_keep_their_order() {
        let mut size = axis("l1", Cells::Int(vec![Some(65536), Some(4096), None, Some(4096)]));
        size.unit = "bytes".into();
        let words =
            axis("miss", Cells::Text(["retry", "accumulate", "retry", "reorder"].map(|w| Some(w.into())).into()));
        let same = axis("same", Cells::Int(vec![Some(1); 4]));
        let found = dimensions(&table(vec![size, words, same]));
        assert_eq!(found.len(), 2, "what is the same everywhere is no dimension");
        assert_eq!(
            (found[0].values.as_slice(), &found[0].of),
            (&["4KiB".into(), "64KiB".into()][..], &vec![Some(1), Some(0), None, Some(0)])
        );
        assert_eq!(found[1].values, ["retry", "accumulate", "reorder"]);
    }

    #[test]
    fn frames_that_each_trace_has_of_its_own_are_no_dimension() {
        let found = |frames: [i64; 4]| {
            let trace = words("trace", Role::Point, &["a", "b", "a", "b"]);
            let mut frames = axis("frames", Cells::Int(frames.map(Some).into()));
            frames.role = Role::Point;
            let all = dimensions(&table(vec![trace, frames, axis("l1", Cells::Int([1, 1, 2, 2].map(Some).into()))]));
            all.into_iter().map(|dimension| dimension.name).collect::<Vec<_>>()
        };
        assert_eq!(found([1, 2, 1, 2]), ["trace", "l1"]);
        assert_eq!(found([1, 2, 2, 2]), ["trace", "frames", "l1"]);
    }
}
