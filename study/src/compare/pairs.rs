//! Which point of one table is which of the other.

use std::collections::BTreeMap;

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
    /// Matches points by trace, frames, machine, policy and axes, but for the columns of `across`. Of points that are alike but for
    /// these, those that are alike in these too belong together; of what is left one may remain on each side.
    ///
    /// # Errors
    /// A column of `across` that is none of these; more points that are alike but for them.
    pub fn new(a: &Results, b: &Results, across: &[String]) -> Result<Self> {
        let names = names(a, b);
        if let Some(unknown) = across.iter().find(|column| !names.contains(&column.as_str())) {
            let near = nearest(unknown, &names);
            let meant = if near.is_empty() { String::new() } else { format!("; did you mean {}?", near.join(" or ")) };
            let known = names.join(", ");
            let detail = format!("--across {unknown:?}: points are known by {known}{meant}");
            return Err(StudyError::Usage { detail });
        }
        let all = names.clone();
        let (of, names): (Vec<&str>, Vec<&str>) =
            names.into_iter().partition(|name| across.iter().any(|column| column == name));
        let mut alike: BTreeMap<Vec<Option<String>>, [Vec<usize>; 2]> = BTreeMap::new();
        for (side, table) in [a, b].into_iter().enumerate() {
            for row in 0..table.rows() {
                alike.entry(identity(table, &names, row)).or_default()[side].push(row);
            }
        }
        let (mut pairs, mut alone) = (Vec::new(), [Vec::new(), Vec::new()]);
        for (values, [of_a, of_b]) in alike {
            let (mut same, mut left) = matched(&of_a, &of_b, |x, y| identity(a, &of, x) == identity(b, &of, y));
            match &mut left {
                [x, y] if x.len() == 1 && y.len() == 1 && !of.is_empty() => same.extend(x.pop().zip(y.pop())),
                [x, y] if !x.is_empty() && !y.is_empty() => {
                    let (x, y, of, point) = (x.len(), y.len(), of.join(" and "), describe(&names, &values));
                    let detail = format!(
                        "--across {of}: {x} points of the one and {y} of the other are alike but for it ({point}), so nobody can tell \
                         which belong together; compare tables that have one such point each"
                    );
                    return Err(StudyError::Usage { detail });
                }
                _ => {}
            }
            // Where several are alike, what they are not matched by tells them apart.
            let several = same.len() + left.iter().map(Vec::len).sum::<usize>() > 1;
            let name = |table: &Results, row: usize| match several {
                true => describe(&all, &identity(table, &all, row)),
                false => describe(&names, &values),
            };
            pairs.extend(same.into_iter().map(|(x, y)| (x, y, name(b, y))));
            for ((alone, left), table) in alone.iter_mut().zip(left).zip([a, b]) {
                alone.extend(left.into_iter().map(|row| (row, name(table, row))));
            }
        }
        pairs.sort_unstable_by_key(|(_, row, _)| *row);
        let [vanished, appeared] = alone.map(|mut points| {
            points.sort_unstable();
            points.into_iter().map(|(_, point)| point).collect()
        });
        Ok(Self { both: pairs, vanished, appeared })
    }
}

/// Rows of two tables that belong together, in order, and what is left of either.
fn matched(a: &[usize], b: &[usize], same: impl Fn(usize, usize) -> bool) -> (Vec<(usize, usize)>, [Vec<usize>; 2]) {
    let (mut pairs, mut left, mut alone) = (Vec::new(), a.to_vec(), Vec::new());
    for &row in b {
        match left.iter().position(|other| same(*other, row)) {
            Some(at) => pairs.push((left.remove(at), row)),
            None => alone.push(row),
        }
    }
    (pairs, [left, alone])
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
    let value = |name: &&str| {
        let field = results.field(name)?;
        let text = label(field, row)?;
        Some(if field.role == Role::Axis { whole(text) } else { text })
    };
    names.iter().map(value).collect()
}

/// A value of an axis as an integer, if it is one: a fraction beside them makes 10 to 10.0.
fn whole(text: String) -> String {
    const EXACT: f64 = (1_u64 << 53) as f64;
    let number = text.parse::<f64>().ok().filter(|number| number.fract() == 0.0 && number.abs() < EXACT);
    number.map_or(text, |number| (number as i64).to_string())
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
