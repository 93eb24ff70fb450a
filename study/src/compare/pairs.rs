//! Which point of one table is which of the other.

use std::collections::{BTreeMap, VecDeque};

use rayreel_settings::nearest;

use crate::analysis::dims::{DETAIL, Dimension, IDENTITY, label};
use crate::error::{Result, StudyError};
use crate::table::{Field, Results, Role};

/// The points of two tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pairs {
    /// Rows of the points of both, and what they are, in the order of the second.
    pub both: Vec<(usize, usize, String)>,
    /// Points of the first alone.
    pub vanished: Vec<String>,
    /// Points of the second alone.
    pub appeared: Vec<String>,
}

impl Pairs {
    /// Matches points by trace, frames, machine, policy and axes, but for the columns of `across`. Points that are alike are matched
    /// in order.
    ///
    /// # Errors
    /// A column of `across` that is none of these.
    pub fn new(a: &Results, b: &Results, across: &[String]) -> Result<Self> {
        let names = names(a, b);
        if let Some(unknown) = across.iter().find(|column| !names.contains(&column.as_str())) {
            let near = nearest(unknown, &names);
            let meant = if near.is_empty() { String::new() } else { format!("; did you mean {}?", near.join(" or ")) };
            let known = names.join(", ");
            let detail = format!("--across {unknown:?}: points are known by {known}{meant}");
            return Err(StudyError::Usage { detail });
        }
        let names: Vec<&str> = names.into_iter().filter(|name| !across.iter().any(|column| column == name)).collect();
        let mut known: BTreeMap<Vec<Option<String>>, VecDeque<usize>> = BTreeMap::new();
        for row in 0..a.rows() {
            known.entry(identity(a, &names, row)).or_default().push_back(row);
        }
        let (mut both, mut appeared) = (Vec::new(), Vec::new());
        let mut taken = vec![false; a.rows()];
        for row in 0..b.rows() {
            let values = identity(b, &names, row);
            match known.get_mut(&values).and_then(VecDeque::pop_front) {
                Some(other) => {
                    taken[other] = true;
                    both.push((other, row, describe(&names, &values)));
                }
                None => appeared.push(describe(&names, &values)),
            }
        }
        let gone = (0..a.rows()).filter(|row| !taken[*row]);
        let vanished = gone.map(|row| describe(&names, &identity(a, &names, row))).collect();
        Ok(Self { both, vanished, appeared })
    }
}

/// Columns that say what a point is: those of the first table, then what only the second has.
pub fn names<'a>(a: &'a Results, b: &'a Results) -> Vec<&'a str> {
    // How much was simulated says which point is meant only where a table has points of more than one detail: an estimate may be
    // compared with what every cycle gives.
    let details =
        || [a, b].into_iter().any(|table| table.field(DETAIL).is_some_and(|f| Dimension::new(f).values.len() > 1));
    let identity = |name: &str| IDENTITY.contains(&name) && (name != DETAIL || details());
    let tells = |field: &&Field| field.role == Role::Axis || identity(&field.name);
    let mut names: Vec<&str> = Vec::new();
    for field in a.fields.iter().chain(&b.fields).filter(tells) {
        if !names.contains(&field.name.as_str()) {
            names.push(&field.name);
        }
    }
    names
}

fn identity(results: &Results, names: &[&str], row: usize) -> Vec<Option<String>> {
    names.iter().map(|name| results.field(name).and_then(|field| label(field, row))).collect()
}

/// A point in words, as messages of a sweep have it.
fn describe(names: &[&str], values: &[Option<String>]) -> String {
    let value = |name: &str| names.iter().position(|known| *known == name).and_then(|at| values[at].as_deref());
    let mut parts: Vec<String> = value("trace").map(str::to_owned).into_iter().collect();
    if let (Some(first), Some(count)) = (value("first_frame"), value("frames")) {
        let end = first.parse::<u64>().unwrap_or(0).saturating_add(count.parse().unwrap_or(0));
        parts.push(format!("frames {first}..{end}"));
    }
    parts.extend(value("machine").map(|name| format!("on {name}")));
    parts.extend(value("policy").map(|name| format!("under {name}")));
    parts.extend(value(DETAIL).map(|detail| format!("detail {detail}")));
    let axes = names.iter().zip(values).filter(|(name, _)| !IDENTITY.contains(name));
    parts.extend(axes.filter_map(|(name, value)| Some(format!("{name}={}", value.as_ref()?))));
    if parts.is_empty() { "the point".into() } else { parts.join(" ") }
}
