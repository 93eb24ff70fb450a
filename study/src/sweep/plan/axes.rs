//! What the axes of a plan must hold together. What one axis must hold by itself stands in `axis`.

use std::collections::BTreeSet;

use crate::error::Result;
use crate::figures::{columns, figures};
use crate::point::known;
use crate::sweep::plan::axis::Axis;
use crate::sweep::plan::file::PlanFile;
use crate::sweep::plan::locate::Text;
use crate::sweep::plan::{Base, Plan, is_machine_override};

/// Names that points have beside their axes.
const RESERVED: &[&str] = &[
    "point",
    "key",
    "status",
    "error",
    "trace",
    "scene",
    "machine",
    "policy",
    "width",
    "height",
    "samples",
    "first_frame",
    "frames",
    "detail",
    "machine_config",
    "policy_config",
    "trace_fingerprint",
    "model_version",
];

/// Words of the language of `exclude`.
const WORDS: &[&str] =
    &["and", "or", "not", "in", "is", "if", "else", "true", "false", "none", "True", "False", "None"];

/// An earlier axis that sets a key which `axis` sets too, for the same machine or policy.
fn both_set<'a>(before: &'a [Axis], axis: &'a Axis) -> Option<(&'a str, &'a str)> {
    let keys = |axis: &'a Axis| -> BTreeSet<&'a str> {
        axis.values.iter().flat_map(|value| &value.set).filter_map(|set| Some(set.split_once('=')?.0.trim())).collect()
    };
    let (later, alike) = (keys(axis), |other: &Axis| {
        other.only.is_empty() || axis.only.is_empty() || other.only.iter().any(|name| axis.only.contains(name))
    });
    before.iter().filter(|other| alike(other)).find_map(|other| {
        let both = keys(other).into_iter().find(|key| later.contains(key))?;
        Some((other.name.as_str(), both))
    })
}

/// Why there cannot be an axis of a name beside another that is the same without case.
fn second(other: &str, name: &str) -> String {
    let alike =
        if other == name { String::new() } else { format!(" beside {other:?}, which databases take for the same") };
    format!("a second axis {name:?}{alike}; give it another name")
}

/// The column of results that a name is, or is but for its case. What only some machines count is not looked at.
fn column_like(name: &str) -> Option<String> {
    let results = figures().iter().map(|figure| figure.name).chain(columns().iter().map(|column| column.name.as_str()));
    let mut all = RESERVED.iter().copied().chain(results);
    let of_estimates = || Some(name.to_ascii_lowercase()).filter(|name| known::role(name).is_some());
    all.find(|column| column.eq_ignore_ascii_case(name)).map(str::to_owned).or_else(of_estimates)
}

/// Why a name is that of a column already. Databases such as DuckDB do not tell columns apart by case.
fn taken(name: &str) -> Option<String> {
    let column = column_like(name)?;
    let detail = if column == name {
        "results have a column of that name".to_owned()
    } else {
        format!("results have a column {column:?}, which databases take for the same")
    };
    Some(format!("axis {name:?}: {detail}; take another"))
}

/// Checks the axes against one another and against the columns of results.
///
/// # Errors
/// Two of one name, the name of another column, axes that go forward together and do not match.
pub fn check_axes(file: &PlanFile, axes: &[Axis], text: Text<'_>) -> Result<()> {
    for (i, (axis, at)) in axes.iter().zip(&file.axis).enumerate() {
        let name_at = at.get_ref().name.span();
        if let Some(other) = axes[..i].iter().find(|other| other.name.eq_ignore_ascii_case(&axis.name)) {
            return Err(text.error(&name_at, second(&other.name, &axis.name)));
        }
        if WORDS.contains(&axis.name.as_str()) {
            let detail = format!("axis {:?}: that is a word of the language of exclude; take another", axis.name);
            return Err(text.error(&name_at, detail));
        }
        if let Some((other, key)) = both_set(&axes[..i], axis) {
            let detail = format!("axes {other:?} and {:?} both set {key}; let only one of them set it", axis.name);
            return Err(text.error(&at.span(), detail));
        }
        if let Some(detail) = taken(&axis.name) {
            return Err(text.error(&name_at, detail));
        }
        if let Some(first) = axes[..i].iter().find(|other| axis.zip.is_some() && other.zip == axis.zip) {
            check_together(first, axis).map_err(|detail| text.error(&at.span(), detail))?;
        }
    }
    Ok(())
}

/// Checks an axis against the first one that it goes forward with.
fn check_together(first: &Axis, axis: &Axis) -> Result<(), String> {
    let together = format!("axes {:?} and {:?} go forward together but", first.name, axis.name);
    let (a, b) = (first.values.len(), axis.values.len());
    if a != b {
        return Err(format!("{together} have {a} and {b} values"));
    }
    if first.only != axis.only {
        return Err(format!("{together} differ in only"));
    }
    Ok(())
}

/// Checks that a plan without machines changes none.
///
/// # Errors
/// An override or an axis of machines where there is none.
pub fn check_machines(plan: &Plan, file: &PlanFile, text: Text<'_>) -> Result<()> {
    if !plan.machines.iter().all(Base::is_none) {
        return Ok(());
    }
    let why = "and machines = [\"none\"] has none; name a machine or leave it out";
    if let Some(set) = file.set.iter().find(|set| is_machine_override(set.get_ref())) {
        return Err(text.error(&set.span(), format!("set {:?} is for a machine, {why}", set.get_ref())));
    }
    let found = plan.axes.iter().zip(&file.axis).find(|(axis, _)| axis.is_of_machines());
    found.map_or(Ok(()), |(axis, at)| {
        Err(text.error(&at.span(), format!("axis {:?} changes machines, {why}", axis.name)))
    })
}

/// Checks that axes which are only for some machines or policies name such as the plan has.
///
/// # Errors
/// A name that is none of them.
pub fn check_only(plan: &Plan, file: &PlanFile, text: Text<'_>) -> Result<()> {
    let known = |name: &String| plan.machines.iter().chain(&plan.policies).any(|base| base.name == *name);
    let unknown = |axis: &Axis| axis.only.iter().find(|name| !known(name)).cloned();
    let found = plan.axes.iter().zip(&file.axis).find_map(|(axis, at)| Some((axis, at, unknown(axis)?)));
    found.map_or(Ok(()), |(axis, at, name)| {
        let detail = format!("axis {:?} is only for {name:?}, which is no machine or policy of this plan", axis.name);
        Err(text.error(&at.span(), detail))
    })
}
