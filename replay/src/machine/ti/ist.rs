//! An intersection unit, and the crossbar by which leaf tasks reach it.
//!
//! A task is a ray in a leaf: its triangles are fetched and issued one after the other, one triangle a cycle at best over all
//! tasks; when the last one leaves the pipeline, the result goes back to the traversal unit. A traversal unit reserves an entry
//! before it issues the leaf operation, so a task that arrives always has a place; a unit accepts one task a cycle. Leaf
//! operations without an entry stand in one line for all traversal units, and an entry that becomes free goes to the first of
//! them in the cycle after.

use std::collections::VecDeque;

use super::Context;
use super::front::{Front, FrontCounters};
use super::pipe::Pipe;
use super::stage::{Candidate, Idle, Stage};
use crate::machine::config::MachineConfig;
use crate::machine::counters::{Activity, counters};
use crate::machine::memory::l1::CacheCounters;
use crate::machine::memory::{Cycle, Memory, Port};
use crate::machine::work::layout::Region;

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
    pub front: FrontCounters,
    /// L1.
    pub l1: CacheCounters,
}

/// A ray in a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafTask {
    /// Traversal unit.
    pub trv: u8,
    /// The ray's place there.
    pub slot: u8,
    /// First triangle.
    pub triangle: u32,
    /// Number of triangles to test.
    pub tests: u8,
}

/// The crossbar towards the intersection units: free entries, and tasks on their way.
#[derive(Debug)]
pub struct Tasks {
    latency: Cycle,
    free: Vec<u32>,
    inbox: Vec<VecDeque<(Cycle, LeafTask)>>,
    /// Leaf operations without an entry: traversal unit, place, arrival.
    line: VecDeque<(u8, u8, Cycle)>,
}

impl Tasks {
    /// The crossbar of a core.
    pub fn new(config: &MachineConfig) -> Self {
        let ist = config.ti.ist as usize;
        Self {
            latency: config.ti.crossbar_cycles.into(),
            free: vec![config.ti.ist_entries; ist],
            inbox: vec![VecDeque::with_capacity(config.ti.ist_entries as usize); ist],
            line: VecDeque::new(),
        }
    }

    /// An entry for the leaf operation of a ray that arrived at cycle `now`, or a place in the line.
    #[inline]
    pub fn reserve_or_wait(&mut self, trv: u8, slot: u8, now: Cycle) -> Option<u8> {
        let ist = if self.line.is_empty() { self.reserve() } else { None };
        if ist.is_none() {
            self.line.push_back((trv, slot, now));
        }
        ist
    }

    /// The first of the line with its entry, if there is one: traversal unit, place, arrival, intersection unit.
    #[inline]
    pub fn grant(&mut self) -> Option<(u8, u8, Cycle, u8)> {
        let &(trv, slot, arrived) = self.line.front()?;
        let ist = self.reserve()?;
        self.line.pop_front();
        Some((trv, slot, arrived, ist))
    }

    /// Reserves an entry of the unit that has most of them free, the first of equals.
    #[inline]
    fn reserve(&mut self) -> Option<u8> {
        let mut best = 0;
        for ist in 1..self.free.len() {
            if self.free[ist] > self.free[best] {
                best = ist;
            }
        }
        let free = self.free.get_mut(best).filter(|free| **free > 0)?;
        *free -= 1;
        Some(best as u8)
    }

    /// Gives an entry back.
    #[inline]
    pub fn release(&mut self, ist: u8) {
        self.free[ist as usize] += 1;
    }

    /// Sends a task to a reserved entry.
    #[inline]
    pub fn send(&mut self, now: Cycle, ist: u8, task: LeafTask) {
        self.inbox[ist as usize].push_back((now + self.latency, task));
    }

    /// When the next task arrives at a unit.
    #[inline]
    pub fn next_arrival(&self, ist: usize) -> Option<Cycle> {
        self.inbox[ist].front().map(|t| t.0)
    }

    /// The next task that has arrived; a unit accepts one a cycle.
    #[inline]
    fn accept(&mut self, now: Cycle, ist: u8) -> Option<LeafTask> {
        let inbox = &mut self.inbox[ist as usize];
        if inbox.front()?.0 > now {
            return None;
        }
        inbox.pop_front().map(|t| t.1)
    }
}

/// A finished task on its way back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafResult {
    /// When it arrives.
    pub at: Cycle,
    /// Traversal unit.
    pub trv: u8,
    /// The ray's place there.
    pub slot: u8,
}

/// See the module.
#[derive(Debug)]
pub struct Ist {
    index: u8,
    crossbar: Cycle,
    tasks: Vec<LeafTask>,
    free: Vec<u8>,
    front: Front,
    idle: Idle,
    stage: Stage,
    pipe: Pipe<(u8, Passed)>,
    /// Tasks whose next triangle comes to the input buffer, and when: the cycle after the one before issued.
    next: VecDeque<(Cycle, u8)>,
    events: IstCounters,
}

/// What left the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Passed {
    Bypass,
    Triangle,
    LastTriangle,
}

impl Ist {
    /// Unit `index` of a core, its L1 at `port`.
    pub fn new(config: &MachineConfig, index: u8, port: Port) -> Self {
        let entries = config.ti.ist_entries;
        let none = LeafTask { trv: 0, slot: 0, triangle: 0, tests: 0 };
        let l1 = (&config.ti.ist_l1, config.ti.ist_lines_per_cycle);
        Self {
            index,
            crossbar: config.ti.crossbar_cycles.into(),
            tasks: vec![none; entries as usize],
            free: (0..entries as u8).rev().collect(),
            front: Front::new(&config.ti, l1, config.l2.line_bytes, port, entries),
            idle: Idle::new(),
            stage: Stage::default(),
            pipe: Pipe::new(config.ti.ist_cycles),
            next: VecDeque::new(),
            events: IstCounters::default(),
        }
    }

    /// Cycles in which the unit was or will be busy.
    pub fn busy(&self) -> Cycle {
        self.stage.busy()
    }

    /// A line arrived at cycle `now`.
    pub fn fill(&mut self, now: Cycle, line: u64) {
        let Self { front, stage, pipe, tasks, next, events, idle, .. } = self;
        front.fill(now, line, |slot, op| issue(stage, pipe, &mut tasks[slot as usize], next, events, idle, (slot, op)));
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.front.l1_mut().invalidate(line);
    }

    /// One cycle. Results are appended to `results`.
    pub fn tick<M: Memory, T>(
        &mut self,
        now: Cycle,
        context: &Context<'_, T>,
        crossbar: &mut Tasks,
        memory: &mut M,
        results: &mut Vec<LeafResult>,
    ) {
        while let Some((slot, passed)) = self.pipe.pop(now) {
            match passed {
                Passed::Bypass => {
                    let op = self.front.push_again(now, slot, memory);
                    self.issue(slot, op);
                }
                Passed::Triangle => {}
                Passed::LastTriangle => {
                    let task = self.tasks[slot as usize];
                    results.push(LeafResult { at: now + self.crossbar, trv: task.trv, slot: task.slot });
                    self.free.push(slot);
                    if self.free.len() == self.tasks.len() {
                        self.idle.begin(now);
                    }
                    crossbar.release(self.index);
                }
            }
        }
        while self.next.front().is_some_and(|n| n.0 <= now) {
            let Some((_, slot)) = self.next.pop_front() else { break };
            self.arrive(now, slot, context, memory);
        }
        if let Some(task) = crossbar.accept(now, self.index) {
            if self.free.len() == self.tasks.len() {
                self.idle.end(now);
            }
            let slot = self.free.pop().expect("every task has a reserved entry");
            self.tasks[slot as usize] = task;
            self.events.tasks += 1;
            self.arrive(now, slot, context, memory);
        }
        if let Some((slot, op)) = self.front.look_up(now, memory) {
            self.issue(slot, Some(op));
        }
    }

    /// The next cycle after `now` at which something happens here; never, if there is none.
    #[inline]
    pub fn next_event(&self, now: Cycle, crossbar: &Tasks) -> Cycle {
        let next = self.next.front().map_or(Cycle::MAX, |n| n.0);
        let task = crossbar.next_arrival(self.index as usize).map_or(Cycle::MAX, |at| at.max(now + 1));
        self.pipe.next_event().min(next).min(task).min(self.front.next_event().unwrap_or(Cycle::MAX))
    }

    /// Closes the accounts of a run of `cycles` cycles.
    pub fn finish(&mut self, cycles: Cycle) -> IstStats {
        IstStats {
            activity: self.stage.finish(cycles, &self.idle),
            events: self.events,
            front: self.front.counters,
            l1: *self.front.l1().counters(),
        }
    }

    /// The next triangle of a task comes to the input buffer.
    fn arrive<M: Memory, T>(&mut self, now: Cycle, slot: u8, context: &Context<'_, T>, memory: &mut M) {
        let lines = context.layout.triangle(self.tasks[slot as usize].triangle);
        let op = self.front.push(now, slot, lines, Region::Triangle, memory);
        self.issue(slot, op);
    }

    #[inline]
    fn issue(&mut self, slot: u8, op: Option<Candidate>) {
        let Some(op) = op else { return };
        let Self { stage, pipe, tasks, next, events, idle, .. } = self;
        issue(stage, pipe, &mut tasks[slot as usize], next, events, idle, (slot, op));
    }
}

/// Issues a triangle into the pipeline.
fn issue(
    stage: &mut Stage,
    pipe: &mut Pipe<(u8, Passed)>,
    task: &mut LeafTask,
    next: &mut VecDeque<(Cycle, u8)>,
    events: &mut IstCounters,
    idle: &Idle,
    (slot, op): (u8, Candidate),
) {
    let at = stage.issue(op, idle);
    if op.bypass {
        pipe.push(at, (slot, Passed::Bypass));
        events.bypasses += 1;
        return;
    }
    task.tests -= 1;
    task.triangle += 1;
    events.triangle_tests += 1;
    if task.tests == 0 {
        pipe.push(at, (slot, Passed::LastTriangle));
    } else {
        pipe.push(at, (slot, Passed::Triangle));
        next.push_back((at + 1, slot));
    }
}
