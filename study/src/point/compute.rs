//! A point, computed.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crate::error::{Result, StudyError};
use crate::point::key::{Key, Point};
use crate::point::row::{Column, Row};
use crate::point::task::{Computed, Missing, PointTask};
use rayreel_formats::Error as TraceError;
use rayreel_formats::error::Fault;
use rayreel_formats::limits::MEMORY;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::probes::Watch;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::source::PathSource;
use rayreel_replay::{NamedPolicy, ReplayError, Stop};

/// Results of a point on its source, in one pass over its frames. `tell` is told how many tiles are done, of how many; `tree` is the
/// source's topology, if a machine simulates anything.
///
/// # Errors
/// A policy that does not fit source or machine; a source that cannot be read; [`ReplayError::Interrupted`].
pub fn compute<S: PathSource + ?Sized>(
    point: &Point,
    missing: Missing,
    source: (&S, Option<&Topology>),
    stop: &Stop,
    tell: impl FnMut(u64, u64),
) -> Result<Computed> {
    Ok(compute_all(&[(point, missing)], source, stop, tell)?.pop().unwrap_or_default())
}

/// The same of several points that share a replay ([`Point::shares_replay`]).
///
/// # Errors
/// Those of any of them.
pub fn compute_all<S: PathSource + ?Sized>(
    points: &[(&Point, Missing)],
    (source, tree): (&S, Option<&Topology>),
    stop: &Stop,
    mut tell: impl FnMut(u64, u64),
) -> Result<Vec<Computed>> {
    let mut task = PointTask::new(points, source, stop)?;
    let tiles = u64::from(source.meta().tile_count());
    let frames = points[0].0.frame_numbers();
    let all = tiles * frames.len() as u64;
    for (done, frame) in (0..).map(|i| i * tiles).zip(frames) {
        task.frame(frame, tree, &mut Watch::new(|now| tell(done + now, all)))?;
        tell(done + tiles, all);
    }
    Ok(task.finish())
}

/// The row of a point on its source, with what its columns are. A point that cannot be computed, whoever tries, has a row that says
/// why.
///
/// # Errors
/// What another attempt may not meet: a source that cannot be read now, or an interruption.
pub fn compute_row<S: PathSource + ?Sized>(
    point: &Point,
    key: &Key,
    (source, tree): (&S, &Topology),
    stop: &Stop,
    tell: impl FnMut(u64, u64),
) -> Result<(Row, Vec<Column>)> {
    let missing = Missing { row: true, details: false };
    // What is wrong is told in the same words whoever asks: a key knows no names.
    let point = &nameless(point);
    // A fault of the model costs its point and not the sweep. Nothing that outlives the call is left half changed: the source
    // only ever keeps whole tiles.
    let ended = catch_unwind(AssertUnwindSafe(|| compute(point, missing, (source, Some(tree)), stop, tell)));
    let why = match ended {
        Ok(Ok(Computed { row: Some(row), .. })) => return Ok(row),
        Ok(Ok(_)) => return Err(StudyError::Usage { detail: "no row is wanted of this point".into() }),
        Ok(Err(error)) if may_pass(&error) => return Err(error),
        Ok(Err(error)) => chain(&error),
        Err(panic) => format!("internal fault, please report it: {}", message(&*panic)),
    };
    Ok((Row::failed(key.clone(), why), Vec::new()))
}

/// The point with a machine and a policy that have no names: neither enters its key.
fn nameless(point: &Point) -> Point {
    let name = || "of this point".to_owned();
    let machine = point.machine.as_deref().map(|machine| Arc::new(NamedMachine { name: name(), ..machine.clone() }));
    let policy = Arc::new(NamedPolicy { name: name(), ..(*point.policy).clone() });
    Point { machine, policy, ..point.clone() }
}

/// The rows of several points that share a replay, in their order. Where they fail together each is tried by itself, so that none
/// pays for another.
///
/// # Errors
/// Each as [`compute_row`].
pub fn compute_rows<S: PathSource + ?Sized>(
    points: &[(&Point, &Key)],
    source: (&S, &Topology),
    stop: &Stop,
    mut tell: impl FnMut(u64, u64),
) -> Vec<Result<(Row, Vec<Column>)>> {
    let missing = Missing { row: true, details: false };
    let wanted: Vec<_> = points.iter().map(|(point, _)| (*point, missing)).collect();
    let together = AssertUnwindSafe(|| compute_all(&wanted, (source.0, Some(source.1)), stop, &mut tell));
    let together = if points.len() > 1 { catch_unwind(together).ok().and_then(Result::ok) } else { None };
    if let Some(rows) = together.map(|all| all.into_iter().filter_map(|c| c.row).collect::<Vec<_>>())
        && rows.len() == points.len()
    {
        return rows.into_iter().map(Ok).collect();
    }
    points.iter().map(|(point, key)| compute_row(point, key, source, stop, &mut tell)).collect()
}

/// Whether another attempt may succeed. A key names the checksums of all that a trace holds: bytes that do not fit them are not those of
/// the point, and another copy of the file may have the right ones.
fn may_pass(error: &StudyError) -> bool {
    match error {
        StudyError::Replay(ReplayError::Interrupted) => true,
        StudyError::Replay(ReplayError::Trace { source, .. }) => match &**source {
            TraceError::Io { .. } => true,
            TraceError::Damaged { fault, .. } => is_of_bytes(fault),
            // How much memory may be taken is no part of a key: with more of it the point can be computed.
            TraceError::LimitExceeded { what, .. } => *what == MEMORY,
            _ => false,
        },
        _ => false,
    }
}

/// Whether the bytes are not those that were written, and not what was written with them.
fn is_of_bytes(fault: &Fault) -> bool {
    match fault {
        Fault::Checksum { .. } | Fault::Truncated { .. } => true,
        Fault::Again { fault, .. } => is_of_bytes(fault),
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

/// What a panic said.
fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}

#[cfg(test)]
mod tests {
    use rayreel_formats::error::Place;

    use super::*;

    #[test]
    fn only_what_the_system_or_a_signal_caused_may_pass() {
        let trace = |source: rayreel_formats::Error| {
            let what = "tile 3".to_owned();
            StudyError::Replay(ReplayError::Trace { what, frame: 0, source: Box::new(source) })
        };
        assert!(may_pass(&StudyError::Replay(ReplayError::Interrupted)));
        // A wrong use is wrong the next time too: for everybody, whatever its words.
        assert!(!may_pass(&trace(TraceError::usage("interrupted"))));
        let damaged = |fault: Fault| TraceError::Damaged { place: Place::unknown(), fault };
        let cut = Fault::Truncated { needed: 8, available: 3 };
        assert!(may_pass(&trace(damaged(cut.clone()))));
        assert!(may_pass(&trace(damaged(Fault::Again { fault: Box::new(cut), fetched: "twice".into() }))));
        assert!(!may_pass(&trace(damaged(Fault::Content("a ray without an end".into())))));
        assert!(!may_pass(&StudyError::Usage { detail: "interrupted".into() }));
    }
}
