//! Doing what the plan asks for and the cache does not hold.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, Mutex, PoisonError};

use rayreel_formats::trace::Trace;
use rayreel_replay::PathSource;
use rayreel_study::StudyError;
use rayreel_study::point::compute::compute;
use rayreel_study::point::key::Point;
use rayreel_study::point::task::{Computed, Missing, PointTask};
use rayreel_study::pool::{Event, Pool};
use rayreel_tracer::accel::{self, Built};

use crate::error::{PaperError, Result};
use crate::identity::Fingerprints;
use crate::ledger::{Ledger, PointCounts};
use crate::live::LiveSource;
use crate::meter::{Item, Meter, Tell, capture_weight, point_weight};
use crate::plan::Plan;
use crate::results::Results;
use crate::setup::Folders;
use crate::{lockstep, traces};

/// Does all that is missing, and puts the pictures into the output folder. The results of all points, and where they came from.
///
/// # Errors
/// The first thing that fails; an interruption.
pub fn execute(plan: &Plan<'_>, folders: &Folders, pool: &Pool, tell: &mut Tell<'_>) -> Result<(Results, PointCounts)> {
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
    let mut run =
        Execution { plan, pool, fingerprints, ledger, built: BTreeMap::new(), meter: Meter::new(total, tell) };
    let (live, recorded): (Vec<usize>, Vec<usize>) = todo.into_iter().partition(|i| plan.captures[*i].is_live());
    run.recorded(&recorded, &live)?;
    live.into_iter().try_for_each(|capture| run.live(capture))?;
    run.ledger.finish()
}

/// Whether something is missing of a point on a capture.
fn is_todo(ledger: &Ledger<'_>, capture: usize) -> bool {
    ledger.points_on(capture).any(|i| ledger.missing(i).any())
}

/// Expected work on what is missing of the points on a capture.
fn left(plan: &Plan<'_>, ledger: &Ledger<'_>, capture: usize) -> u64 {
    let weight = |i: usize| point_weight(&plan.captures[capture], ledger.point(i), ledger.missing(i));
    ledger.points_on(capture).map(weight).sum()
}

/// The experiment under way.
struct Execution<'a> {
    plan: &'a Plan<'a>,
    pool: &'a Pool,
    fingerprints: Fingerprints,
    ledger: Ledger<'a>,
    built: BTreeMap<usize, Built>,
    meter: Meter<'a>,
}

/// A trace that several points read; closed behind the last one.
struct SharedTrace {
    trace: Option<Arc<Trace>>,
    /// Points that still need it.
    left: usize,
}

/// A point to compute.
struct Job {
    index: usize,
    capture: usize,
    point: Point,
    missing: Missing,
    weight: u64,
}

impl Execution<'_> {
    /// Makes the traces of captures and computes the points on them; `later` are captures that come after them.
    fn recorded(&mut self, captures: &[usize], later: &[usize]) -> Result<()> {
        let mut traces = BTreeMap::new();
        for &capture in captures {
            let trace = self.trace(capture)?;
            let left = self.ledger.points_on(capture).filter(|i| self.ledger.missing(*i).any()).count();
            if left > 0 {
                traces.insert(capture, Mutex::new(SharedTrace { trace: Some(Arc::new(trace)), left }));
            }
        }
        let later = later.iter().map(|i| capture_weight(&self.plan.captures[*i]) + left(self.plan, &self.ledger, *i));
        let jobs = self.jobs(captures);
        self.meter.left(jobs.iter().map(|job| job.weight).sum::<u64>() + later.sum::<u64>());
        let Self { plan, pool, ledger, meter, .. } = self;
        let work = |_, job: &Job| job.run(plan, &traces, pool, meter);
        pool.run(&jobs, work, |event| {
            let Event::Done { index, result } = event else { return Ok(()) };
            let job = &jobs[index];
            let computed = match result {
                // What others have finished is still to be kept.
                Err(error) if error.is_interruption() => return Ok(()),
                result => result?,
            };
            ledger.keep(job.index, computed)?;
            meter.close(Item::Point(job.index), job.weight);
            Ok::<_, PaperError>(())
        })?;
        self.check_stop()
    }

    /// What is missing on some captures: the longest first, so that none is left over at the end.
    fn jobs(&self, captures: &[usize]) -> Vec<Job> {
        let job = |capture: usize, index: usize| {
            let (point, missing) = (self.ledger.point(index).clone(), self.ledger.missing(index));
            let weight = point_weight(&self.plan.captures[capture], &point, missing);
            missing.any().then_some(Job { index, capture, point, missing, weight })
        };
        let on = |capture: &usize| {
            let capture = *capture;
            self.ledger.points_on(capture).filter_map(move |index| job(capture, index)).collect::<Vec<_>>()
        };
        let mut jobs: Vec<Job> = captures.iter().flat_map(on).collect();
        jobs.sort_by_key(|job| (std::cmp::Reverse(job.weight), job.index));
        jobs
    }

    /// The trace of a capture, from the cache or made; its points are looked up under what it holds.
    fn trace(&mut self, index: usize) -> Result<Trace> {
        let (capture, item) = (&self.plan.captures[index], Item::Capture(index));
        let weight = capture_weight(capture);
        let path = capture.path.as_deref().ok_or(PaperError::Fault { detail: "a live capture has no file" })?;
        let trace = match traces::cached(path, &capture.meta) {
            Some(trace) => trace,
            None => {
                self.build(capture.scene)?;
                let (scene, n) = (&self.plan.stages[capture.scene], capture.meta.samples);
                let built = &self.built[&capture.scene];
                traces::make(&scene.scene, built, (path, &capture.meta), &self.pool.stop, |part, of| {
                    self.meter.tell(item, weight, (part, of), &|| format!("capture {} {n}x{n}", scene.name));
                })?
            }
        };
        self.meter.close(item, weight);
        self.check_stop()?;
        let fingerprint = trace.fingerprint()?.to_string();
        if self.fingerprints.get(&capture.identity).as_ref() != Some(&fingerprint) {
            self.fingerprints.remember(&capture.identity, &fingerprint)?;
            self.ledger.look_up(index, &fingerprint)?;
        }
        Ok(trace)
    }

    /// Traces the frames of a capture and computes its points on them.
    fn live(&mut self, index: usize) -> Result<()> {
        let (capture, item) = (&self.plan.captures[index], Item::Capture(index));
        self.build(capture.scene)?;
        let scene = &self.plan.stages[capture.scene];
        let source = LiveSource::new(&scene.scene, &self.built[&capture.scene], &capture.meta);
        let weight = capture_weight(capture) + left(self.plan, &self.ledger, index);
        let numbers: Vec<usize> = self.ledger.points_on(index).filter(|i| self.ledger.missing(*i).any()).collect();
        let points: Vec<(&Point, Missing)> =
            numbers.iter().map(|i| (self.ledger.point(*i), self.ledger.missing(*i))).collect();
        let computed = lockstep::run(&points, &source, self.pool, |part, of| {
            let frame = u64::from(capture.meta.first_frame) + part;
            self.meter.tell(item, weight, (part, of), &|| format!("{}, frame {frame}", scene.name));
        })?;
        self.check_stop()?;
        for (i, computed) in numbers.into_iter().zip(computed) {
            self.ledger.keep(i, computed)?;
        }
        self.meter.close(item, weight);
        Ok(())
    }

    /// Builds the BVH of a scene, once.
    fn build(&mut self, scene: usize) -> Result<()> {
        if let Entry::Vacant(slot) = self.built.entry(scene) {
            let scene = &self.plan.stages[scene].scene;
            slot.insert(
                accel::build(scene)
                    .map_err(|e| PaperError::Scene { scene: scene.name.clone(), detail: e.to_string() })?,
            );
        }
        Ok(())
    }

    /// Ends the experiment if that was asked for.
    fn check_stop(&self) -> Result<()> {
        if self.pool.stop.is_requested() { Err(PaperError::interrupted()) } else { Ok(()) }
    }
}

impl Job {
    /// Computes the point. The trace is closed behind its last one.
    fn run(
        &self,
        plan: &Plan<'_>,
        traces: &BTreeMap<usize, Mutex<SharedTrace>>,
        pool: &Pool,
        meter: &Meter<'_>,
    ) -> Result<Computed, StudyError> {
        let closed = || StudyError::Usage { detail: "a trace was closed too early".into() };
        let slot = traces.get(&self.capture).ok_or_else(closed)?;
        let trace = slot.lock().unwrap_or_else(PoisonError::into_inner).trace.clone().ok_or_else(closed)?;
        let tree = PointTask::<Trace>::simulates(&self.point, self.missing).then(|| trace.topology());
        let scene = plan.scene_of(&plan.captures[self.capture]);
        let computed = compute(&self.point, self.missing, (&*trace, tree.as_ref()), &pool.stop, |part, whole| {
            let doing = || format!("{scene} under {}", self.point.policy.name);
            meter.tell(Item::Point(self.index), self.weight, (part, whole), &doing);
        })?;
        drop(trace);
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        slot.left -= 1;
        if slot.left == 0 {
            slot.trace = None;
        }
        Ok(computed)
    }
}
