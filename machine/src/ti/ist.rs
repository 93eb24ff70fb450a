//! An intersection unit.
//!
//! A task is a ray in a leaf: its triangles are fetched and issued one after the other, one triangle a cycle at best over all
//! tasks; when the last one leaves the pipeline, the result goes back to the traversal unit.

use super::context::EventContext;
use super::crossbar::LeafTask;
use super::fetch_port::FetchPort;
use super::input_buffer::{InputBuffer, InputBufferCounters};
use super::stage::{Candidate, Idle, Stage};
use super::wheel::{Event, EventKind, Wheel};
use crate::config::MachineConfig;
use crate::counters::{Activity, counters};
use crate::memory::{CacheCounters, Memory, Port};
use crate::time::TiCycle;
use crate::work::layout::Region;

counters! {
    /// What an intersection unit did.
    pub struct IstCounters {
        tasks: "events", "leaf tasks";
        triangle_tests: "events", "triangles tested";
        bypasses: "events", "operations that passed the pipeline without work";
    }
}

/// What a unit reports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IstStats {
    /// What the issue stage did in every cycle.
    pub activity: Activity,
    /// Events.
    pub events: IstCounters,
    /// Input buffer.
    pub buffer: InputBufferCounters,
    /// L1.
    pub l1: CacheCounters,
}

/// An intersection unit.
#[derive(Debug)]
pub struct Ist {
    index: u8,
    crossbar_cycles: u64,
    tasks: Vec<LeafTask>,
    free: Vec<u8>,
    pub(super) port: FetchPort,
    idle: Idle,
    stage: Stage,
    depth_cycles: u64,
    events: IstCounters,
}

impl Ist {
    /// Unit `index` of a core, its L1 at `port`.
    pub fn new(config: &MachineConfig, index: u8, port: Port) -> Self {
        let entries = config.ti.ist_entries;
        let l1 = (&config.ti.ist_l1, config.ti.ist_lines_per_cycle);
        let buffer =
            InputBuffer::new((&config.ti, config.ti.ist_miss_handling), l1, config.l2.line_bytes, port, entries);
        Self {
            index,
            crossbar_cycles: config.ti.crossbar_cycles.into(),
            tasks: vec![LeafTask::default(); entries as usize],
            free: (0..entries as u8).rev().collect(),
            port: FetchPort::new(buffer, index, EventKind::RetryTriangleLookup),
            idle: Idle::new(),
            stage: Stage::default(),
            depth_cycles: config.ti.ist_cycles.into(),
            events: IstCounters::default(),
        }
    }

    /// Cycles in which the unit was or will be busy.
    pub fn busy(&self) -> u64 {
        self.stage.busy()
    }

    /// A line arrived at cycle `now`.
    pub fn fill(&mut self, now: TiCycle, line: u64, wheel: &mut Wheel) {
        let mut fill = self.port.fill(now, line);
        while let Some((slot, op)) = self.port.next_filled(&mut fill) {
            self.issue(slot, op, wheel);
        }
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.port.invalidate(line);
    }

    /// Triangle tests that are done.
    pub fn tests(&self) -> u64 {
        self.events.triangle_tests
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> IstStats {
        IstStats {
            activity: self.stage.report(end, &self.idle),
            events: self.events,
            buffer: self.port.counters(),
            l1: self.port.l1_counters(),
        }
    }

    /// The task in `slot`: whose it is, and its next triangle.
    pub(super) fn task(&self, slot: u8) -> LeafTask {
        self.tasks[slot as usize]
    }

    /// The next task comes, to the slot that is given.
    pub(super) fn accept<T, M: Memory>(&mut self, context: &mut EventContext<'_, T, M>) -> Option<u8> {
        let task = context.crossbar.accept(self.index)?;
        if self.free.len() == self.tasks.len() {
            self.idle.end(context.now);
        }
        let slot = self.free.pop().expect("every task has a reserved entry");
        self.tasks[slot as usize] = task;
        self.events.tasks += 1;
        Some(slot)
    }

    /// The next triangle of a task comes to the input buffer.
    #[inline]
    pub(super) fn fetch<T, M: Memory>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) {
        let lines = context.layout.triangle(self.tasks[slot as usize].triangle);
        if let Some(op) = self.port.fetch(slot, lines, Region::Triangle, context) {
            self.issue(slot, op, context.wheel);
        }
    }

    /// A triangle left the pipeline without work, because its data had missed.
    #[inline]
    pub(super) fn retry<T, M: Memory>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) {
        if let Some(op) = self.port.fetch_again(slot, context) {
            self.issue(slot, op, context.wheel);
        }
    }

    /// A refused lookup is tried again; `event` is booked anew while one is held up.
    pub(super) fn retry_lookup<T, M: Memory>(&mut self, event: Event, context: &mut EventContext<'_, T, M>) {
        if let Some((slot, op)) = self.port.retry_lookup(context) {
            self.issue(slot, op, context.wheel);
        }
        self.port.book_retry(event, context);
    }

    /// The last triangle of a task left the pipeline.
    pub(super) fn task_done<T, M>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) {
        let task = self.tasks[slot as usize];
        let returned = Event::new(EventKind::Returned, task.trv, task.slot);
        context.wheel.push(context.now + self.crossbar_cycles, returned);
        self.free.push(slot);
        if self.free.len() == self.tasks.len() {
            self.idle.begin(context.now);
        }
        context.crossbar.release(self.index);
    }

    /// Issues a triangle that has its data in sight.
    #[inline]
    fn issue(&mut self, slot: u8, op: Candidate, wheel: &mut Wheel) {
        let at = self.stage.issue(op, &self.idle);
        let mut push = |at, kind| wheel.push(at, Event::new(kind, self.index, slot));
        if op.bypass {
            self.events.bypasses += 1;
            return push(at + self.depth_cycles, EventKind::TriangleBypass);
        }
        let task = &mut self.tasks[slot as usize];
        task.tests -= 1;
        task.triangle += 1;
        self.events.triangle_tests += 1;
        if task.tests == 0 {
            push(at + self.depth_cycles, EventKind::LastTriangle);
        } else {
            push(at + 1, EventKind::NextTriangle);
        }
    }
}
