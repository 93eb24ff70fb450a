//! An intersection unit, and the crossbar by which leaf tasks reach it.
//!
//! A task is a ray in a leaf: its triangles are fetched and issued one after the other, one triangle a cycle at best over all
//! tasks; when the last one leaves the pipeline, the result goes back to the traversal unit. A traversal unit reserves an entry
//! before it issues the leaf operation, so a task that arrives always has a place; a unit accepts one task a cycle. Leaf
//! operations without an entry stand in one line for all traversal units, and an entry that becomes free goes to the first of
//! them in the cycle after.

use std::collections::VecDeque;

use super::Tiles;
use super::front::{Front, FrontCounters, Outcome};
use super::stage::{Candidate, Idle, Stage};
use super::trv::Tick;
use super::wheel::{Event, Kind, Wheel};
use crate::config::MachineConfig;
use crate::counters::{Activity, counters};
use crate::memory::l1::CacheCounters;
use crate::memory::{Cycle, Memory, Port};
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
    /// Tasks on their way, and first cycle in which each unit can accept one.
    inbox: Vec<VecDeque<LeafTask>>,
    accepts: Vec<Cycle>,
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
            accepts: vec![0; ist],
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
    pub fn send(&mut self, now: Cycle, ist: u8, task: LeafTask, wheel: &mut Wheel) {
        let accepts = &mut self.accepts[ist as usize];
        let at = (now + self.latency).max(*accepts);
        *accepts = at + 1;
        self.inbox[ist as usize].push_back(task);
        wheel.push(at, Event::new(Kind::Task, ist, 0));
    }
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
    depth: Cycle,
    events: IstCounters,
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
            depth: config.ti.ist_cycles.into(),
            events: IstCounters::default(),
        }
    }

    /// Cycles in which the unit was or will be busy.
    pub fn busy(&self) -> Cycle {
        self.stage.busy()
    }

    /// A line arrived at cycle `now`.
    pub fn fill(&mut self, now: Cycle, line: u64, wheel: &mut Wheel) {
        let mut waiters = self.front.fill(line);
        while waiters != 0 {
            let slot = waiters.trailing_zeros() as u8;
            waiters &= waiters - 1;
            if let Some(op) = self.front.filled(now, slot, line) {
                self.issue(slot, op, wheel);
            }
        }
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.front.l1_mut().invalidate(line);
    }

    /// A triangle left the pipeline without work.
    pub(super) fn again<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        let outcome = self.front.push_again(tick.now, slot, tick.memory);
        self.follow(slot, outcome, tick);
    }

    /// A refused lookup is tried again; `event` is booked anew while one is held up.
    pub(super) fn look_up_again<M: Memory, T: Tiles>(&mut self, event: Event, tick: &mut Tick<'_, M, T>) {
        if let Some((slot, outcome)) = self.front.turn_again(tick.now, tick.memory) {
            self.follow(slot, outcome, tick);
        }
        if self.front.is_held_up() {
            tick.wheel.push(tick.now + 1, event);
        }
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

    /// The next task comes.
    pub(super) fn accept<M: Memory, T: Tiles>(&mut self, tick: &mut Tick<'_, M, T>) {
        let Some(task) = tick.tasks.inbox[self.index as usize].pop_front() else { return };
        if self.free.len() == self.tasks.len() {
            self.idle.end(tick.now);
        }
        let slot = self.free.pop().expect("every task has a reserved entry");
        self.tasks[slot as usize] = task;
        self.events.tasks += 1;
        self.arrive(slot, tick);
    }

    /// The last triangle of a task left the pipeline.
    pub(super) fn finished<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        let task = self.tasks[slot as usize];
        tick.wheel.push(tick.now + self.crossbar, Event::new(Kind::Returned, task.trv, task.slot));
        self.free.push(slot);
        if self.free.len() == self.tasks.len() {
            self.idle.begin(tick.now);
        }
        tick.tasks.release(self.index);
    }

    /// The next triangle of a task comes to the input buffer.
    #[inline]
    pub(super) fn arrive<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        let lines = tick.context.layout.triangle(self.tasks[slot as usize].triangle);
        let outcome = self.front.push(tick.now, slot, lines, Region::Triangle, tick.memory);
        self.follow(slot, outcome, tick);
    }

    /// What an arrival or a lookup leads to.
    #[inline]
    fn follow<M: Memory, T: Tiles>(&mut self, slot: u8, outcome: Outcome, tick: &mut Tick<'_, M, T>) {
        let event = |kind| Event::new(kind, self.index, slot);
        match outcome {
            Outcome::Ready(op) => self.issue(slot, op, tick.wheel),
            Outcome::HeldUp => tick.wheel.push(tick.now + 1, event(Kind::TriangleLookUpAgain)),
            Outcome::Waits => {}
        }
    }

    /// Issues a triangle that has its data in sight.
    #[inline]
    fn issue(&mut self, slot: u8, op: Candidate, wheel: &mut Wheel) {
        let at = self.stage.issue(op, &self.idle);
        let mut push = |at, kind| wheel.push(at, Event::new(kind, self.index, slot));
        if op.bypass {
            self.events.bypasses += 1;
            return push(at + self.depth, Kind::TriangleBypass);
        }
        let task = &mut self.tasks[slot as usize];
        task.tests -= 1;
        task.triangle += 1;
        self.events.triangle_tests += 1;
        if task.tests == 0 {
            push(at + self.depth, Kind::LastTriangle);
        } else {
            push(at + 1, Kind::NextTriangle);
        }
    }
}
