//! What is missing on some captures, as jobs: points that share a replay are one.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use rayreel_formats::trace::Trace;
use rayreel_replay::{Detail, PathSource};
use rayreel_study::StudyError;
use rayreel_study::point::compute::compute_all;
use rayreel_study::point::key::Point;
use rayreel_study::point::task::{Computed, Missing, PointTask};
use rayreel_study::point::tile_cache::{Room, TileCache};
use rayreel_study::pool::Pool;

use crate::ledger::Ledger;
use crate::meter::{Item, Meter, point_weight};
use crate::plan::Plan;

/// Memory for what the points of a batch decode once, bytes: all of a batch at 512x256.
const DECODED: usize = 1 << 30;

/// Jobs and the traces that they read.
pub struct Jobs {
    /// The longest first, so that none is left over at the end.
    pub list: Vec<Job>,
    traces: BTreeMap<usize, Mutex<SharedTrace>>,
}

/// Points to compute.
pub struct Job {
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

impl Jobs {
    /// What is missing on captures, of which these are the traces.
    pub fn new(plan: &Plan<'_>, ledger: &Ledger<'_>, captures: &[usize], traces: Vec<Trace>) -> Self {
        let mut list: Vec<Job> = Vec::new();
        for &capture in captures {
            let begin = list.len();
            for number in ledger.points_on(capture) {
                let (point, missing) = (ledger.point(number), ledger.missing(number));
                if !missing.any() {
                    continue;
                }
                let weight = point_weight(&plan.captures[capture], point, missing);
                // Every cycle of two machines takes two threads; what is estimated takes all of them anyway.
                let shares = |job: &&mut Job| point.detail != Detail::Full && point.shares_replay(&job.points[0].1);
                let member = (number, point.clone(), missing);
                match list[begin..].iter_mut().find(shares) {
                    Some(job) => {
                        job.points.push(member);
                        job.weight += weight;
                    }
                    None => list.push(Job { capture, points: vec![member], weight }),
                }
            }
        }
        let room = Room::new(DECODED);
        let shared = |(capture, trace): (&usize, Trace)| {
            let left = list.iter().filter(|job| job.capture == *capture).count();
            let trace = || Some(Arc::new(TileCache::new(trace, &room)));
            (left > 0).then(|| (*capture, Mutex::new(SharedTrace { trace: trace(), left })))
        };
        let traces = captures.iter().zip(traces).filter_map(shared).collect();
        list.sort_by_key(|job| (std::cmp::Reverse(job.weight), job.points[0].0));
        Self { list, traces }
    }

    /// Expected work on all of them.
    pub fn weight(&self) -> u64 {
        self.list.iter().map(|job| job.weight).sum()
    }

    /// Computes the points of a job. The trace is closed behind the last one.
    ///
    /// # Errors
    /// Those of a point; an interruption.
    pub fn run(&self, job: &Job, plan: &Plan<'_>, pool: &Pool, meter: &Meter<'_>) -> Result<Vec<Computed>, StudyError> {
        let closed = || StudyError::Usage { detail: "a trace was closed too early".into() };
        let slot = self.traces.get(&job.capture).ok_or_else(closed)?;
        let trace = slot.lock().unwrap_or_else(PoisonError::into_inner).trace.clone().ok_or_else(closed)?;
        let points: Vec<(&Point, Missing)> = job.points.iter().map(|(_, point, missing)| (point, *missing)).collect();
        let simulates = points.iter().any(|(point, missing)| PointTask::<TileCache>::simulates(point, *missing));
        let tree = simulates.then(|| trace.topology());
        let (scene, policy) = (plan.scene_of(&plan.captures[job.capture]), &points[0].0.policy.name);
        let computed = compute_all(&points, (&*trace, tree.as_ref()), &pool.stop, |part, whole| {
            let doing = || format!("{scene} under {policy}");
            meter.tell(Item::Point(job.points[0].0), job.weight, (part, whole), &doing);
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
