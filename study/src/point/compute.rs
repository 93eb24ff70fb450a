//! A point, computed.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::error::{Result, StudyError};
use crate::point::key::{Key, Point};
use crate::point::row::{Column, Row};
use crate::report::{Origin, Report};
use rayreel_machine::system::Probe;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::frame::{Options, Replayer};
use rayreel_replay::simulate::{MachineFrame, MachineRun, simulate};
use rayreel_replay::source::PathSource;

/// The row of a point on its trace, with what its columns are. A point that cannot be computed, whoever tries, has a row that
/// says why.
///
/// # Errors
/// What another attempt may not meet: a trace that cannot be read now, or an interruption.
pub fn compute<S: PathSource, P: Probe>(
    point: &Point,
    key: &Key,
    source: &S,
    tree: &Topology,
    probe: &mut P,
) -> Result<(Row, Vec<Column>)> {
    // A fault of the model costs its point and not the sweep. Nothing that outlives the call is left half changed: the source
    // only ever keeps whole tiles.
    let report = catch_unwind(AssertUnwindSafe(|| replay(point, source, tree, probe)));
    match report {
        Ok(Ok(report)) => Ok(Row::new(key.clone(), &report)),
        Ok(Err(error)) if is_passing(&error) => Err(error),
        Ok(Err(error)) => Ok((Row::failed(key.clone(), chain(&error)), Vec::new())),
        Err(panic) => {
            Ok((Row::failed(key.clone(), format!("internal fault, please report it: {}", said(&*panic))), Vec::new()))
        }
    }
}

fn replay<S: PathSource, P: Probe>(point: &Point, source: &S, tree: &Topology, probe: &mut P) -> Result<Report> {
    let mut replayer = Replayer::new(source, &point.policy.policy, Options::default())?;
    let (mut counted, mut runs) = (Vec::new(), Vec::new());
    let (first, count) = point.frames;
    for frame in first..first + count {
        let Some(machine) = &point.machine else {
            counted.push(replayer.frame(frame)?.stats);
            continue;
        };
        probe.begin(frame);
        let named = (machine.name.as_str(), &machine.config);
        let MachineFrame { replay, stats, energy, paths } = simulate(&mut replayer, frame, tree, named, probe)?;
        counted.push(replay.stats);
        runs.push(MachineRun { stats, energy, paths });
    }
    let origin = Origin { trace: String::new(), trace_digest: None };
    let report = Report::new(&origin, &point.policy, source.meta(), &counted).without_tiles();
    Ok(match &point.machine {
        Some(machine) => report.with_machine(machine, &runs),
        None => report,
    })
}

/// Whether another attempt may succeed.
fn is_passing(error: &StudyError) -> bool {
    match error {
        StudyError::Interrupted => true,
        StudyError::Replay(rayreel_replay::ReplayError::Trace { source, .. }) => {
            use rayreel_formats::Error;
            matches!(**source, Error::Io { .. } | Error::Usage { .. })
        }
        _ => false,
    }
}

/// An error with its causes, in one line.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut next = error.source();
    while let Some(cause) = next {
        text += &format!(": {cause}");
        next = cause.source();
    }
    text
}

fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}
