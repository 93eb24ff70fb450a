//! A traversal unit: rays that walk the tree through inner-node, leaf and stack pipelines.
//!
//! What leaves a pipeline in a cycle is routed in that cycle: to the lookup of a node, to the leaf stage, to the stack stage.
//! Each stage issues at most one operation a cycle (`parallel`), or all stages together one (`single`, `unified`), first
//! ready, first issued. A leaf operation issues only when it has an entry of an intersection unit, so pipelines never stall
//! inside; those that wait for one stand in one queue for all traversal units of the core.

use super::context::{EventContext, Tiles};
use super::crossbar::{LeafGrant, LeafRequest, LeafTask};
use super::fetch_port::FetchPort;
use super::input_buffer::InputBuffer;
use super::ray::{Popped, RaySlot, Trail};
use super::stage::{Candidate, Idle, Stage, Wait};
use super::trv_stats::{TrvCounters, TrvStats, stage_names};
use super::wheel::{Event, EventKind, Wheel};
use crate::config::{MachineConfig, Pipeline};
use crate::link::RayRef;
use crate::memory::{Memory, Port};
use crate::time::TiCycle;
use crate::work::layout::{Lines, Region};
use crate::work::ops::OpKind;

/// Issue stages of the parallel pipeline; the single one has only the first.
const INNER: usize = 0;
const LEAF: usize = 1;
const STACK: usize = 2;

/// What a ray does next.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// Its next operation.
    Next,
    /// A visit of this node, on a walk down again.
    Visit(u32),
    /// Its hit is known.
    Leave,
    /// Nothing yet: it is somewhere else.
    Waits,
}

/// A traversal unit.
#[derive(Debug)]
pub struct Trv {
    index: u8,
    pipeline: Pipeline,
    short: u8,
    passes: u8,
    boxes_per_pass: u8,
    rays: Vec<RaySlot>,
    /// Of each ray the way that it walks down again.
    trails: Vec<Trail>,
    free: Vec<u8>,
    entered: Vec<TiCycle>,
    idle: Idle,
    pub(super) port: FetchPort,
    stages: [Stage; 3],
    /// Depths of the pipelines.
    setup_cycles: u64,
    inner_cycles: u64,
    leaf_cycles: u64,
    stack_cycles: u64,
    events: TrvCounters,
}

impl Trv {
    /// Unit `index` of a core, its L1 at `port`.
    pub fn new(config: &MachineConfig, index: u8, port: Port) -> Self {
        let ti = &config.ti;
        let (inner, leaf, stack) = match ti.pipeline {
            Pipeline::Parallel => (ti.inner_cycles, ti.leaf_cycles, ti.stack_cycles),
            Pipeline::Single => [ti.inner_cycles + ti.leaf_cycles + ti.stack_cycles; 3].into(),
            // Of the three only the first has traversal units.
            Pipeline::Unified | Pipeline::Software | Pipeline::Gathering => {
                [ti.inner_cycles + ti.leaf_cycles + ti.stack_cycles + ti.ist_cycles; 3].into()
            }
        };
        let slots = ti.rays_per_trv as usize;
        let l1 = (&ti.trv_l1, ti.trv_lines_per_cycle);
        let buffer = InputBuffer::new((ti, ti.miss_handling), l1, config.l2.line_bytes, port, ti.rays_per_trv);
        let buffer = if ti.aabbs_per_cycle == 2 { buffer } else { buffer.with_second_reads() };
        Self {
            index,
            pipeline: ti.pipeline,
            short: if ti.stack_entries == 0 { u8::MAX } else { ti.stack_entries.min(255) as u8 },
            passes: (2 / ti.aabbs_per_cycle) as u8,
            boxes_per_pass: ti.aabbs_per_cycle as u8,
            rays: vec![RaySlot::default(); slots],
            trails: vec![Trail::new(); slots],
            free: (0..slots as u8).rev().collect(),
            entered: vec![TiCycle::default(); slots],
            idle: Idle::new(),
            port: FetchPort::new(buffer, index, EventKind::RetryLookup),
            stages: [Stage::default(); 3],
            setup_cycles: ti.setup_cycles.into(),
            inner_cycles: inner.into(),
            leaf_cycles: leaf.into(),
            stack_cycles: stack.into(),
            events: TrvCounters::default(),
        }
    }

    /// Free places for rays.
    #[inline]
    pub fn free(&self) -> usize {
        self.free.len()
    }

    /// Rays inside.
    #[inline]
    pub fn rays(&self) -> usize {
        self.rays.len() - self.free.len()
    }

    /// Cycles in which the stages of the unit were or will be busy, by stage.
    pub fn busy(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        self.names().iter().copied().zip(self.stages.iter().map(Stage::busy))
    }

    /// A ray arrives from the dispatcher.
    ///
    /// # Panics
    /// When no place is free.
    pub fn enter<T: Tiles>(&mut self, now: TiCycle, ray: RayRef, tiles: &T, wheel: &mut Wheel) {
        if self.rays() == 0 {
            self.idle.end(now);
        }
        let slot = self.free.pop().expect("the dispatcher looks for a free place");
        self.rays[slot as usize].enter(ray, tiles.work(ray.slot));
        self.entered[slot as usize] = now;
        wheel.push(now + self.setup_cycles, Event::new(EventKind::Setup, self.index, slot));
    }

    /// A leaf operation has got an entry of an intersection unit and can issue from `ready` on.
    #[inline]
    pub fn leaf_granted(&mut self, ready: TiCycle, grant: LeafGrant, wheel: &mut Wheel) {
        let LeafGrant { request: LeafRequest { slot, arrived, .. }, ist } = grant;
        let op = Candidate { arrived, ready, wait: Wait::Blocked, bypass: false, others_wait: false };
        let at = self.stages[self.stage(LEAF)].issue(op, &self.idle);
        wheel.push(at + self.leaf_cycles, Event { extra: ist, ..Event::new(EventKind::Leaf, self.index, slot) });
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

    /// An operation left the stack pipeline.
    #[inline]
    pub(super) fn stack_done<T, M>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) -> Step {
        let ray = &mut self.rays[slot as usize];
        match ray.popped() {
            Popped::Held => Step::Next,
            Popped::Empty => Step::Leave,
            Popped::Lost => {
                self.events.restarts += 1;
                Step::Visit(ray.restart(&mut self.trails[slot as usize], context.tree))
            }
        }
    }

    /// A refused lookup is tried again; `event` is booked anew while one is held up.
    pub(super) fn retry_lookup<T, M: Memory>(&mut self, event: Event, context: &mut EventContext<'_, T, M>) {
        if let Some((slot, op)) = self.port.retry_lookup(context) {
            self.issue(slot, op, context.wheel);
        }
        self.port.book_retry(event, context);
    }

    /// Node visits and triangle tests that are done.
    pub fn done(&self) -> (u64, u64) {
        (self.events.node_visits, self.events.triangle_tests)
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> TrvStats {
        let activities = self.stages.each_ref().map(|stage| stage.report(end, &self.idle));
        TrvStats {
            stages: self.names().iter().copied().zip(activities).collect(),
            events: self.events,
            buffer: self.port.counters(),
            l1: self.port.l1_counters(),
        }
    }

    fn names(&self) -> &'static [&'static str] {
        stage_names(self.pipeline)
    }

    /// The stage that does the work of `stage`.
    #[inline]
    fn stage(&self, stage: usize) -> usize {
        if self.pipeline == Pipeline::Parallel { stage } else { INNER }
    }

    /// An operation left the inner-node pipeline.
    #[inline]
    pub(super) fn inner_done<T: Tiles, M: Memory>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) -> Step {
        let ray = &mut self.rays[slot as usize];
        if ray.tests > 0 {
            return self.triangle_done(slot, context);
        }
        if ray.passes > 1 {
            ray.passes -= 1;
            self.retry(slot, context);
            return Step::Waits;
        }
        self.events.node_visits += 1;
        if ray.restarting() {
            return self.visited_again(slot);
        }
        self.events.pushes += u64::from(ray.visited(self.short));
        Step::Next
    }

    /// A triangle left the unified pipeline.
    fn triangle_done<T: Tiles, M: Memory>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) -> Step {
        let ray = &mut self.rays[slot as usize];
        ray.tested();
        if ray.tests == 0 {
            return Step::Next;
        }
        let triangle = ray.triangle();
        self.tell(slot, (Region::Triangle, triangle), context);
        self.fetch(slot, context.layout.triangle(triangle), Region::Triangle, context);
        Step::Waits
    }

    /// A node of a walk down again left the inner-node pipeline.
    #[cold]
    fn visited_again(&mut self, slot: u8) -> Step {
        self.events.restart_visits += 1;
        match self.rays[slot as usize].visited_again(&mut self.trails[slot as usize], self.short) {
            Ok(next) => Step::Visit(next),
            Err(pushes) => {
                self.events.pushes += u64::from(pushes);
                Step::Next
            }
        }
    }

    /// An operation left the leaf pipeline: its task goes to the entry that was reserved in unit `ist`.
    #[inline]
    pub(super) fn leaf_done<T, M>(&mut self, slot: u8, ist: u8, context: &mut EventContext<'_, T, M>) -> Step {
        let ray = &mut self.rays[slot as usize];
        let (tests, triangle) = (std::mem::take(&mut ray.tests), ray.triangle());
        if tests == 0 {
            context.crossbar.release(ist);
            return Step::Next;
        }
        let task = LeafTask { trv: self.index, slot, triangle, tests };
        context.crossbar.send(context.now, ist, task, context.wheel);
        Step::Waits
    }

    /// The ray takes its step. Nearly all of a unit's work comes through here, so it stands in one place of the program.
    #[inline(always)]
    pub(super) fn go_on<T: Tiles, M: Memory>(
        &mut self,
        mut step: Step,
        slot: u8,
        context: &mut EventContext<'_, T, M>,
    ) {
        let ray = &mut self.rays[slot as usize];
        let node = loop {
            match step {
                Step::Waits => return,
                Step::Leave => return self.leave(slot, context),
                Step::Visit(node) => break node,
                Step::Next => {}
            }
            match ray.next(context.tiles.work(ray.ray.slot)) {
                Some(OpKind::Visit { node, .. }) => break node,
                // An empty leaf of the unified pipeline: there is nothing to read and nothing to test.
                Some(OpKind::Leaf { tests: 0, .. }) if self.pipeline == Pipeline::Unified => self.events.leaves += 1,
                Some(OpKind::Leaf { triangle, .. }) => return self.enter_leaf(slot, triangle, context),
                Some(kind) => return self.enter_stack(slot, kind, context),
                None => step = Step::Leave,
            }
        };
        ray.passes = self.passes;
        self.tell(slot, (Region::Node, node), context);
        self.fetch(slot, context.layout.node(node), Region::Node, context);
    }

    /// The ray comes to the stack.
    #[inline]
    fn enter_stack<T, M>(&mut self, slot: u8, kind: OpKind, context: &mut EventContext<'_, T, M>) {
        self.events.culled += u64::from(matches!(kind, OpKind::Cull { .. }));
        self.events.stack_operations += 1;
        let (arrived, stage) = (context.now, self.stage(STACK));
        let op = Candidate { arrived, ready: arrived, wait: Wait::Fetch, bypass: false, others_wait: false };
        let at = self.stages[stage].issue(op, &self.idle);
        context.wheel.push(at + self.stack_cycles, Event::new(EventKind::Stack, self.index, slot));
    }

    /// The ray comes to a leaf.
    fn enter_leaf<T: Tiles, M: Memory>(&mut self, slot: u8, triangle: u32, context: &mut EventContext<'_, T, M>) {
        self.events.leaves += 1;
        if self.pipeline == Pipeline::Unified {
            self.tell(slot, (Region::Triangle, triangle), context);
            return self.fetch(slot, context.layout.triangle(triangle), Region::Triangle, context);
        }
        let request = LeafRequest { trv: self.index, slot, arrived: context.now };
        if let Some(grant) = context.crossbar.reserve_or_wait(request) {
            self.leaf_granted(context.now, grant, context.wheel);
        }
    }

    /// The ray in `slot`.
    pub(super) fn ray(&self, slot: u8) -> RayRef {
        self.rays[slot as usize].ray
    }

    /// Tells whoever listens what the ray in `slot` looks for here.
    #[inline(always)]
    fn tell<T: Tiles, M: Memory>(&self, slot: u8, what: (Region, u32), context: &mut EventContext<'_, T, M>) {
        if M::LISTENS {
            context.tell(self.port.l1_port(), self.ray(slot), what);
        }
    }

    /// The operation at hand comes to the input buffer.
    #[inline(always)]
    fn fetch<T, M: Memory>(&mut self, slot: u8, lines: Lines, region: Region, context: &mut EventContext<'_, T, M>) {
        if let Some(op) = self.port.fetch(slot, lines, region, context) {
            self.issue(slot, op, context.wheel);
        }
    }

    /// The operation at hand comes to the input buffer again: after a bypass, or for its second box.
    #[inline]
    pub(super) fn retry<T, M: Memory>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) {
        if let Some(op) = self.port.fetch_again(slot, context) {
            self.issue(slot, op, context.wheel);
        }
    }

    /// Issues an operation that has its data in sight.
    #[inline(always)]
    fn issue(&mut self, slot: u8, op: Candidate, wheel: &mut Wheel) {
        let at = self.stages[INNER].issue(op, &self.idle);
        let kind = if op.bypass {
            self.events.bypasses += 1;
            EventKind::InnerBypass
        } else if self.rays[slot as usize].tests > 0 {
            self.events.triangle_tests += 1;
            EventKind::Inner
        } else {
            self.events.box_tests += u64::from(self.boxes_per_pass);
            EventKind::Inner
        };
        wheel.push(at + self.inner_cycles, Event::new(kind, self.index, slot));
    }

    /// The ray's hit is known: its place becomes free.
    fn leave<T: Tiles, M: Memory>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) {
        self.events.rays += 1;
        self.events.ray_cycles += context.now - self.entered[slot as usize];
        self.free.push(slot);
        if self.rays() == 0 {
            self.idle.begin(context.now);
        }
        context.done.push(self.rays[slot as usize].ray);
    }
}
