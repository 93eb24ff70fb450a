//! A traversal unit: rays that walk the tree through inner-node, leaf and stack pipelines.
//!
//! What leaves a pipeline in a cycle is routed in that cycle: to the lookup of a node, to the leaf stage, to the stack stage.
//! Each stage issues at most one operation a cycle (`parallel`), or all stages together one (`single`, `unified`), first
//! ready, first issued. A leaf operation issues only when it has an entry of an intersection unit, so pipelines never stall
//! inside; those that wait for one stand in one line for all traversal units of the core.

use std::collections::VecDeque;

use super::front::{Front, FrontCounters};
use super::ist::{LeafTask, Tasks};
use super::pipe::Pipe;
use super::ray::{Popped, RaySlot};
use super::stage::{Candidate, Idle, Stage, Wait};
use super::{Context, Tiles};
use crate::machine::config::{MachineConfig, Pipeline};
use crate::machine::counters::{Activity, counters};
use crate::machine::link::RayRef;
use crate::machine::memory::l1::CacheCounters;
use crate::machine::memory::{Cycle, Memory, Port};
use crate::machine::work::layout::Region;
use crate::machine::work::ops::OpKind;

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
    setup: Pipe<u8>,
    front: Front,
    stages: [Stage; 3],
    inner: Pipe<(u8, bool)>,
    leaf: Pipe<(u8, u8)>,
    stack: Pipe<u8>,
    /// Leaf results on their way back.
    returned: VecDeque<(Cycle, u8)>,
    events: TrvCounters,
}

/// What a tick works with.
pub(super) struct Tick<'a, M, T> {
    pub now: Cycle,
    pub context: &'a Context<'a, T>,
    pub tasks: &'a mut Tasks,
    pub memory: &'a mut M,
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
            setup: Pipe::new(ti.setup_cycles),
            front: Front::new(ti, l1, config.l2.line_bytes, port, ti.rays_per_trv),
            stages: [Stage::default(); 3],
            inner: Pipe::new(inner),
            leaf: Pipe::new(leaf),
            stack: Pipe::new(stack),
            returned: VecDeque::with_capacity(slots),
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
    pub fn enter<T: Tiles>(&mut self, now: Cycle, ray: RayRef, tiles: &T) {
        if self.rays() == 0 {
            self.idle.end(now);
        }
        let slot = self.free.pop().expect("the dispatcher looks for a free place");
        self.rays[slot as usize].enter(ray, tiles.work(ray.slot));
        self.entered[slot as usize] = now;
        self.setup.push(now, slot);
    }

    /// The tests of a leaf are done: the result arrives at cycle `at`.
    #[inline]
    pub fn leaf_done(&mut self, at: Cycle, slot: u8) {
        self.returned.push_back((at, slot));
    }

    /// A leaf operation that waited since `arrived` has got an entry of intersection unit `ist` and can issue from `ready` on.
    #[inline]
    pub fn leaf_granted(&mut self, ready: Cycle, slot: u8, arrived: Cycle, ist: u8) {
        let op = Candidate { arrived, ready, wait: Wait::Blocked, bypass: false, others_wait: false };
        let at = self.stages[self.stage(LEAF)].issue(op, &self.idle);
        self.leaf.push(at, (slot, ist));
    }

    /// A line arrived at cycle `now`.
    pub fn fill(&mut self, now: Cycle, line: u64) {
        let Self { front, stages, inner, rays, events, idle, boxes_per_pass, .. } = self;
        front.fill(now, line, |slot, op| {
            issue_inner(&mut stages[INNER], inner, &rays[slot as usize], *boxes_per_pass, events, idle, (slot, op));
        });
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.front.l1_mut().invalidate(line);
    }

    /// One cycle.
    #[inline]
    pub(super) fn tick<M: Memory, T: Tiles>(&mut self, tick: &mut Tick<'_, M, T>) {
        let now = tick.now;
        while let Some((slot, bypass)) = self.inner.pop(now) {
            self.passed(slot, bypass, tick);
        }
        while let Some((slot, ist)) = self.leaf.pop(now) {
            self.leaf_passed(slot, ist, tick);
        }
        while let Some(slot) = self.stack.pop(now) {
            match self.rays[slot as usize].popped(tick.context.tree) {
                Popped::Empty => self.leave(slot, tick),
                Popped::Held => self.go_on(slot, tick),
                Popped::Lost(root) => {
                    self.events.restarts += 1;
                    self.visit(slot, root, tick);
                }
            }
        }
        while self.returned.front().is_some_and(|r| r.0 <= now) {
            let Some((_, slot)) = self.returned.pop_front() else { break };
            self.go_on(slot, tick);
        }
        while let Some(slot) = self.setup.pop(now) {
            self.go_on(slot, tick);
        }
        if let Some((slot, op)) = self.front.look_up(now, tick.memory) {
            self.issue(slot, Some(op));
        }
    }

    /// The next cycle at which something happens here without a push from outside; never, if there is none.
    #[inline]
    pub fn next_event(&self) -> Cycle {
        let back = self.returned.front().map_or(Cycle::MAX, |r| r.0);
        let lookup = self.front.next_event().unwrap_or(Cycle::MAX);
        let pipes = self.inner.next_event().min(self.leaf.next_event());
        pipes.min(self.stack.next_event()).min(self.setup.next_event()).min(back).min(lookup)
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
    fn passed<M: Memory, T: Tiles>(&mut self, slot: u8, bypass: bool, tick: &mut Tick<'_, M, T>) {
        let ray = &mut self.rays[slot as usize];
        if bypass {
            return self.again(slot, tick);
        }
        if ray.tests > 0 {
            // Unified pipeline: a triangle.
            ray.tests -= 1;
            ray.triangle += 1;
            if ray.tests == 0 {
                return self.go_on(slot, tick);
            }
            let lines = tick.context.layout.triangle(ray.triangle);
            let op = self.front.push(tick.now, slot, lines, Region::Triangle, tick.memory);
            return self.issue(slot, op);
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

    fn leaf_passed<M: Memory, T: Tiles>(&mut self, slot: u8, ist: u8, tick: &mut Tick<'_, M, T>) {
        let ray = &mut self.rays[slot as usize];
        let (tests, triangle) = (std::mem::take(&mut ray.tests), ray.triangle);
        if tests == 0 {
            tick.tasks.release(ist);
            self.go_on(slot, tick);
        } else {
            tick.tasks.send(tick.now, ist, LeafTask { trv: self.index, slot, triangle, tests });
        }
    }

    /// Puts the ray's next operation where it belongs.
    #[inline]
    fn go_on<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
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
                self.stack.push(at, slot);
            }
            None => self.leave(slot, tick),
        }
    }

    fn enter_leaf<M: Memory, T: Tiles>(&mut self, slot: u8, triangle: u32, tests: u8, tick: &mut Tick<'_, M, T>) {
        self.events.leaves += 1;
        if self.pipeline != Pipeline::Unified {
            if let Some(ist) = tick.tasks.reserve_or_wait(self.index, slot, tick.now) {
                self.leaf_granted(tick.now, slot, tick.now, ist);
            }
        } else if tests > 0 {
            let lines = tick.context.layout.triangle(triangle);
            let op = self.front.push(tick.now, slot, lines, Region::Triangle, tick.memory);
            self.issue(slot, op);
        } else {
            // An empty leaf: there is nothing to read and nothing to test.
            self.go_on(slot, tick);
        }
    }

    #[inline]
    fn visit<M: Memory, T: Tiles>(&mut self, slot: u8, node: u32, tick: &mut Tick<'_, M, T>) {
        self.rays[slot as usize].passes = self.passes;
        let op = self.front.push(tick.now, slot, tick.context.layout.node(node), Region::Node, tick.memory);
        self.issue(slot, op);
    }

    /// The operation at hand goes to the input buffer again.
    fn again<M: Memory, T: Tiles>(&mut self, slot: u8, tick: &mut Tick<'_, M, T>) {
        let op = self.front.push_again(tick.now, slot, tick.memory);
        self.issue(slot, op);
    }

    /// Issues an operation that has its data in sight.
    #[inline]
    fn issue(&mut self, slot: u8, op: Option<Candidate>) {
        let Some(op) = op else { return };
        let (ray, passes) = (&self.rays[slot as usize], self.boxes_per_pass);
        issue_inner(&mut self.stages[INNER], &mut self.inner, ray, passes, &mut self.events, &self.idle, (slot, op));
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

/// Issues an operation of the input buffer into the inner-node (or only) pipeline.
#[inline]
fn issue_inner(
    stage: &mut Stage,
    pipe: &mut Pipe<(u8, bool)>,
    ray: &RaySlot,
    boxes: u8,
    events: &mut TrvCounters,
    idle: &Idle,
    (slot, op): (u8, Candidate),
) {
    let at = stage.issue(op, idle);
    pipe.push(at, (slot, op.bypass));
    if op.bypass {
        events.bypasses += 1;
    } else if ray.tests > 0 {
        events.triangle_tests += 1;
    } else {
        events.box_tests += u64::from(boxes);
    }
}
