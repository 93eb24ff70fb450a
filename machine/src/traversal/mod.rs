//! What takes rays through the tree in a core: a T&I unit of one kind or another, or processors.

mod buffer;
mod cursor;
mod gathering;
mod threads;

pub(crate) use threads::CodeLayout;
pub use threads::{ProcessorCounters, ProcessorStats};

use std::collections::VecDeque;

use gathering::GatherUnit;
use threads::ThreadUnit;

use crate::component::{Component, Tick};
use crate::config::{MachineConfig, Pipeline};
use crate::counters::StageBusy;
use crate::link::{Job, RayMessage, RayRef, RayUnit};
use crate::memory::{Memory, Port, Tags};
use crate::ti::{TiContext, TiStats, TiUnit, Tiles};
use crate::time::{TiCycle, When};

/// What takes rays through the tree.
#[derive(Debug)]
pub enum TracingUnit {
    /// A fixed-function unit.
    Fixed(Box<TiUnit>),
    /// A unit that gathers rays (`ti.pipeline = "gathering"`).
    Gathering(Box<GatherUnit>),
    /// Threads (`ti.pipeline = "software"`).
    Software(Box<ThreadUnit>),
}

macro_rules! either {
    ($unit:expr, $name:ident => $what:expr) => {
        match $unit {
            TracingUnit::Fixed($name) => $what,
            TracingUnit::Gathering($name) => $what,
            TracingUnit::Software($name) => $what,
        }
    };
}

impl TracingUnit {
    /// The unit of a core; its caches take the ports from `first_port` on, [`TracingUnit::ports`] of them.
    pub fn new(config: &MachineConfig, first_port: Port) -> Self {
        match config.ti.pipeline {
            Pipeline::Gathering => Self::Gathering(Box::new(GatherUnit::new(config, first_port))),
            Pipeline::Software => Self::Software(Box::new(ThreadUnit::new(config, first_port))),
            _ => Self::Fixed(Box::new(TiUnit::new(config, first_port))),
        }
    }

    /// Caches, and so ports, of a unit.
    pub fn ports(config: &MachineConfig) -> u16 {
        match config.ti.pipeline {
            Pipeline::Gathering => GatherUnit::ports(config),
            Pipeline::Software => ThreadUnit::ports(config),
            _ => TiUnit::ports(config),
        }
    }

    /// A line arrived at `port` in cycle `now`.
    pub fn fill(&mut self, now: TiCycle, port: Port, line: u64) {
        either!(self, unit => unit.fill(now, port, line));
    }

    /// Fills the empty L1s: those of the traversal units or processors, and those of the intersection units.
    pub(crate) fn warm(&mut self, trv: &[Tags], ist: &[Tags]) {
        match self {
            Self::Fixed(unit) => unit.warm(trv, ist),
            Self::Gathering(unit) => unit.warm(trv),
            Self::Software(unit) => unit.warm(trv),
        }
    }

    /// What the L1s hold: those of the traversal units or processors, and those of the intersection units.
    pub(crate) fn tags(&self) -> [Vec<Tags>; 2] {
        match self {
            Self::Fixed(unit) => unit.tags(),
            Self::Gathering(unit) => [unit.tags(), Vec::new()],
            Self::Software(unit) => [unit.tags(), Vec::new()],
        }
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        either!(self, unit => unit.invalidate(line));
    }

    /// Busy cycles of each issue stage so far, for a timeline.
    pub fn busy(&self, see: impl FnMut(StageBusy)) {
        either!(self, unit => unit.busy(see));
    }

    /// What is inside, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        either!(self, unit => unit.describe())
    }

    /// The work that is done: node visits, triangle tests and rays, weighted.
    pub(crate) fn done(&self) -> f64 {
        either!(self, unit => unit.done())
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> TiStats {
        either!(self, unit => unit.report(end))
    }

    /// The same of what only processors count.
    pub fn processor_report(&self, end: TiCycle) -> Vec<ProcessorStats> {
        match self {
            Self::Fixed(_) | Self::Gathering(_) => Vec::new(),
            Self::Software(unit) => unit.processor_report(end),
        }
    }
}

impl Component for TracingUnit {
    type Report = TiStats;

    #[inline]
    fn next_event(&self, now: TiCycle) -> When {
        either!(self, unit => unit.next_event(now))
    }

    fn finish(&mut self, end: TiCycle) -> TiStats {
        either!(self, unit => unit.finish(end))
    }
}

impl<T: Tiles, M: Memory> Tick<TiContext<'_, T, M>> for TracingUnit {
    #[inline]
    fn tick(&mut self, now: TiCycle, context: TiContext<'_, T, M>) {
        either!(self, unit => unit.tick(now, context));
    }
}

impl RayUnit for TracingUnit {
    #[inline]
    fn has_room(&self) -> bool {
        either!(self, unit => unit.has_room())
    }

    #[inline]
    fn push(&mut self, now: TiCycle, ray: RayRef) {
        either!(self, unit => unit.push(now, ray));
    }

    #[inline]
    fn results(&mut self) -> &mut VecDeque<RayMessage> {
        either!(self, unit => unit.results())
    }

    #[inline]
    fn rays_inside(&self) -> usize {
        either!(self, unit => unit.rays_inside())
    }

    #[inline]
    fn job_room(&self) -> usize {
        either!(self, unit => unit.job_room())
    }

    fn push_job(&mut self, now: TiCycle, job: Job) {
        either!(self, unit => unit.push_job(now, job));
    }

    fn finished_job(&mut self) -> Option<u32> {
        either!(self, unit => unit.finished_job())
    }

    #[inline]
    fn has_finished_jobs(&self) -> bool {
        either!(self, unit => unit.has_finished_jobs())
    }
}
