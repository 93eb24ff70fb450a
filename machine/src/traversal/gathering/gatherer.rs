//! A traversal unit that gathers rays: queues of rays that need the same node or triangle, and testers that take several rays of
//! a queue a cycle.
//!
//! * A ray that comes to a node or a triangle joins the queue of it, or opens one. Whoever opens a queue looks the lines up in
//!   the L1. Where no queue is free the ray waits, first come, first served.
//! * A queue can issue when its lines are here (the L1's latency after a hit) and it is full, that is has as many rays as the
//!   testers take in a cycle, or its first ray has waited `gather_wait_cycles`. In each cycle the testers of boxes take the
//!   queue of a node, and those of triangles that of a triangle: the fullest, of equals the one that was opened first. What is
//!   left of its rays waits on, and their next issue reads the data again.
//! * A ray is `inner_cycles`, `ist_cycles` or `stack_cycles` in the pipeline. Stacks are whole, and each ray has its own, so that no
//!   stack operation waits for another.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use super::queues::{Queues, TESTERS, Taken};
use crate::config::MachineConfig;
use crate::counters::Activity;
use crate::link::RayRef;
use crate::memory::{L1Cache, Memory, Port, Tags};
use crate::ti::{InputBufferCounters, Tiles, TrvCounters, TrvStats, stage_names};
use crate::time::{TiCycle, When};
use crate::traversal::cursor::{Cursor, Want};
use crate::work::layout::{Layout, Region};
use crate::work::ops::Op;

/// A unit.
#[derive(Debug)]
pub struct Gatherer {
    depth: [u64; TESTERS],
    setup_cycles: u64,
    stack_cycles: u64,
    rays: Vec<Option<Cursor>>,
    free: Vec<u16>,
    queues: Queues,
    /// Rays for which no queue is free.
    waiting: VecDeque<u16>,
    /// What rays are through with when: setup, a test, a stack operation.
    events: BinaryHeap<Reverse<(TiCycle, u64, u16)>>,
    booked: u64,
    l1: L1Cache,
    counted: TrvCounters,
    buffer: InputBufferCounters,
    activity: [Activity; TESTERS],
    /// What the testers wait for, from `accounted` on.
    gap: [Gap; TESTERS],
    accounted: TiCycle,
}

/// What testers wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Gap {
    /// There is no ray.
    Idle,
    /// No ray needs them.
    Starved,
    /// A queue has its data in sight, and waits for company.
    Company,
    /// All queues wait for lines.
    Memory,
}

impl Gatherer {
    /// A unit of a machine, its L1 at `port`.
    pub fn new(config: &MachineConfig, port: Port) -> Self {
        let ti = &config.ti;
        Self {
            depth: [ti.inner_cycles.into(), ti.ist_cycles.into()],
            setup_cycles: ti.setup_cycles.into(),
            stack_cycles: ti.stack_cycles.into(),
            rays: vec![None; ti.rays_per_trv as usize],
            free: (0..ti.rays_per_trv as u16).rev().collect(),
            queues: Queues::new(config),
            waiting: VecDeque::new(),
            events: BinaryHeap::new(),
            booked: 0,
            l1: L1Cache::new(&ti.trv_l1, config.l2.line_bytes, port),
            counted: TrvCounters::default(),
            buffer: InputBufferCounters::default(),
            activity: [Activity::default(); TESTERS],
            gap: [Gap::Idle; TESTERS],
            accounted: TiCycle::default(),
        }
    }

    /// Places that are free.
    #[inline]
    pub fn free(&self) -> usize {
        self.free.len()
    }

    fn is_empty(&self) -> bool {
        self.free.len() == self.rays.len()
    }

    /// A ray arrives.
    ///
    /// # Panics
    /// When no place is free.
    pub fn enter<T: Tiles>(&mut self, now: TiCycle, ray: RayRef, tiles: &T) {
        self.account(now);
        let place = self.free.pop().expect("a ray enters only where a place is free");
        let work = tiles.work(ray.slot);
        let mut cursor = Cursor::new(ray, now, work, &mut self.counted.leaves);
        let at = self.pass_stack(&mut cursor, now + self.setup_cycles, &work.ops);
        self.rays[usize::from(place)] = Some(cursor);
        self.book(at, place);
        self.note_gaps();
    }

    /// Stack operations that come next, from cycle `at` on; gives the cycle in which they are over.
    fn pass_stack(&mut self, cursor: &mut Cursor, mut at: TiCycle, ops: &[Op]) -> TiCycle {
        while let Want::Pop { .. } = cursor.want {
            at += self.stack_cycles;
            cursor.want.count(&mut self.counted);
            cursor.go_on(ops, &mut self.counted.leaves);
        }
        at
    }

    fn book(&mut self, at: TiCycle, place: u16) {
        self.events.push(Reverse((at, self.booked, place)));
        self.booked += 1;
    }

    /// A line arrived at cycle `now`.
    pub fn fill(&mut self, now: TiCycle, line: u64) {
        self.account(now);
        let mut waiters = self.l1.fill(line);
        while waiters != 0 {
            let id = waiters.trailing_zeros() as usize;
            waiters &= waiters - 1;
            self.queues.fill(now, id);
        }
        self.note_gaps();
    }

    /// Runs cycle `now`; rays that are through go to `done`.
    pub fn tick<T: Tiles, M: Memory>(
        &mut self,
        now: TiCycle,
        (layout, tiles, memory): (&Layout, &T, &mut M),
        done: &mut VecDeque<RayRef>,
    ) {
        self.account(now);
        while let Some(&Reverse((at, _, place))) = self.events.peek()
            && at <= now
        {
            self.events.pop();
            self.arrive(now, place, layout, done);
        }
        while let Some(&place) = self.waiting.front() {
            if !self.join(now, place, layout) {
                break;
            }
            self.waiting.pop_front();
        }
        self.queues.look_up(now, &mut self.l1, memory);
        let best = self.queues.best(now);
        for (tester, queue) in best.into_iter().enumerate() {
            if self.issue(now, (tester, queue), tiles) {
                self.activity[tester].busy += 1;
            } else {
                self.charge(tester, self.gap_of(tester), 1);
            }
        }
        self.accounted = now + 1;
        self.note_gaps();
    }

    /// A ray is through with what it did: it comes to the next node or triangle, to its stack, or leaves.
    fn arrive(&mut self, now: TiCycle, place: u16, layout: &Layout, done: &mut VecDeque<RayRef>) {
        let Some(cursor) = self.rays[usize::from(place)] else { return };
        match cursor.want {
            Want::Visit { .. } | Want::Triangle(_) => {
                self.buffer.record_writes += 1;
                if !self.waiting.is_empty() || !self.join(now, place, layout) {
                    self.waiting.push_back(place);
                }
            }
            _ => self.leave(now, place, done),
        }
    }

    fn leave(&mut self, now: TiCycle, place: u16, done: &mut VecDeque<RayRef>) {
        if let Some(cursor) = self.rays[usize::from(place)].take() {
            self.counted.rays += 1;
            self.counted.ray_cycles += now - cursor.entered;
            self.free.push(place);
            done.push_back(cursor.ray);
        }
    }

    /// A ray joins the queue of what it needs, or opens it; false where none is free.
    fn join(&mut self, now: TiCycle, place: u16, layout: &Layout) -> bool {
        let Some(cursor) = self.rays[usize::from(place)] else { return true };
        let (region, index, lines) = match cursor.want {
            Want::Visit { node, .. } => (Region::Node, node, layout.node(node)),
            Want::Triangle(triangle) => (Region::Triangle, triangle, layout.triangle(triangle)),
            _ => return true,
        };
        self.queues.join(now, place, (region, index), lines)
    }

    /// The testers take rays of a queue; whether there was one.
    fn issue<T: Tiles>(&mut self, now: TiCycle, (tester, queue): (usize, Option<usize>), tiles: &T) -> bool {
        let Some(Taken { places, late_reads }) = queue.and_then(|id| self.queues.take(id)) else { return false };
        self.buffer.late_reads += late_reads;
        self.buffer.record_reads += places.len() as u64;
        for place in places {
            self.test(now, tester, place, tiles);
        }
        true
    }

    /// A ray is tested: it will be through with that, and with the stack if that comes next.
    fn test<T: Tiles>(&mut self, now: TiCycle, tester: usize, place: u16, tiles: &T) {
        let Some(mut cursor) = self.rays[usize::from(place)] else { return };
        let ops = &tiles.work(cursor.ray.slot).ops;
        cursor.want.count(&mut self.counted);
        cursor.go_on(ops, &mut self.counted.leaves);
        let at = self.pass_stack(&mut cursor, now + self.depth[tester], ops);
        self.rays[usize::from(place)] = Some(cursor);
        self.book(at, place);
    }

    fn gap_of(&self, tester: usize) -> Gap {
        match self.queues.state(tester) {
            _ if self.is_empty() => Gap::Idle,
            (false, _) => Gap::Starved,
            (true, false) => Gap::Memory,
            (true, true) => Gap::Company,
        }
    }

    fn note_gaps(&mut self) {
        self.gap = std::array::from_fn(|tester| self.gap_of(tester));
    }

    fn charge(&mut self, tester: usize, gap: Gap, cycles: u64) {
        add_gap(&mut self.activity[tester], gap, cycles);
    }

    /// Accounts for the cycles before `now`, in which nothing has changed.
    fn account(&mut self, now: TiCycle) {
        self.activity = self.activity_before(now);
        self.accounted = self.accounted.max(now);
    }

    fn activity_before(&self, now: TiCycle) -> [Activity; TESTERS] {
        let (mut activity, cycles) = (self.activity, now.since(self.accounted));
        activity.iter_mut().zip(self.gap).for_each(|(activity, gap)| add_gap(activity, gap, cycles));
        activity
    }

    /// When something happens next; a refused lookup is tried again in the next cycle.
    pub fn next_event(&self, now: TiCycle) -> When {
        let event = When::from(self.events.peek().map(|Reverse((at, ..))| *at));
        let freed = !self.waiting.is_empty() && self.queues.has_free();
        event.min(When::only_if(freed, now + 1)).min(self.queues.next_event(now)).after(now)
    }

    /// Cycles in which boxes, and triangles, were tested.
    pub fn busy(&self) -> [u64; TESTERS] {
        self.activity.map(|activity| activity.busy)
    }

    /// Node visits and triangle tests that are done.
    pub fn work_done(&self) -> (u64, u64) {
        (self.counted.node_visits, self.counted.triangle_tests)
    }

    /// What the L1 holds.
    pub fn tags(&self) -> &Tags {
        self.l1.tags()
    }

    /// Fills the empty L1.
    pub fn warm(&mut self, tags: &Tags) {
        self.l1.warm(tags);
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.l1.invalidate(line);
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> TrvStats {
        let stages = stage_names(crate::config::Pipeline::Gathering);
        TrvStats {
            stages: stages.iter().copied().zip(self.activity_before(end)).collect(),
            events: self.counted,
            buffer: self.buffer,
            l1: *self.l1.counters(),
        }
    }
}

fn add_gap(activity: &mut Activity, gap: Gap, cycles: u64) {
    *match gap {
        Gap::Idle => &mut activity.idle,
        Gap::Starved => &mut activity.starved,
        Gap::Company => &mut activity.blocked,
        Gap::Memory => &mut activity.memory,
    } += cycles;
}
