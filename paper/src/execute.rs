//! Doing what the plan asks for and the cache does not hold.

use std::sync::atomic::Ordering;

use rayreel_formats::trace::Trace;
use rayreel_study::point::key::Point;
use rayreel_study::point::task::Missing;
use rayreel_study::pool::{Event, Pool};

use crate::error::{PaperError, Result};
use crate::identity::Fingerprints;
use crate::jobs::{Job, Jobs};
use crate::ledger::{Ledger, PointCounts};
use crate::live::LiveSource;
use crate::lockstep;
use crate::maker::Maker;
use crate::meter::{Item, Meter, Tell, capture_weight, point_weight};
use crate::plan::{Capture, Plan};
use crate::results::Results;
use crate::setup::Folders;

/// Does all that is missing, and puts the pictures into the output folder. `found` turns results, as far as they are there, into
/// what is told of a point that was finished. The results of all points, and where they came from.
///
/// # Errors
/// The first thing that fails; an interruption.
pub fn execute(
    plan: &Plan<'_>,
    folders: &Folders,
    pool: &Pool,
    tell: &mut Tell<'_>,
    found: &Found<'_>,
) -> Result<(Results, PointCounts)> {
    let mut ledger = Ledger::open(plan, folders)?;
    let fingerprints = Fingerprints::new(ledger.folder());
    for (i, capture) in plan.captures.iter().enumerate() {
        let known =
            if capture.is_live() { Some(capture.identity.clone()) } else { fingerprints.get(&capture.identity) };
        if let Some(source) = known {
            ledger.look_up(i, &source)?;
        }
    }
    let todo: Vec<usize> = (0..plan.captures.len()).filter(|capture| is_todo(&ledger, *capture)).collect();
    let total = todo.iter().map(|i| capture_weight(&plan.captures[*i]) + left(plan, &ledger, *i)).sum();
    let maker = Maker::new(plan, pool, Meter::new(total, tell));
    let mut run = Execution { plan, pool, maker: &maker, fingerprints, ledger, found };
    let (live, recorded): (Vec<usize>, Vec<usize>) = todo.into_iter().partition(|i| plan.captures[*i].is_live());
    run.recorded(&batches(plan, &recorded), &live)?;
    live.into_iter().try_for_each(|capture| run.live(capture))?;
    run.ledger.finish()
}

/// What is told of a point, by number, of which the figures are known.
pub type Found<'a> = dyn Fn(usize, &Ledger<'_>) -> Vec<String> + 'a;

/// Whether something is missing of a point on a capture.
fn is_todo(ledger: &Ledger<'_>, capture: usize) -> bool {
    ledger.points_on(capture).any(|i| ledger.missing(i).any())
}

/// Expected work on what is missing of the points on a capture.
fn left(plan: &Plan<'_>, ledger: &Ledger<'_>, capture: usize) -> u64 {
    let weight = |i: usize| point_weight(&plan.captures[capture], ledger.point(i), ledger.missing(i));
    ledger.points_on(capture).map(weight).sum()
}

/// Captures whose points are computed together while the next ones are made. Those of a scene of one picture size are a batch; of
/// the first of them the smallest goes before all others, for its figures are there soon. The plan's order stays else.
fn batches(plan: &Plan<'_>, captures: &[usize]) -> Vec<Vec<usize>> {
    let kind = |capture: usize| {
        let Capture { scene, meta, .. } = &plan.captures[capture];
        (*scene, meta.width, meta.height)
    };
    let mut batches: Vec<Vec<usize>> = Vec::new();
    for &capture in captures {
        match batches.iter_mut().find(|batch| kind(batch[0]) == kind(capture)) {
            Some(batch) => batch.push(capture),
            None => batches.push(vec![capture]),
        }
    }
    if let Some(first) = batches.first_mut().filter(|first| first.len() > 1) {
        first.sort_by_key(|capture| capture_weight(&plan.captures[*capture]));
        let smallest = first.remove(0);
        batches.insert(0, vec![smallest]);
    }
    batches
}

/// The experiment under way.
struct Execution<'a> {
    plan: &'a Plan<'a>,
    pool: &'a Pool,
    maker: &'a Maker<'a>,
    fingerprints: Fingerprints,
    ledger: Ledger<'a>,
    found: &'a Found<'a>,
}

impl Execution<'_> {
    /// Makes the traces of captures and computes the points on them, batch by batch: while points of one are computed, the traces
    /// of the next are made. `live` are captures that come after them.
    fn recorded(&mut self, batches: &[Vec<usize>], live: &[usize]) -> Result<()> {
        let Some(first) = batches.first() else { return Ok(()) };
        let mut made = self.maker.traces(first)?;
        for (i, batch) in batches.iter().enumerate() {
            self.maker.check_stop()?;
            for (capture, trace) in batch.iter().zip(&made) {
                self.know(*capture, trace)?;
            }
            let jobs = Jobs::new((self.plan, self.pool.threads), &self.ledger, batch, made);
            let later = batches[i + 1..].iter().flatten().chain(live);
            let later = later.map(|i| capture_weight(&self.plan.captures[*i]) + left(self.plan, &self.ledger, *i));
            self.maker.meter.left(jobs.weight() + later.sum::<u64>());
            let maker = self.maker;
            made = std::thread::scope(|scope| {
                let ahead = batches.get(i + 1).map(|next| scope.spawn(|| maker.traces(next)));
                let computed = self.compute(&jobs);
                // After a failure nobody needs what is being made.
                maker.abandoned.store(computed.is_err(), Ordering::Relaxed);
                let ahead = ahead.map_or(Ok(Vec::new()), |ahead| {
                    ahead.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
                });
                computed.and(ahead)
            })?;
        }
        self.maker.check_stop()
    }

    /// A trace is there: its points are looked up under what it holds.
    fn know(&mut self, capture: usize, trace: &Trace) -> Result<()> {
        let (identity, fingerprint) = (&self.plan.captures[capture].identity, trace.fingerprint()?.to_string());
        if self.fingerprints.get(identity).as_ref() != Some(&fingerprint) {
            self.fingerprints.remember(identity, &fingerprint)?;
            self.ledger.look_up(capture, &fingerprint)?;
        }
        Ok(())
    }

    /// Computes points and keeps what comes of them.
    fn compute(&mut self, jobs: &Jobs) -> Result<()> {
        let Self { plan, pool, maker, ledger, found, .. } = self;
        jobs.groups.iter().try_for_each(|group| {
            let work = |_, job: &Job| jobs.run((group, job), plan, pool, &maker.meter);
            group.pool(pool).run(&group.list, work, |event| {
                let Event::Done { index, result } = event else { return Ok(()) };
                let job = &group.list[index];
                let computed = match result {
                    // What others have finished is still to be kept.
                    Err(error) if error.is_interruption() => return Ok(()),
                    result => result?,
                };
                for ((number, ..), computed) in job.points.iter().zip(computed) {
                    ledger.keep(*number, computed)?;
                }
                maker.meter.close(Item::Point(job.points[0].0), job.weight);
                for text in job.points.iter().flat_map(|(number, ..)| found(*number, ledger)) {
                    maker.meter.found(&text);
                }
                Ok::<_, PaperError>(())
            })
        })
    }

    /// Traces the frames of a capture and computes its points on them.
    fn live(&mut self, index: usize) -> Result<()> {
        let (capture, item) = (&self.plan.captures[index], Item::Capture(index));
        let scene = &self.plan.stages[capture.scene];
        let source = LiveSource::new(&scene.scene, self.maker.built(capture.scene)?, &capture.meta);
        let weight = capture_weight(capture) + left(self.plan, &self.ledger, index);
        let numbers: Vec<usize> = self.ledger.points_on(index).filter(|i| self.ledger.missing(*i).any()).collect();
        let points: Vec<(&Point, Missing)> =
            numbers.iter().map(|i| (self.ledger.point(*i), self.ledger.missing(*i))).collect();
        let computed = lockstep::run(&points, &source, self.pool, |part, of| {
            let frame = u64::from(capture.meta.first_frame) + part;
            self.maker.meter.tell(item, weight, (part, of), &|| format!("{}, frame {frame}", scene.name));
        })?;
        self.maker.check_stop()?;
        for (i, computed) in numbers.into_iter().zip(computed) {
            self.ledger.keep(i, computed)?;
        }
        self.maker.meter.close(item, weight);
        Ok(())
    }
}
