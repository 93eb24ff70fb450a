//! Traces of captures: from the cache, or made.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use rayreel_formats::trace::Trace;
use rayreel_study::pool::Pool;
use rayreel_tracer::accel::{self, Built};

use crate::error::{PaperError, Result};
use crate::meter::{Item, Meter, capture_weight};
use crate::plan::Plan;
use crate::traces;

/// Makes traces, on whichever thread asks for them.
pub struct Maker<'a> {
    plan: &'a Plan<'a>,
    pool: &'a Pool,
    /// How far the experiment is.
    pub meter: Meter<'a>,
    /// Whether nobody waits for traces any more.
    pub abandoned: AtomicBool,
    /// The BVHs of the scenes, or why there is none.
    built: Vec<OnceLock<Result<Built, String>>>,
}

impl<'a> Maker<'a> {
    /// Nothing is made yet.
    pub fn new(plan: &'a Plan<'a>, pool: &'a Pool, meter: Meter<'a>) -> Self {
        let built = plan.stages.iter().map(|_| OnceLock::new()).collect();
        Self { plan, pool, meter, abandoned: AtomicBool::new(false), built }
    }

    /// The BVH of a scene, built once.
    pub fn built(&self, scene: usize) -> Result<&Built> {
        let stage = &self.plan.stages[scene].scene;
        let built = self.built[scene].get_or_init(|| accel::build(stage).map_err(|e| e.to_string()));
        built.as_ref().map_err(|detail| PaperError::Scene { scene: stage.name.clone(), detail: detail.clone() })
    }

    /// The traces of captures, one after the other: each takes all cores.
    pub fn traces(&self, captures: &[usize]) -> Result<Vec<Trace>> {
        captures.iter().map(|capture| self.trace(*capture)).collect()
    }

    fn trace(&self, index: usize) -> Result<Trace> {
        self.check_stop()?;
        let (capture, item) = (&self.plan.captures[index], Item::Capture(index));
        let weight = capture_weight(capture);
        let path = capture.path.as_deref().ok_or(PaperError::Fault { detail: "a live capture has no file" })?;
        let trace = match traces::cached(path, &capture.meta) {
            Some(trace) => trace,
            None => {
                let (stage, n) = (&self.plan.stages[capture.scene], capture.meta.samples);
                let is_stopped = || self.pool.stop.is_requested() || self.abandoned.load(Ordering::Relaxed);
                let made = (path, &capture.meta);
                traces::make(&stage.scene, self.built(capture.scene)?, made, &is_stopped, |part, of| {
                    self.meter.tell(item, weight, (part, of), &|| format!("capture {} {n}x{n}", stage.name));
                })?
            }
        };
        self.meter.close(item, weight);
        self.check_stop()?;
        Ok(trace)
    }

    /// Ends the experiment if that was asked for.
    pub fn check_stop(&self) -> Result<()> {
        if self.pool.stop.is_requested() { Err(PaperError::interrupted()) } else { Ok(()) }
    }
}
