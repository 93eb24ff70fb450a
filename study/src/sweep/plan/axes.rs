//! What the axes of a plan must hold together. What one axis must hold by itself stands in `axis`.

use crate::error::Result;
use crate::figures::is_key;
use crate::sweep::plan::Plan;
use crate::sweep::plan::axis::Axis;
use crate::sweep::plan::file::PlanFile;
use crate::sweep::plan::locate::Text;

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

/// Checks the axes against one another and against the columns of results.
///
/// # Errors
/// Two of one name, the name of another column, axes that go forward together and do not match.
pub fn check_axes(file: &PlanFile, axes: &[Axis], text: Text<'_>) -> Result<()> {
    for (i, (axis, at)) in axes.iter().zip(&file.axis).enumerate() {
        let name_at = at.get_ref().name.span();
        if axes[..i].iter().any(|other| other.name == axis.name) {
            return Err(text.error(&name_at, format!("a second axis {:?}; give it another name", axis.name)));
        }
        if RESERVED.contains(&axis.name.as_str()) || is_key(&axis.name) {
            let detail = format!("axis {:?}: results have a column of that name; take another", axis.name);
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
