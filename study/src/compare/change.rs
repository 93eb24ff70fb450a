//! The changes of matched points, column by column.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::analysis::configs::{Configs, Half};
use crate::analysis::dims::{DETAIL, label};
use crate::compare::estimates::Estimates;
use crate::compare::options::Options;
use crate::compare::pairs::{Pairs, names};
use crate::compare::select::Select;
use crate::table::{Cells, Field, Results, Role};
use rayreel_replay::Detail;

/// Columns of the configuration that are compared beside its keys.
const OF_ALL: [&str; 3] = ["trace_fingerprint", "model_version", DETAIL];

/// A figure or counter that changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub description: String,
    /// Whether it is a figure or a counter.
    pub role: Role,
    /// How many points changed by more than the tolerance and what their estimates may be off.
    pub changed: usize,
    /// How many other points have another value within what their estimates may be off.
    pub within: usize,
    /// How many points have it on either side.
    pub compared: usize,
    /// The change that is largest.
    pub largest: Largest,
    /// Mean relative change over all points that have it on both sides, from another value than zero; with its sign.
    pub mean_relative: Option<f64>,
}

/// One change.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Largest {
    /// The point.
    pub point: String,
    /// The value in A.
    pub a: Option<f64>,
    /// The value in B.
    pub b: Option<f64>,
    /// (b - a) / |a|; none from zero, and where one side has no value.
    pub relative: Option<f64>,
    /// How far `relative` may be off, with a probability of 95 %; none where both values are exact or nothing is known of one,
    /// and where `relative` is none.
    pub interval: Option<f64>,
    /// Whether one of the values is an estimate of which the windows tell nothing: it may be off by anything.
    pub unknown: bool,
}

/// A configuration value that changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ConfigChange {
    /// Its key.
    pub key: String,
    /// How many points changed.
    pub changed: usize,
    /// The first point that did.
    pub point: String,
    /// The value in A.
    pub a: Option<String>,
    /// The value in B.
    pub b: Option<String>,
}

/// A point that can be computed in one table only, or fails otherwise.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StateChange {
    /// The point.
    pub point: String,
    /// Why it failed in A, if it did.
    pub a: Option<String>,
    /// Why it failed in B, if it did.
    pub b: Option<String>,
}

/// The columns that both tables have, and the names of those that only one has.
pub fn columns<'a>(a: &'a Results, b: &'a Results, select: &Select) -> (Vec<(&'a Field, &'a Field)>, [Vec<String>; 2]) {
    let selected = |results: &'a Results| {
        let result = |field: &&Field| matches!(field.role, Role::Figure | Role::Counter) && select.takes(&field.name);
        results.fields.iter().filter(result).collect::<Vec<_>>()
    };
    let find = |list: &[&'a Field], name: &str| list.iter().copied().find(|field| field.name == name);
    let (of_a, of_b) = (selected(a), selected(b));
    let both = of_a.iter().filter_map(|field| Some((*field, find(&of_b, &field.name)?))).collect();
    let alone = |list: &[&'a Field], other: &[&'a Field]| {
        list.iter().filter(|field| find(other, &field.name).is_none()).map(|field| field.name.clone()).collect()
    };
    (both, [alone(&of_a, &of_b), alone(&of_b, &of_a)])
}

/// Every name that a comparison of two tables may tell of: figures and counters, what points are known by, and keys of machine and
/// policy.
pub fn comparable(a: &Results, b: &Results) -> BTreeSet<String> {
    let result = |field: &&Field| matches!(field.role, Role::Figure | Role::Counter);
    let results =
        [a, b].into_iter().flat_map(|table| table.fields.iter().filter(result)).map(|field| field.name.as_str());
    let known_by = names(a, b).into_iter().chain(OF_ALL);
    let mut all: BTreeSet<String> = results.chain(known_by).map(str::to_owned).collect();
    for half in Half::ALL {
        for table in [a, b] {
            all.extend(Configs::new(table, half).keys().into_iter().map(str::to_owned));
        }
    }
    all
}

/// Figures and counters that changed: from nothing or from zero first, then by their largest relative change. And in how many others
/// values differ, but no further than their estimates may be off.
pub fn results(
    columns: &[(&Field, &Field)],
    pairs: &Pairs,
    estimates: [&Estimates; 2],
    tolerance: f64,
) -> (Vec<Change>, usize) {
    let (mut changes, mut within) = (Vec::new(), 0);
    for (a, b) in columns {
        match change(a, b, pairs, estimates, tolerance) {
            Found::Changed(change) => changes.push(*change),
            Found::Within => within += 1,
            Found::Equal => {}
        }
    }
    changes.sort_by(|a, b| size(b.largest.relative).total_cmp(&size(a.largest.relative)));
    (changes, within)
}

/// What became of a column.
enum Found {
    /// All values are equal, or equal within the tolerance.
    Equal,
    /// Some values differ, all within what they may be off.
    Within,
    /// Some differ by more.
    Changed(Box<Change>),
}

/// How large a change is.
fn size(relative: Option<f64>) -> f64 {
    relative.map_or(f64::INFINITY, f64::abs)
}

fn change(a: &Field, b: &Field, pairs: &Pairs, estimates: [&Estimates; 2], tolerance: f64) -> Found {
    let (mut changed, mut within, mut compared, mut sum, mut count) = (0, 0, 0, 0.0, 0_u32);
    let mut largest: Option<Largest> = None;
    for (row_a, row_b, point) in &pairs.both {
        let (x, y) = (a.cells.number(*row_a), b.cells.number(*row_b));
        if x.is_none() && y.is_none() {
            continue;
        }
        compared += 1;
        let relative = relative(x, y);
        if let Some(relative) = relative.filter(|_| x != Some(0.0)) {
            sum += relative;
            count += 1;
        }
        if x == y || relative.is_some_and(|relative| relative.abs() <= tolerance) {
            continue;
        }
        let interval =
            Estimates::of_ratio(estimates, &b.name, [*row_a, *row_b]) * relative.map_or(1.0, |r| (1.0 + r).abs());
        let unknown = Estimates::are_unknown(estimates, &b.name, [*row_a, *row_b]);
        if !unknown && relative.is_some_and(|relative| relative.abs() <= interval) {
            within += 1;
            continue;
        }
        changed += 1;
        // The first of equal ones.
        if largest.as_ref().is_none_or(|known| size(relative) > size(known.relative)) {
            largest = Some(Largest {
                point: point.clone(),
                a: x,
                b: y,
                relative,
                interval: relative.and((interval > 0.0).then_some(interval)).filter(|_| !unknown),
                unknown,
            });
        }
    }
    let Some(largest) = largest else { return if within > 0 { Found::Within } else { Found::Equal } };
    Found::Changed(Box::new(Change {
        name: b.name.clone(),
        unit: b.unit.clone(),
        description: b.description.clone(),
        role: b.role,
        changed,
        within,
        compared,
        largest,
        mean_relative: (count > 0).then(|| sum / f64::from(count)),
    }))
}

/// The relative change; none from zero to something, or without both values.
fn relative(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let (a, b) = (a?, b?);
    if a == b {
        return Some(0.0);
    }
    let relative = (b - a) / a.abs();
    relative.is_finite().then_some(relative)
}

/// Points whose failure changed.
pub fn states(a: &Results, b: &Results, pairs: &Pairs) -> Vec<StateChange> {
    let error = |results: &Results, row: usize| results.field("error").and_then(|field| field.cells.text(row));
    let state = |(row_a, row_b, point): &(usize, usize, String)| StateChange {
        point: point.clone(),
        a: error(a, *row_a),
        b: error(b, *row_b),
    };
    pairs.both.iter().map(state).filter(|change| change.a != change.b).collect()
}

/// Configuration values that changed: the columns by which points were not matched, the traces' fingerprints and the model's version
/// first, then the values of machine and policy by key.
pub fn configuration(tables: [&Results; 2], pairs: &Pairs, options: &Options) -> Vec<ConfigChange> {
    let mut changes = ConfigChanges { select: &options.select, columns: BTreeMap::new(), keys: BTreeMap::new() };
    let unmatched =
        names(tables[0], tables[1]).into_iter().filter(|name| options.across.iter().any(|column| column == name));
    for name in unmatched.filter(|name| *name != DETAIL).chain(OF_ALL) {
        changes.compare_column(name, tables, pairs);
    }
    for half in Half::ALL {
        changes.compare_half(half, tables, pairs);
    }
    changes.columns.into_values().chain(changes.keys.into_values()).collect()
}

/// Changes of the configuration by name of the column, and by key of machine or policy.
struct ConfigChanges<'a> {
    select: &'a Select,
    columns: BTreeMap<String, ConfigChange>,
    keys: BTreeMap<String, ConfigChange>,
}

impl ConfigChanges<'_> {
    fn compare_column(&mut self, name: &str, tables: [&Results; 2], pairs: &Pairs) {
        let fields = tables.map(|table| table.field(name));
        // Results that say nothing of it are older than estimates.
        let every_cycle = || (name == DETAIL).then(|| Detail::Full.to_string());
        let value = |field: Option<&Field>, row: usize| field.and_then(|field| label(field, row)).or_else(every_cycle);
        for (a, b, point) in &pairs.both {
            let values = [value(fields[0], *a), value(fields[1], *b)];
            // A fraction elsewhere in a column makes 10 to 10.0.
            if let [Some(of_a), Some(of_b)] = &values
                && same_number(of_a, of_b)
            {
                continue;
            }
            differ(&mut self.columns, self.select, name, point, values);
        }
    }

    fn compare_half(&mut self, half: Half, tables: [&Results; 2], pairs: &Pairs) {
        let texts = tables.map(|table| table.field(half.column()).map(|field| &field.cells));
        let configs = tables.map(|table| Configs::new(table, half));
        for (a, b, point) in &pairs.both {
            if let [Some(Cells::Text(of_a)), Some(Cells::Text(of_b))] = texts
                && of_a[*a] == of_b[*b]
            {
                continue;
            }
            let rows = [configs[0].row(*a), configs[1].row(*b)];
            let keys: BTreeSet<&String> = rows.iter().flatten().flat_map(|config| config.keys()).collect();
            for key in keys {
                let values = rows.map(|config| config.and_then(|config| config.get(key).cloned()));
                if let [Some(of_a), Some(of_b)] = &values
                    && same_number(of_a, of_b)
                {
                    continue;
                }
                differ(&mut self.keys, self.select, key, point, values);
            }
        }
    }
}

/// Whether two texts are one number: other programs write 15.0 as 15. Whole numbers are not rounded.
fn same_number(a: &str, b: &str) -> bool {
    let whole = |text: &str| text.parse::<i128>().is_ok();
    let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
    !(whole(a) && whole(b)) && number(a).is_some_and(|a| number(b) == Some(a))
}

/// Counts a change of a point, if it is one; the first is kept with its values.
fn differ(
    changes: &mut BTreeMap<String, ConfigChange>,
    select: &Select,
    key: &str,
    point: &str,
    [a, b]: [Option<String>; 2],
) {
    if a == b || !select.takes(key) {
        return;
    }
    let first = || ConfigChange { key: key.into(), changed: 0, point: point.into(), a, b };
    changes.entry(key.to_owned()).or_insert_with(first).changed += 1;
}
