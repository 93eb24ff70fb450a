//! What is missing on some captures, as jobs: points that share a replay are one.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use rayreel_formats::trace::Trace;
use rayreel_replay::{Detail, PathSource};
use rayreel_study::StudyError;
use rayreel_study::point::compute::compute_all;
use rayreel_study::point::convoy::{self, Convoy};
use rayreel_study::point::key::Point;
use rayreel_study::point::task::{Computed, Missing, PointTask};
use rayreel_study::point::tile_cache::{MemoryBudget, TileCache};
use rayreel_study::pool::Pool;

use crate::ledger::Ledger;
use crate::meter::{Item, Meter, point_weight};
use crate::plan::{Capture, Plan};

/// Memory for what the points of a batch decode once, bytes: at 512x256 all of most batches.
const DECODED: usize = 1 << 30;

/// Jobs and the traces that they read.
pub struct Jobs {
    /// One group after the other.
    pub groups: Vec<Group>,
    traces: BTreeMap<usize, Mutex<SharedTrace>>,
}

/// Jobs that run at a time, as far as there are threads.
pub struct Group {
    /// The longest first, so that none is left over at the end.
    pub list: Vec<Job>,
    /// All of them run at a time, side by side through one trace.
    convoy: Option<Convoy>,
}

/// Points to compute.
pub struct Job {
    /// Its place in its group.
    number: usize,
    capture: usize,
    /// Their numbers, and what is missing of each.
    pub points: Vec<(usize, Point, Missing)>,
    /// Expected work.
    pub weight: u64,
}

/// A trace that several jobs read; closed behind the last one.
struct SharedTrace {
    trace: Option<Arc<TileCache>>,
    /// Jobs that still need it.
    left: usize,
}

impl Group {
    fn new(mut list: Vec<Job>, convoy: Option<Convoy>) -> Self {
        list.sort_by_key(|job| (std::cmp::Reverse(job.weight), job.points[0].0));
        list.iter_mut().enumerate().for_each(|(number, job)| job.number = number);
        Self { list, convoy }
    }

    fn convoy(list: Vec<Job>) -> Self {
        // All of them work at a time: with fewer, `paper` took no more CPU time and two thirds more memory (1.4 GB, 2.3 GB).
        let convoy = Convoy::new(list.len(), list.len());
        Self::new(list, Some(convoy))
    }

    /// The threads that run its jobs: one for each that goes side by side with others, for nobody could wait for one that has not begun.
    pub fn pool(&self, pool: &Pool) -> Pool {
        let threads = if self.convoy.is_some() { self.list.len() } else { pool.threads };
        Pool { threads, ..pool.clone() }
    }
}

/// What is missing on a capture.
fn jobs_on(capture: usize, plan: &Plan<'_>, ledger: &Ledger<'_>) -> Vec<Job> {
    let mut list: Vec<Job> = Vec::new();
    for number in ledger.points_on(capture) {
        let (point, missing) = (ledger.point(number), ledger.missing(number));
        if !missing.any() {
            continue;
        }
        let weight = point_weight(&plan.captures[capture], point, missing);
        // Every cycle of two machines takes two threads; what is estimated takes all of them anyway.
        let shares = |job: &&mut Job| point.detail != Detail::Full && point.shares_replay(&job.points[0].1);
        let member = (number, point.clone(), missing);
        match list.iter_mut().find(shares) {
            Some(job) => {
                job.points.push(member);
                job.weight += weight;
            }
            None => list.push(Job { number: 0, capture, points: vec![member], weight }),
        }
    }
    list
}

/// Whether jobs on a capture go side by side. Those of which every cycle is simulated do not: each would take a thread.
fn go_side_by_side(list: &[Job], capture: &Capture) -> bool {
    let estimated = list.iter().all(|job| job.points[0].1.detail != Detail::Full);
    let meta = &capture.meta;
    estimated && list.len() > 1 && convoy::is_worth((meta.width, meta.height), meta.samples)
}

impl Jobs {
    /// What is missing on captures, of which these are the traces. With one thread one job runs after the other.
    pub fn new(
        (plan, threads): (&Plan<'_>, usize),
        ledger: &Ledger<'_>,
        captures: &[usize],
        traces: Vec<Trace>,
    ) -> Self {
        let (mut groups, mut others) = (Vec::new(), Vec::new());
        let (mut shared, budget) = (BTreeMap::new(), MemoryBudget::new(DECODED));
        for (&capture, trace) in captures.iter().zip(traces) {
            let list = jobs_on(capture, plan, ledger);
            let (left, side_by_side) = (list.len(), threads > 1 && go_side_by_side(&list, &plan.captures[capture]));
            let cache = TileCache::new(trace, &budget);
            let cache = if side_by_side { cache.for_readers(left) } else { cache };
            if left > 0 {
                shared.insert(capture, Mutex::new(SharedTrace { trace: Some(Arc::new(cache)), left }));
            }
            if side_by_side { groups.push(Group::convoy(list)) } else { others.extend(list) }
        }
        groups.push(Group::new(others, None));
        Self { groups, traces: shared }
    }

    /// Expected work on all of them.
    pub fn weight(&self) -> u64 {
        self.groups.iter().flat_map(|group| &group.list).map(|job| job.weight).sum()
    }

    /// Computes the points of a job of a group. The trace is closed behind the last one.
    ///
    /// # Errors
    /// Those of a point; an interruption.
    pub fn run(
        &self,
        (group, job): (&Group, &Job),
        plan: &Plan<'_>,
        pool: &Pool,
        meter: &Meter<'_>,
    ) -> Result<Vec<Computed>, StudyError> {
        let closed = || StudyError::Usage { detail: "a trace was closed too early".into() };
        let slot = self.traces.get(&job.capture).ok_or_else(closed)?;
        let trace = slot.lock().unwrap_or_else(PoisonError::into_inner).trace.clone().ok_or_else(closed)?;
        let points: Vec<(&Point, Missing)> = job.points.iter().map(|(_, point, missing)| (point, *missing)).collect();
        let simulates = points.iter().any(|(point, missing)| PointTask::<TileCache>::simulates(point, *missing));
        let tree = simulates.then(|| trace.topology());
        let (scene, policy) = (plan.scene_of(&plan.captures[job.capture]), &points[0].0.policy.name);
        let member = group.convoy.as_ref().map(|convoy| convoy.join(job.number, &pool.stop));
        let computed = compute_all(&points, (&*trace, tree.as_ref()), &pool.stop, |part, whole| {
            let doing = || format!("{scene} under {policy}");
            meter.tell(Item::Point(job.points[0].0), job.weight, (part, whole), &doing);
            member.iter().for_each(|member| member.is_at(part, &pool.stop));
        })?;
        drop(member);
        drop(trace);
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        slot.left -= 1;
        if slot.left == 0 {
            slot.trace = None;
        }
        Ok(computed)
    }
}
