//! Rows of anchors with their values.

use rayreel_machine::NamedMachine;
use rayreel_study::StudyError;
use rayreel_study::pool::Pool;
use serde::Serialize;

use super::anchor::{Row, Value};
use super::list;
use super::run::Runs;
use crate::error::{PaperError, Result};

/// The machine that all others extend.
const BASE: &str = "sgrt-ti2";

/// A row that was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// What it is; of a row of one scene with that scene.
    pub name: String,
    /// The preset; null if no machine enters.
    pub machine: Option<&'static str>,
    /// Where the bounds are from, and how they follow.
    pub source: &'static str,
    /// Least value inside; null without a lower bound.
    pub low: Option<f64>,
    /// Largest value inside; null without an upper bound.
    pub high: Option<f64>,
    /// The value; null if it could not be made.
    pub value: Option<f64>,
    /// Unit of bounds and value.
    pub unit: &'static str,
    /// Whether the value lies within the bounds.
    pub inside: bool,
    /// Why it does not; null if it does, or if nobody knows.
    pub explanation: Option<&'static str>,
}

impl Measured {
    /// Whether the value lies outside and nothing says why.
    pub fn fails(&self) -> bool {
        !self.inside && self.explanation.is_none()
    }
}

/// The machines that anchors name, each once, in the order of the list.
pub fn machines() -> Vec<&'static str> {
    let mut all = Vec::new();
    for machine in rows().filter_map(|row| row.machine) {
        if !all.contains(&machine) {
            all.push(machine);
        }
    }
    all
}

fn rows() -> impl Iterator<Item = Row> {
    list::all().flat_map(|anchor| anchor.rows())
}

/// Measures the anchors of some presets, or all of them if none is named, on pictures of `size`. `tell` is told how many replays are
/// done, how many there are, and the scene of the last.
///
/// # Errors
/// A machine that no anchor names; a size that no picture has; an interruption.
pub fn measure(
    size: (u32, u32),
    presets: &[String],
    pool: &Pool,
    tell: &mut dyn FnMut(u64, u64, &str),
) -> Result<Vec<Measured>> {
    presets.iter().try_for_each(|preset| check(preset))?;
    let chosen = |row: &Row| presets.is_empty() || row.machine.is_some_and(|m| presets.iter().any(|p| p == m));
    let rows: Vec<Row> = rows().filter(chosen).collect();
    let mut runs = Runs::default();
    for row in &rows {
        if let Value::Runs(of, _) = &row.anchor.value {
            of.iter().for_each(|of| runs.want(row, of));
        }
    }
    runs.compute(size, pool, tell)?;
    rows.iter().map(|row| Ok(measured(row, value(row, &runs)?))).collect()
}

fn check(preset: &str) -> Result<()> {
    let known = machines();
    if known.contains(&preset) {
        return Ok(());
    }
    let detail = format!("no anchor is stated for the machine {preset}; there are {}", known.join(", "));
    Err(PaperError::Study(StudyError::Usage { detail }))
}

fn value(row: &Row, runs: &Runs) -> Result<Option<f64>> {
    match &row.anchor.value {
        Value::Config(of) => {
            let load = |name| NamedMachine::load(name, &[]);
            Ok(of(&load(row.machine.unwrap_or(BASE))?.config, &load(BASE)?.config))
        }
        Value::Runs(wanted, of) => {
            let runs: Option<Vec<_>> = wanted.iter().map(|wanted| runs.of(row, wanted)).collect();
            Ok(runs.and_then(|runs| of(&runs)).filter(|value| value.is_finite()))
        }
    }
}

fn measured(row: &Row, value: Option<f64>) -> Measured {
    let anchor = row.anchor;
    let inside = value.is_some_and(|value| anchor.holds(value));
    Measured {
        name: row.scene.map_or_else(|| anchor.name.to_owned(), |scene| format!("{}: {scene}", anchor.name)),
        machine: row.machine,
        source: anchor.source,
        low: anchor.low,
        high: anchor.high,
        value,
        unit: anchor.unit,
        inside,
        explanation: value.filter(|_| !inside).and_then(|value| row.explanation(value)),
    }
}

#[cfg(test)]
mod tests {
    use rayreel_replay::Stop;

    use super::*;

    /// A file was asked for, and then refused.
    #[test]
    fn a_machine_without_anchors_is_refused_with_those_that_have_some() {
        let pool = Pool { threads: 1, stop: Stop::never() };
        for name in ["nosuch", "mine.toml"] {
            let said = measure((16, 8), &[name.into()], &pool, &mut |_, _, _| {}).unwrap_err().to_string();
            let expected = format!("for the machine {name}; there are {}", machines().join(", "));
            assert!(said.ends_with(&expected), "{said}");
        }
    }
}
