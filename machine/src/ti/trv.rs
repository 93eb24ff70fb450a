//! A traversal unit: rays that walk the tree through inner-node, leaf and stack pipelines.
//!
//! What leaves a pipeline in a cycle is routed in that cycle: to the lookup of a node, to the leaf stage, to the stack stage.
//! Each stage issues at most one operation a cycle (`parallel`), or all stages together one (`single`, `unified`), first
//! ready, first issued. A leaf operation issues only when it has an entry of an intersection unit, so pipelines never stall
//! inside; those that wait for one stand in one line for all traversal units of the core.

use super::front::{Front, FrontCounters, Outcome};
use super::ist::{LeafTask, Tasks};
use super::ray::{Popped, RaySlot};
use super::stage::{Candidate, Idle, Stage, Wait};
use super::wheel::{Event, Kind, Wheel};
use super::{Context, Tiles};
use crate::config::{MachineConfig, Pipeline};
use crate::counters::{Activity, counters};
use crate::link::RayRef;
use crate::memory::l1::CacheCounters;
use crate::memory::{Cycle, Memory, Port};
use crate::work::layout::Region;
use crate::work::ops::OpKind;

counters! {
    /// What a traversal unit did.
    pub struct TrvCounters {
        rays: "rays", "rays that finished";
        node_visits: "events", "inner nodes visited, visits on restarts included";
        restart_visits: "events", "inner nodes visited again because the short stack had lost a child";
        box_tests: "events", "boxes tested";
        leaves: "events", "leaves processed";
        triangle_tests: "events", "triangles tested here (pipeline = \"unified\")";
        stack_operations: "events", "operations of the stack pipeline";
        culled: "events", "popped children that lay behind the closest hit";
        pushes: "events", "children pushed onto the stack, on restarts again";
        restarts: "events", "pops that found the short stack empty while children were deferred";
        bypasses: "events", "operations that passed a pipeline without work";
        ray_cycles: "cycles", "cycles that rays spent here, summed over rays";
    }
}

/// What a unit reports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TrvStats {
    /// Each issue stage with what it did in every cycle.
    pub stages: Vec<(&'static str, Activity)>,
    /// Events.
    pub events: TrvCounters,
    /// Input buffer.
    pub front: FrontCounters,
    /// L1.
    pub l1: CacheCounters,
}

/// Issue stages of the parallel pipeline; the single one has only the first.
const INNER: usize = 0;
const LEAF: usize = 1;
const STACK: usize = 2;

/// See the module.
#[derive(Debug)]
pub struct Trv {
    index: u8,
    pipeline: Pipeline,
    short: u8,
    passes: u8,
    boxes_per_pass: u8,
    rays: Vec<RaySlot>,
    free: Vec<u8>,
    entered: Vec<Cycle>,
    idle: Idle,
    front: Front,
    stages: [Stage; 3],
    /// Depths of the pipelines.
    setup: Cycle,
    inner: Cycle,
    leaf: Cycle,
    stack: Cycle,
    events: TrvCounters,
}

/// What a tick works with.
pub(super) struct Tick<'a, M, T> {
    pub now: Cycle,
    pub context: &'a Context<'a, T>,
    pub tasks: &'a mut Tasks,
    pub memory: &'a mut M,
    pub wheel: &'a mut Wheel,
    /// Finished rays are appended here.
    pub done: &'a mut Vec<RayRef>,
}

impl Trv {
    /// Unit `index` of a core, its L1 at `port`.
    pub fn new(config: &MachineConfig, index: u8, port: Port) -> Self {
        let ti = &config.ti;
        let (inner, leaf, stack) = match ti.pipeline {
            Pipeline::Parallel => (ti.inner_cycles, ti.leaf_cycles, ti.stack_cycles),
            Pipeline::Single => [ti.inner_cycles + ti.leaf_cycles + ti.stack_cycles; 3].into(),
            Pipeline::Unified => [ti.inner_cycles + ti.leaf_cycles + ti.stack_cycles + ti.ist_cycles; 3].into(),
        };
        let slots = ti.rays_per_trv as usize;
        let l1 = (&ti.trv_l1, ti.trv_lines_per_cycle);
        Self {
            index,
            pipeline: ti.pipeline,
            short: if ti.stack_entries == 0 { u8::MAX } else { ti.stack_entries.min(255) as u8 },
            passes: (2 / ti.aabbs_per_cycle) as u8,
            boxes_per_pass: ti.aabbs_per_cycle as u8,
            rays: vec![RaySlot::default(); slots],
            free: (0..slots as u8).rev().collect(),
            entered: vec![0; slots],
            idle: Idle::new(),
            front: Front::new(ti, l1, config.l2.line_bytes, port, ti.rays_per_trv),
            stages: [Stage::default(); 3],
            setup: ti.setup_cycles.into(),
            inner: inner.into(),
            leaf: leaf.into(),
            stack: stack.into(),
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
    pub fn busy(&self) -> impl Iterator<Item = (&'static str, Cycle)> + '_ {
        self.names().iter().copied().zip(self.stages.iter().map(Stage::busy))
    }

    /// A ray arrives from the dispatcher.
    ///
    /// # Panics
    /// When no place is free.
    pub fn enter<T: Tiles>(&mut self, now: Cycle, ray: RayRef, tiles: &T, wheel: &mut Wheel) {
        if self.rays() == 0 {
            self.idle.end(now);
        }
        let slot = self.free.pop().expect("the dispatcher looks for a free place");
        self.rays[slot as usize].enter(ray, tiles.work(ray.slot));
        self.entered[slot as usize] = now;
        wheel.push(now + self.setup, Event::new(Kind::Setup, self.index, slot));
    }

    /// A leaf operation that waited since `arrived` has got an entry of intersection unit `ist` and can issue from `ready` on.
    #[inline]
    pub fn leaf_granted(&mut self, ready: Cycle, slot: u8, arrived: Cycle, ist: u8, wheel: &mut Wheel) {
        let op = Candidate { arrived, ready, wait: Wait::Blocked, bypass: false, others_wait: false };
        let at = self.stages[self.stage(LEAF)].issue(op, &self.idle);
        wheel.push(at + self.leaf, Event { extra: ist, ..Event::new(Kind::Leaf, self.index, slot) });
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

    /// An operation left the stack pipeline.
    pub(super) fn popped<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        match self.rays[slot as usize].popped(tick.context.tree) {
            Popped::Empty => self.leave(slot, tick),
            Popped::Held => self.go_on(slot, tick),
            Popped::Lost(root) => {
                self.events.restarts += 1;
                self.visit(slot, root, tick);
            }
        }
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
    pub fn finish(&mut self, cycles: Cycle) -> TrvStats {
        let idle = self.idle;
        let activities = self.stages.each_mut().map(|stage| stage.finish(cycles, &idle));
        TrvStats {
            stages: self.names().iter().copied().zip(activities).collect(),
            events: self.events,
            front: self.front.counters,
            l1: *self.front.l1().counters(),
        }
    }

    fn names(&self) -> &'static [&'static str] {
        match self.pipeline {
            Pipeline::Parallel => &["inner", "leaf", "stack"],
            Pipeline::Single | Pipeline::Unified => &["pipeline"],
        }
    }

    /// The stage that does the work of `stage`.
    #[inline]
    fn stage(&self, stage: usize) -> usize {
        if self.pipeline == Pipeline::Parallel { stage } else { INNER }
    }

    /// An operation left the inner-node pipeline.
    #[inline]
    pub(super) fn passed<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        let ray = &mut self.rays[slot as usize];
        if ray.tests > 0 {
            // Unified pipeline: a triangle.
            ray.tests -= 1;
            ray.triangle += 1;
            if ray.tests == 0 {
                return self.go_on(slot, tick);
            }
            let lines = tick.context.layout.triangle(ray.triangle);
            let outcome = self.front.push(tick.now, slot, lines, Region::Triangle, tick.memory);
            return self.follow(slot, outcome, tick);
        }
        if ray.passes > 1 {
            ray.passes -= 1;
            return self.again(slot, tick);
        }
        self.events.node_visits += 1;
        if ray.restarting() {
            self.events.restart_visits += 1;
            match ray.visited_again(self.short) {
                Ok(next) => return self.visit(slot, next, tick),
                Err(pushes) => self.events.pushes += u64::from(pushes),
            }
        } else {
            self.events.pushes += u64::from(ray.visited(self.short));
        }
        self.go_on(slot, tick);
    }

    pub(super) fn leaf_passed<M: Memory, T: Tiles>(&mut self, slot: u8, ist: u8, tick: &mut Tick<'_, M, T>) {
        let ray = &mut self.rays[slot as usize];
        let (tests, triangle) = (std::mem::take(&mut ray.tests), ray.triangle);
        if tests == 0 {
            tick.tasks.release(ist);
            self.go_on(slot, tick);
        } else {
            let task = LeafTask { trv: self.index, slot, triangle, tests };
            tick.tasks.send(tick.now, ist, task, tick.wheel);
        }
    }

    /// Puts the ray's next operation where it belongs.
    #[inline]
    pub(super) fn go_on<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        let ray = &mut self.rays[slot as usize];
        match ray.next(tick.context.tiles.work(ray.ray.slot)) {
            Some(OpKind::Visit { node, .. }) => self.visit(slot, node, tick),
            Some(OpKind::Leaf { triangle, tests }) => self.enter_leaf(slot, triangle, tests, tick),
            Some(kind) => {
                self.events.culled += u64::from(matches!(kind, OpKind::Cull { .. }));
                self.events.stack_operations += 1;
                let (arrived, stage) = (tick.now, self.stage(STACK));
                let op = Candidate { arrived, ready: arrived, wait: Wait::Fetch, bypass: false, others_wait: false };
                let at = self.stages[stage].issue(op, &self.idle);
                tick.wheel.push(at + self.stack, Event::new(Kind::Stack, self.index, slot));
            }
            None => self.leave(slot, tick),
        }
    }

    fn enter_leaf<M: Memory, T: Tiles>(&mut self, slot: u8, triangle: u32, tests: u8, tick: &mut Tick<'_, M, T>) {
        self.events.leaves += 1;
        if self.pipeline != Pipeline::Unified {
            if let Some(ist) = tick.tasks.reserve_or_wait(self.index, slot, tick.now) {
                self.leaf_granted(tick.now, slot, tick.now, ist, tick.wheel);
            }
        } else if tests > 0 {
            let lines = tick.context.layout.triangle(triangle);
            let outcome = self.front.push(tick.now, slot, lines, Region::Triangle, tick.memory);
            self.follow(slot, outcome, tick);
        } else {
            // An empty leaf: there is nothing to read and nothing to test.
            self.go_on(slot, tick);
        }
    }

    #[inline]
    fn visit<M: Memory, T: Tiles>(&mut self, slot: u8, node: u32, tick: &mut Tick<'_, M, T>) {
        self.rays[slot as usize].passes = self.passes;
        let lines = tick.context.layout.node(node);
        let outcome = self.front.push(tick.now, slot, lines, Region::Node, tick.memory);
        self.follow(slot, outcome, tick);
    }

    /// The operation at hand goes to the input buffer again.
    pub(super) fn again<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        let outcome = self.front.push_again(tick.now, slot, tick.memory);
        self.follow(slot, outcome, tick);
    }

    /// What an arrival or a lookup leads to.
    #[inline]
    fn follow<M: Memory, T: Tiles>(&mut self, slot: u8, outcome: Outcome, tick: &mut Tick<'_, M, T>) {
        match outcome {
            Outcome::Ready(op) => self.issue(slot, op, tick.wheel),
            Outcome::HeldUp => tick.wheel.push(tick.now + 1, Event::new(Kind::LookUpAgain, self.index, slot)),
            Outcome::Waits => {}
        }
    }

    /// Issues an operation that has its data in sight.
    #[inline]
    fn issue(&mut self, slot: u8, op: Candidate, wheel: &mut Wheel) {
        let at = self.stages[INNER].issue(op, &self.idle);
        let kind = if op.bypass {
            self.events.bypasses += 1;
            Kind::InnerBypass
        } else if self.rays[slot as usize].tests > 0 {
            self.events.triangle_tests += 1;
            Kind::Inner
        } else {
            self.events.box_tests += u64::from(self.boxes_per_pass);
            Kind::Inner
        };
        wheel.push(at + self.inner, Event::new(kind, self.index, slot));
    }

    /// The ray's hit is known: its place becomes free.
    fn leave<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        self.events.rays += 1;
        self.events.ray_cycles += tick.now - self.entered[slot as usize];
        self.free.push(slot);
        if self.rays() == 0 {
            self.idle.begin(tick.now);
        }
        tick.done.push(self.rays[slot as usize].ray);
    }
}
