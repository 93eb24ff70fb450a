//! The columns of results that follow from the table of figures.

use std::sync::LazyLock;

use serde_json::Value;

use crate::figures::kinds::{Better, Form};
use crate::figures::table::{Figure, RunCost, figures};

/// A column that all results have, whatever their machine counts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FixedColumn {
    /// Its name: letters, digits and underscores.
    pub name: String,
    /// Unit of its values.
    pub unit: &'static str,
    /// What they are.
    pub description: String,
    /// Which way they are better.
    pub better: Better,
    /// Whether it is a figure; the parts of a count are counters.
    pub is_figure: bool,
    /// The keys of a report under which the value stands, one below the other.
    path: Vec<&'static str>,
}

impl FixedColumn {
    /// The value in a report as JSON; null where it has none.
    pub fn value<'a>(&self, report: &'a Value) -> &'a Value {
        self.path.iter().fold(report, |value, key| &value[*key])
    }
}

/// Kinds of rays, the fields of `RayCounts`.
const KINDS: &[&str] = &["primary", "reflection", "refraction", "shadow"];

/// Parts of `ByKind`, its fields.
const PARTS: &[&str] = &["full", "traced", "apron"];

/// The columns in the order of results: values, costs of larger parts of the machine, rays by kind.
pub fn columns() -> &'static [FixedColumn] {
    static ALL: LazyLock<Vec<FixedColumn>> = LazyLock::new(|| {
        let values = figures().iter().filter(|figure| figure.form == Form::Value).map(value);
        let costs = figures().iter().flat_map(costs);
        let kinds = figures().iter().filter(|figure| figure.form == Form::ByKind).flat_map(kinds);
        values.chain(costs).chain(kinds).collect()
    });
    &ALL
}

/// The column of this name, unless it is a count of the machine.
pub fn column(name: &str) -> Option<&'static FixedColumn> {
    columns().iter().find(|column| column.name == name)
}

fn value(figure: &Figure) -> FixedColumn {
    let Figure { name, unit, description, better, .. } = *figure;
    FixedColumn { name: name.into(), unit, description: description.into(), better, is_figure: true, path: vec![name] }
}

/// Columns of a part of the machine.
fn costs(figure: &Figure) -> Vec<FixedColumn> {
    let Form::Costs(part) = figure.form else { return Vec::new() };
    let column = |cost: Figure| FixedColumn {
        name: format!("{}_{}", figure.name, cost.name),
        unit: cost.unit,
        description: format!("{part}: {}", cost.of_part.unwrap_or(cost.description)),
        better: cost.better,
        is_figure: true,
        path: vec![figure.name, cost.name],
    };
    RunCost::figures().into_iter().map(column).collect()
}

fn kinds(figure: &Figure) -> Vec<FixedColumn> {
    let column = |kind: &'static str, part: &'static str| FixedColumn {
        name: format!("rays_{kind}_{part}"),
        unit: figure.unit,
        description: format!("{kind} rays of rays_{part}"),
        better: figure.better,
        is_figure: false,
        path: vec![figure.name, part, kind],
    };
    KINDS.iter().flat_map(|kind| PARTS.iter().map(move |part| column(kind, part))).collect()
}

/// A column that each component of the energy has, in mJ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComponentPart {
    /// Its key in a component of a report, and the end of its column's name.
    pub key: &'static str,
    /// A word for it.
    pub word: &'static str,
}

/// The columns of a component.
pub const COMPONENT_PARTS: &[ComponentPart] =
    &[ComponentPart { key: "dynamic_mj", word: "dynamic" }, ComponentPart { key: "leakage_mj", word: "leakage" }];
