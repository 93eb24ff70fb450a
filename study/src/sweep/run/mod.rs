//! Computing the points of a shard.
//!
//! Workers take points stage by stage, in one in the order of the plan, and hand their rows to one writer, which puts what is finished into a segment
//! while they go on: no worker waits for a disk. A row is safe once its segment has its name, so a `kill -9` costs the points that
//! were being computed and those of the segment being written. A signal ends every simulation at its next tile and writes what is
//! finished.

mod groups;
mod saver;
mod shape;
mod stages;
mod traces;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use crate::error::Result;
use crate::point::compute::{chain, compute_rows};
use crate::point::row::{Column, Row};
use crate::pool::{Event, Pool};
use crate::sweep::folder::Folder;
use crate::sweep::plan::{BUCKET, PointRef};
use crate::sweep::segment;
use groups::Group;
use saver::Saver;
use stages::{Stage, stages};

pub use shape::{Outcome, RunProgress, Settings};
use traces::SharedTraces;

/// A row with what its columns are; or why this attempt could not compute it.
type Attempted = Result<(Row, Vec<Column>), String>;

/// Runs a shard. `tell` is told how far it is: once before anything is computed, then several times a second.
///
/// # Errors
/// A folder that cannot be read or written. What is wrong with a point is in its row, or in the outcome.
pub fn run(folder: &Folder, settings: &Settings<'_>, mut tell: impl FnMut(&RunProgress)) -> Result<Outcome> {
    let plan = folder.plan();
    let range = settings.shard.points(plan.points.len());
    let mut outcome = Outcome { points: range.len(), ..Outcome::default() };
    let mut saver = Saver::new(folder, settings);
    let todo = missing(folder, range, &mut outcome, &mut saver)?;
    let stages = stages(plan, &todo, (settings.threads, settings.memory));
    let workers = Workers::new(folder, settings, &stages);
    let mut progress = RunProgress { skipped: outcome.skipped, todo: todo.len(), ..RunProgress::default() };
    tell(&progress);
    let mut last = Instant::now();
    let ended: Result<()> = stages.iter().try_for_each(|stage| {
        let pool = Pool { threads: stage.threads(settings.threads), stop: settings.stop.clone() };
        workers.traces.begin(stage.readers());
        pool.run(
            &stage.groups,
            |worker, group| workers.attempt(worker, stage, group),
            |event| {
                if let Event::Done { index, result } = event {
                    for (point, attempted) in stage.groups[index].1.iter().zip(result) {
                        match attempted {
                            Ok((row, columns)) => saver.take(*point, row, columns, &mut outcome)?,
                            Err(why) if !settings.stop.is_requested() => {
                                outcome.troubles.push((plan.describe(*point), why));
                            }
                            Err(_) => {}
                        }
                    }
                }
                if last.elapsed() >= settings.flush {
                    saver.flush_all()?;
                    last = Instant::now();
                }
                progress.saved = outcome.computed.saturating_sub(saver.waiting());
                progress.failed = outcome.failed;
                progress.done = outcome.computed as f64 + workers.part();
                tell(&progress);
                Ok(())
            },
        )
    });
    // What is computed is written whatever ended the run, and the error that ended it is told before one of these writes.
    let flushed = saver.flush_all();
    ended.and(flushed)?;
    progress.saved = outcome.computed;
    progress.done = outcome.computed as f64;
    tell(&progress);
    outcome.interrupted = settings.stop.is_requested();
    Ok(outcome)
}

/// The points that have no row yet, each key once; takes rows from elsewhere.
fn missing<'a>(
    folder: &'a Folder,
    range: std::ops::Range<usize>,
    outcome: &mut Outcome,
    saver: &mut Saver<'a>,
) -> Result<Vec<usize>> {
    let (mut todo, mut seen) = (Vec::new(), BTreeMap::new());
    if range.is_empty() {
        return Ok(todo);
    }
    for bucket in range.start / BUCKET..=(range.end - 1) / BUCKET {
        let held = segment::read(folder, bucket)?;
        let points = folder.bucket(bucket);
        let mut left = 0;
        for point in points.start.max(range.start)..points.end.min(range.end) {
            let key = &folder.plan().points[point].key;
            if held.rows.contains_key(key) {
                outcome.skipped += 1;
            } else if saver.reuse(bucket, key)? {
                outcome.reused += 1;
            } else if let Some(first) = seen.get(key) {
                left += usize::from(*first != bucket && saver.also_in(key, bucket));
            } else {
                seen.insert(key, bucket);
                todo.push(point);
                left += 1;
            }
        }
        saver.expect(bucket, left)?;
    }
    Ok(todo)
}

/// What the workers share.
struct Workers<'a> {
    folder: &'a Folder,
    settings: &'a Settings<'a>,
    traces: SharedTraces<'a>,
    /// How much of its points each worker has done, in millionths of one.
    parts: Vec<AtomicUsize>,
}

impl<'a> Workers<'a> {
    fn new(folder: &'a Folder, settings: &'a Settings<'a>, stages: &[Stage]) -> Self {
        let points = stages.iter().flat_map(|stage| &stage.groups).flat_map(|(_, group)| group);
        let traces = SharedTraces::new(folder, settings, points.copied());
        let workers = stages.iter().map(|stage| stage.threads(settings.threads)).max().unwrap_or(0);
        let parts = (0..workers).map(|_| AtomicUsize::new(0)).collect();
        Self { folder, settings, traces, parts }
    }

    /// Points being computed, in parts.
    fn part(&self) -> f64 {
        self.parts.iter().map(|part| part.load(Ordering::Relaxed) as f64 * 1e-6).sum()
    }

    /// Computes points that share a replay on worker number `worker`; what came of each.
    fn attempt(&self, worker: usize, stage: &Stage, (number, points): &(usize, Group)) -> Vec<Attempted> {
        let member = stage.convoy.as_ref().map(|convoy| convoy.join(*number, &self.settings.stop));
        let ended = self.compute(points, &self.parts[worker], |tiles| {
            member.iter().for_each(|member| member.is_at(tiles, &self.settings.stop));
        });
        self.parts[worker].store(0, Ordering::Relaxed);
        points.iter().for_each(|point| self.traces.release(self.folder.plan().points[*point].trace));
        ended.unwrap_or_else(|why| vec![Err(why); points.len()])
    }

    /// `through` is told how many tiles it is through with.
    fn compute(&self, points: &[usize], part: &AtomicUsize, through: impl Fn(u64)) -> Result<Vec<Attempted>, String> {
        let plan = self.folder.plan();
        let planned: Vec<_> = points.iter().map(|point| &plan.points[*point]).collect();
        let resolved: Result<Vec<_>> = planned.iter().map(|point| plan.resolve(point)).collect();
        let resolved = resolved.map_err(|e| e.to_string())?;
        let opened = self.traces.open(planned[0].trace)?;
        let all = points.len() as u64 * 1_000_000;
        let tell = |done: u64, of: u64| {
            part.store((done.min(of) * all / of.max(1)) as usize, Ordering::Relaxed);
            through(done);
        };
        let wanted: Vec<_> = resolved.iter().zip(&planned).map(|(point, planned)| (point, &planned.key)).collect();
        let rows = compute_rows(&wanted, (&opened.source, &opened.tree), &self.settings.stop, tell);
        // A row carries the key of what was computed: no other point may take it for its own.
        let path = opened.source.trace().reader().path().display().to_string();
        let checked = |(row, planned): (Result<(Row, Vec<Column>)>, &&PointRef)| match row {
            Ok((row, _)) if row.key != planned.key => {
                Err(format!("the plan has key {} for it, and what was computed has {}", planned.key, row.key))
            }
            // Nor may a row depend on where the trace lies.
            Ok((row, columns)) => {
                let error = row.error.map(|why| why.replace(&path, "the trace"));
                Ok((Row { error, ..row }, columns))
            }
            Err(error) => Err(chain(&error)),
        };
        Ok(rows.into_iter().zip(&planned).map(checked).collect())
    }
}
