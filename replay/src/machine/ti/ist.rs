//! An intersection unit, and the crossbar by which leaf tasks reach it.
//!
//! A task is a ray in a leaf: its triangles are fetched and issued one after the other, one triangle a cycle at best over all
//! tasks; when the last one leaves the pipeline, the result goes back to the traversal unit. A traversal unit reserves an entry
//! before it issues the leaf operation, so a task that arrives always has a place.

use std::collections::VecDeque;

use super::Context;
use super::account::{Account, Slot};
use super::front::{Front, FrontCounters};
use super::pipe::Pipe;
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
}

impl Tasks {
    /// The crossbar of a core.
    pub fn new(config: &MachineConfig) -> Self {
        let ist = config.ti.ist as usize;
        Self {
            latency: config.ti.crossbar_cycles.into(),
            free: vec![config.ti.ist_entries; ist],
            inbox: vec![VecDeque::with_capacity(config.ti.ist_entries as usize); ist],
        }
    }

    /// Reserves an entry of the unit that has most of them free, the first of equals.
    #[inline]
    pub fn reserve(&mut self) -> Option<u8> {
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

    /// Whether no unit has a free entry.
    #[inline]
    pub fn all_full(&self) -> bool {
        self.free.iter().all(|&free| free == 0)
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
    pipe: Pipe<(u8, bool, bool)>,
    /// The next triangles of tasks that issued one in the last cycle.
    next: Option<u8>,
    between: Slot,
    activity: Account,
    ticked: Option<Cycle>,
    events: IstCounters,
}

impl Ist {
    /// Unit `index` of a core, its L1 at `port`.
    pub fn new(config: &MachineConfig, index: u8, port: Port) -> Self {
        let entries = config.ti.ist_entries;
        let none = LeafTask { trv: 0, slot: 0, triangle: 0, tests: 0 };
        Self {
            index,
            crossbar: config.ti.crossbar_cycles.into(),
            tasks: vec![none; entries as usize],
            free: (0..entries as u8).rev().collect(),
            front: Front::new(
                &config.ti,
                (&config.ti.ist_l1, config.ti.ist_lines_per_cycle),
                config.l2.line_bytes,
                port,
                entries,
            ),
            pipe: Pipe::new(config.ti.ist_cycles),
            next: None,
            between: Slot::Idle,
            activity: Account::default(),
            ticked: None,
            events: IstCounters::default(),
        }
    }

    /// A line arrived.
    pub fn fill(&mut self, line: u64) {
        self.front.fill(line);
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
        self.account_gap(now);
        while let Some((slot, last, bypass)) = self.pipe.pop(now) {
            if bypass {
                self.front.push_again(slot);
            } else if last {
                let task = self.tasks[slot as usize];
                results.push(LeafResult { at: now + self.crossbar, trv: task.trv, slot: task.slot });
                self.free.push(slot);
                crossbar.release(self.index);
            }
        }
        if let Some(slot) = self.next.take() {
            self.front.push(slot, context.layout.triangle(self.tasks[slot as usize].triangle), Region::Triangle);
        }
        if let Some(task) = crossbar.accept(now, self.index) {
            let slot = self.free.pop().expect("every task has a reserved entry");
            self.tasks[slot as usize] = task;
            self.events.tasks += 1;
            self.front.push(slot, context.layout.triangle(task.triangle), Region::Triangle);
        }
        self.front.look_up(now, memory);
        let issued = self.issue(now);
        self.between = Slot::of(self.front.waiting(), self.free.len() < self.tasks.len());
        self.activity.add(issued.unwrap_or(self.between), 1);
        self.ticked = Some(now);
    }

    /// The next cycle at which something happens here, judged at the end of cycle `now`.
    #[inline]
    pub fn next_event(&self, now: Cycle, crossbar: &Tasks) -> Option<Cycle> {
        if self.next.is_some() {
            return Some(now + 1);
        }
        let events = [self.pipe.next_event(), crossbar.next_arrival(self.index as usize), self.front.next_event(now)];
        events.into_iter().flatten().min().map(|at| at.max(now + 1))
    }

    /// Closes the accounts of a run of `cycles` cycles.
    pub fn finish(&mut self, cycles: Cycle) -> IstStats {
        self.account_gap(cycles);
        IstStats {
            activity: self.activity.activity(),
            events: self.events,
            front: self.front.counters,
            l1: *self.front.l1().counters(),
        }
    }

    #[inline]
    fn issue(&mut self, now: Cycle) -> Option<Slot> {
        let issue = self.front.issue(now)?;
        if issue.bypass {
            self.pipe.push(now, (issue.op, false, true));
            self.events.bypasses += 1;
            return Some(Slot::Bypass);
        }
        let task = &mut self.tasks[issue.op as usize];
        task.tests -= 1;
        task.triangle += 1;
        let last = task.tests == 0;
        if !last {
            self.next = Some(issue.op);
        }
        self.pipe.push(now, (issue.op, last, false));
        self.events.triangle_tests += 1;
        Some(Slot::Busy)
    }

    #[inline]
    fn account_gap(&mut self, now: Cycle) {
        let gap = now - self.ticked.map_or(0, |t| t + 1);
        if gap > 0 {
            self.activity.add(self.between, gap);
        }
    }
}
