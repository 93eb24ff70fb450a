//! The figures and counters of a report as a flat list: the columns that results have.

use std::borrow::Cow;

use serde_json::Value;

use crate::figures::{self, COMPONENT_PARTS};

/// A column with its value in a report.
pub(crate) struct Cell<'a> {
    /// Its name: letters, digits and underscores.
    pub name: String,
    /// Unit of its values.
    pub unit: &'a str,
    /// What they are.
    pub description: Cow<'a, str>,
    /// The value.
    pub value: &'a Value,
}

/// All columns of a report as JSON: figures, components of the energy, counters. What the report does not have is null, or left out
/// where it is the machine that names it.
pub(crate) fn cells(report: &Value) -> impl Iterator<Item = Cell<'_>> {
    let fixed = figures::columns().iter().map(|column| Cell {
        name: column.name.clone(),
        unit: column.unit,
        description: Cow::Borrowed(column.description.as_str()),
        value: column.value(report),
    });
    let components = report["energy"].as_array().into_iter().flatten().flat_map(component);
    let counters = report["counters"].as_object().into_iter().flatten().map(|(name, counter)| {
        let word = |key: &str| counter[key].as_str().unwrap_or_default();
        let (name, description) = (plain(name), Cow::Borrowed(word("description")));
        Cell { name, unit: word("unit"), description, value: &counter["value"] }
    });
    fixed.chain(components).chain(counters)
}

/// The energy of a component.
fn component(component: &Value) -> impl Iterator<Item = Cell<'_>> {
    let name = component["name"].as_str().unwrap_or_default();
    COMPONENT_PARTS.iter().map(move |part| Cell {
        name: format!("energy_{}_{}", plain(name), part.key),
        unit: "mJ",
        description: Cow::Owned(format!("energy of {name}, {}", part.word)),
        value: &component[part.key],
    })
}

/// A name that needs no quotes in SQL.
pub(crate) fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect()
}
