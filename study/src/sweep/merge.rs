//! All rows of a sweep as one table, in the order of the plan.
//!
//! The table depends on the plan and on nothing else: not on how the points were split, how often they were tried, or in which
//! order they were finished.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::PathBuf;

use serde_json::Value;

use crate::error::{Result, StudyError};
use crate::point::columns::read_columns;
use crate::point::row::{Column, Row, role_of};
use crate::point::version::MODEL_VERSION;
use crate::sweep::folder::Folder;
use crate::sweep::plan::{Axis, Plan, PointRef, Scalar};
use crate::sweep::segment;
use crate::table::{Cells, Field, Heading, Results, Role};
use rayreel_machine::config::schema::{KEYS, Rule};

/// What a merge found.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// The rows that are there.
    pub results: Results,
    /// Points without a row.
    pub missing: Vec<usize>,
    /// Points whose row says that they cannot be computed.
    pub failed: usize,
    /// Rows beyond the first of a key: of second attempts. All are equal.
    pub duplicates: usize,
    /// Segments that were torn, empty or of another plan, and were ignored.
    pub damaged: Vec<PathBuf>,
}

/// Puts the rows of a sweep together.
///
/// # Errors
/// [`StudyError::Conflict`] if two rows of one key differ; a folder that cannot be read.
pub fn merge(folder: &Folder) -> Result<Merged> {
    let Rows { rows, duplicates, damaged } = gather(folder)?;
    let plan = folder.plan();
    let (there, missing): (Vec<usize>, Vec<usize>) =
        (0..plan.points.len()).partition(|point| rows.contains_key(&plan.points[*point].key));
    let table = Table { plan, rows: &rows, there: &there, columns: read_columns(&folder.columns())? };
    let fields = table.fields()?;
    let failed = there.iter().filter(|point| rows[&plan.points[**point].key].error.is_some()).count();
    let heading = Heading {
        name: plan.name.clone(),
        plan: folder.id().into(),
        model_version: MODEL_VERSION,
        points: plan.points.len(),
    };
    Ok(Merged { results: Results { heading, fields }, missing, failed, duplicates, damaged })
}

/// The rows of all buckets.
pub(super) struct Rows {
    /// By key.
    pub rows: BTreeMap<String, Row>,
    /// Rows beyond the first of a key.
    pub duplicates: usize,
    /// Segments that were ignored.
    pub damaged: Vec<PathBuf>,
}

/// Reads every bucket.
///
/// # Errors
/// As [`merge`].
pub(super) fn gather(folder: &Folder) -> Result<Rows> {
    let mut all = Rows { rows: BTreeMap::new(), duplicates: 0, damaged: Vec::new() };
    for bucket in 0..folder.buckets() {
        let held = segment::read(folder, bucket)?;
        if let Some((key, detail)) = held.conflict {
            return Err(StudyError::Conflict { key, detail });
        }
        all.duplicates += held.duplicates;
        all.damaged.extend(held.damaged);
        // Points of different buckets may share a key.
        join(&mut all.rows, held.rows)?;
    }
    Ok(all)
}

/// Adds rows to others.
///
/// # Errors
/// [`StudyError::Conflict`] if two of one key differ.
pub(super) fn join(rows: &mut BTreeMap<String, Row>, more: BTreeMap<String, Row>) -> Result<()> {
    for (key, row) in more {
        match rows.entry(key) {
            Entry::Occupied(old) if *old.get() != row => {
                let detail = segment::difference(old.get(), &row);
                return Err(StudyError::Conflict { key: old.key().clone(), detail });
            }
            Entry::Occupied(_) => {}
            Entry::Vacant(free) => {
                free.insert(row);
            }
        }
    }
    Ok(())
}

struct Table<'a> {
    plan: &'a Plan,
    rows: &'a BTreeMap<String, Row>,
    /// Points that have a row.
    there: &'a [usize],
    columns: BTreeMap<String, Column>,
}

/// Units of what is measured; all others count something.
const MEASURES: [&str; 13] =
    ["1", "%", "dB", "8-bit levels", "ms", "frames/s", "Mrays/s", "W", "mJ", "nJ", "frames/s/W", "mm2", "Mrays/s/mm2"];

/// A column without a value, of the type that it has in other tables, so that tables can be put together.
fn nothing(role: Role, unit: &str, rows: usize) -> Cells {
    match (role, unit) {
        (Role::Config, _) => Cells::Text(vec![None; rows]),
        (_, "bool") => Cells::Flag(vec![None; rows]),
        (_, unit) if MEASURES.contains(&unit) => Cells::Float(vec![None; rows]),
        _ => Cells::Int(vec![None; rows]),
    }
}

impl Table<'_> {
    fn fields(&self) -> Result<Vec<Field>> {
        let plan = self.plan;
        let mut all = vec![
            self.point(
                "point",
                "number of the point in the plan, from 0",
                Cells::Int(self.there.iter().map(|p| Some(*p as i64)).collect()),
            ),
            self.texts("key", "hash of all that the result depends on", |p| p.key.clone()),
            self.texts("trace", "file name of the trace", |p| plan.traces[p.trace].name.clone()),
            self.texts("scene", "its scene", |p| plan.traces[p.trace].scene.clone()),
            self.ints("width", "pixels", "picture width", |p| plan.traces[p.trace].size.0),
            self.ints("height", "pixels", "picture height", |p| plan.traces[p.trace].size.1),
            self.ints("samples", "samples", "samples per pixel and axis", |p| plan.traces[p.trace].samples),
            self.ints("first_frame", "index", "first frame", |p| p.frames.0),
            self.ints("frames", "frames", "number of frames", |p| p.frames.1),
            self.texts("machine", "machine preset or file", |p| plan.machines[p.machine].name.clone()),
            self.texts("policy", "policy preset or file", |p| plan.policies[p.policy].name.clone()),
            self.detail(),
        ];
        all.extend(plan.axes.iter().enumerate().map(|(i, axis)| self.axis(i, axis)));
        let status = self.each(|p| Some(if self.row(p).error.is_some() { "failed" } else { "done" }.to_owned()));
        all.push(Field { role: Role::Status, ..self.point("status", "done or failed", Cells::Text(status)) });
        let error = Cells::Text(self.each(|p| self.row(p).error.clone()));
        all.push(Field { role: Role::Status, ..self.point("error", "why a point failed", error) });
        for name in self.names() {
            all.push(self.figure(&name));
        }
        all.extend(self.configs()?);
        Ok(all)
    }

    fn row(&self, point: &PointRef) -> &Row {
        &self.rows[&point.key]
    }

    fn each<T>(&self, value: impl Fn(&PointRef) -> T) -> Vec<T> {
        self.there.iter().map(|point| value(&self.plan.points[*point])).collect()
    }

    fn point(&self, name: &str, description: &str, cells: Cells) -> Field {
        Field { name: name.into(), unit: String::new(), description: description.into(), role: Role::Point, cells }
    }

    fn texts(&self, name: &str, description: &str, value: impl Fn(&PointRef) -> String) -> Field {
        self.point(name, description, Cells::Text(self.each(|p| Some(value(p)))))
    }

    /// How much was simulated: nothing is said of points without a machine.
    fn detail(&self) -> Field {
        let text = |p: &PointRef| self.plan.detail_text(p).map(str::to_owned);
        self.point("detail", "how much was simulated cycle by cycle", Cells::Text(self.each(text)))
    }

    fn ints(&self, name: &str, unit: &str, description: &str, value: impl Fn(&PointRef) -> u32) -> Field {
        let cells = Cells::Int(self.each(|p| Some(value(p).into())));
        Field { unit: unit.into(), ..self.point(name, description, cells) }
    }

    /// The column of axis number `index`.
    fn axis(&self, index: usize, axis: &Axis) -> Field {
        let value = |p: &PointRef| p.values[index].map(|value| &axis.values[value]);
        let all = |is: fn(&Scalar) -> bool| axis.values.iter().all(|value| is(&value.value));
        let cells = if all(|v| matches!(v, Scalar::Integer(_))) {
            Cells::Int(self.each(|p| match value(p)?.value {
                Scalar::Integer(i) => Some(i),
                _ => None,
            }))
        } else if all(|v| matches!(v, Scalar::Integer(_) | Scalar::Float(_))) {
            Cells::Float(self.each(|p| match value(p)?.value {
                Scalar::Integer(i) => Some(i as f64),
                Scalar::Float(f) => Some(f),
                _ => None,
            }))
        } else if all(|v| matches!(v, Scalar::Flag(_))) {
            Cells::Flag(self.each(|p| match value(p)?.value {
                Scalar::Flag(flag) => Some(flag),
                _ => None,
            }))
        } else {
            Cells::Text(self.each(|p| value(p).map(|value| value.label.clone())))
        };
        let rule = |key: &String| KEYS.iter().find(|known| known.name == *key).map(|known| known.rule);
        let sizes = axis.keys.iter().any(|key| matches!(rule(key), Some(Rule::Size(..))));
        let what = if axis.keys.is_empty() { "named values".to_owned() } else { axis.keys.join(", ") };
        Field {
            name: axis.name.clone(),
            unit: if sizes { "bytes".into() } else { String::new() },
            description: format!("axis of the plan: {what}"),
            role: Role::Axis,
            cells,
        }
    }

    /// Names of the figures, in the order in which the rows have them, walking the plan.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        let mut known = std::collections::BTreeSet::new();
        let mut last: Option<&Row> = None;
        for point in self.there {
            let row = self.row(&self.plan.points[*point]);
            // Most rows have the columns of the one before.
            if last.is_some_and(|last| last.figures.keys().eq(row.figures.keys())) {
                continue;
            }
            last = Some(row);
            for name in row.figures.keys() {
                if known.insert(name.clone()) {
                    names.push(name.clone());
                }
            }
        }
        names
    }

    fn figure(&self, name: &str) -> Field {
        let values: Vec<Option<&Value>> = self
            .there
            .iter()
            .map(|p| self.row(&self.plan.points[*p]).figures.get(name).filter(|v| !v.is_null()))
            .collect();
        let info = self.columns.get(name);
        let text = |get: fn(&Column) -> &String| info.map(get).cloned().unwrap_or_default();
        let (role, unit) = (role_of(name), text(|c| &c.unit));
        let all = |is: fn(&Value) -> bool| values.iter().flatten().all(|value| is(value));
        let cells = if values.iter().all(Option::is_none) {
            nothing(role, &unit, values.len())
        } else if all(Value::is_boolean) {
            Cells::Flag(values.iter().map(|value| value.and_then(Value::as_bool)).collect())
        } else if all(Value::is_i64) {
            Cells::Int(values.iter().map(|value| value.and_then(Value::as_i64)).collect())
        } else if all(Value::is_object) {
            Cells::Text(values.iter().map(|value| value.map(Value::to_string)).collect())
        } else {
            Cells::Float(values.iter().map(|value| value.and_then(Value::as_f64)).collect())
        };
        Field { name: name.into(), unit, description: text(|c| &c.description), role, cells }
    }

    /// The resolved configurations and versions.
    fn configs(&self) -> Result<Vec<Field>> {
        let mut known = BTreeMap::new();
        let (mut machines, mut policies) = (Vec::new(), Vec::new());
        for point in self.there {
            let planned = &self.plan.points[*point];
            let name = (planned.machine, planned.policy, &planned.values);
            if let Entry::Vacant(slot) = known.entry(name) {
                let resolved = self.plan.resolve(planned)?;
                slot.insert((resolved.machine_config(), resolved.policy_config()));
            }
            let (machine, policy) = &known[&name];
            machines.push(Some(machine.clone()));
            policies.push(Some(policy.clone()));
        }
        let config = |name: &str, text: &str, cells| Field { role: Role::Config, ..self.point(name, text, cells) };
        let fingerprints = self.each(|p| Some(self.plan.traces[p.trace].fingerprint.clone()));
        Ok(vec![
            config("machine_config", "every value of the machine, JSON", Cells::Text(machines)),
            config("policy_config", "every value of the policy, JSON", Cells::Text(policies)),
            config("trace_fingerprint", "hash of what the trace holds", Cells::Text(fingerprints)),
            config("model_version", "version of the model", Cells::Int(self.each(|_| Some(MODEL_VERSION.into())))),
        ])
    }
}
