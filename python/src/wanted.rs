//! What of a table is wanted, and under which policy on which machine.

use pyo3::prelude::*;
use rayreel_columns::{Data, Head, Selection, What};
use rayreel_formats::Trace;
use rayreel_machine::NamedMachine;
use rayreel_machine::config::schema::is_machine_override;
use rayreel_replay::{NamedPolicy, Stop};

use crate::error::{raise, refuse};

/// What of a table is wanted.
#[derive(Clone)]
pub struct Wanted {
    what: What,
    selection: Selection,
    policy: Option<NamedPolicy>,
    machine: Option<NamedMachine>,
    interval: Option<u64>,
    columns: Option<Vec<String>>,
}

/// How a table is asked for.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    frames: Option<(u32, u32)>,
    tiles: Option<String>,
    policy: Option<String>,
    machine: Option<String>,
    overrides: Vec<String>,
    interval: Option<u64>,
    columns: Option<Vec<String>>,
}

impl Wanted {
    /// Reads what is asked for.
    pub fn new(trace: &Trace, what: &str, asked: Asked) -> PyResult<Self> {
        let all = || What::ALL.map(What::name).join(", ");
        let what =
            What::named(what).ok_or_else(|| refuse(format!("there is no table {what:?}; take one of {}", all())))?;
        let mut selection = Selection::all(trace.meta());
        if let Some((first, end)) = asked.frames {
            selection = selection.frames(first..end).map_err(|e| raise(&e))?;
        }
        if let Some(tiles) = &asked.tiles {
            selection = selection.tiles(tiles).map_err(|e| raise(&e))?;
        }
        let (policy, machine) = (asked.policy.as_deref(), asked.machine.as_deref());
        let machine = machine.or(what.takes_machine().then_some("sgrt-ti2"));
        let policy = policy.or(what.is_simulated().then_some("full"));
        let lacks = |kind: Kind| match kind {
            Kind::Machine => format!("table {} is the same for every machine; leave it out", what.name()),
            Kind::Policy if what.takes_policy() => "there is none; name one, or leave it out".into(),
            Kind::Policy => format!("table {} takes no policy; leave it out", what.name()),
        };
        let (policy, machine) = settings(policy, machine, &asked.overrides, lacks)?;
        let wanted = Self { what, selection, policy, machine, interval: asked.interval, columns: asked.columns };
        wanted.head(trace)?;
        Ok(wanted)
    }

    /// What there is to get.
    pub fn data<'a>(&'a self, trace: &'a Trace, stop: &Stop) -> Data<'a> {
        Data {
            trace,
            what: self.what,
            selection: self.selection.clone(),
            columns: self.columns.clone(),
            policy: self.policy.as_ref(),
            machine: self.machine.as_ref(),
            interval: self.interval,
            stop: stop.clone(),
        }
    }

    /// The columns that are wanted.
    pub fn head(&self, trace: &Trace) -> PyResult<Head> {
        self.data(trace, &Stop::never()).head().map_err(|e| raise(&e))
    }
}

/// What an override is for.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A value of a machine.
    Machine,
    /// A value of a policy.
    Policy,
}

/// Policy and machine by preset or file, with overrides for both. `lacks` says why one of them is not there to be overridden, and what
/// to do.
pub fn settings(
    policy: Option<&str>,
    machine: Option<&str>,
    overrides: &[String],
    lacks: impl Fn(Kind) -> String,
) -> PyResult<(Option<NamedPolicy>, Option<NamedMachine>)> {
    let (of_machine, of_policy): (Vec<_>, Vec<_>) =
        overrides.iter().cloned().partition(|text| is_machine_override(text));
    let kinds = [("machine", machine, &of_machine, Kind::Machine), ("policy", policy, &of_policy, Kind::Policy)];
    for (name, there, texts, kind) in kinds {
        if let (None, Some(text)) = (there, texts.first()) {
            return Err(refuse(format!("override {text} is for a {name}, and {}", lacks(kind))));
        }
    }
    let policy = policy.map(|name| NamedPolicy::load(name, &of_policy)).transpose().map_err(|e| raise(&e))?;
    let machine = machine.map(|name| NamedMachine::load(name, &of_machine)).transpose().map_err(|e| raise(&e))?;
    Ok((policy, machine))
}
