//! A traversal unit: rays that walk the tree through inner-node, leaf and stack pipelines.
//!
//! A cycle goes: what left the pipelines is routed; rays that finished setup begin; one line is looked up; each stage issues
//! at most one operation (`parallel`), or all stages together one (`single`, `unified`: stack before leaf before inner node).
//! A leaf operation issues only when an intersection unit has a free entry for it, so pipelines never stall inside.

use std::collections::VecDeque;

use super::account::{Account, Slot};
use super::front::{Front, FrontCounters};
use super::ist::{LeafTask, Tasks};
use super::pipe::Pipe;
use super::ray::{Popped, RaySlot};
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
    setup: Pipe<u8>,
    front: Front,
    inner: Pipe<(u8, bool)>,
    leaves: VecDeque<u8>,
    leaf: Pipe<(u8, u8)>,
    pops: VecDeque<u8>,
    stack: Pipe<u8>,
    /// Leaf results on their way back.
    returned: VecDeque<(Cycle, u8)>,
    /// What each stage does in the cycles until the next tick.
    between: [Slot; 3],
    activity: [Account; 3],
    ticked: Option<Cycle>,
    events: TrvCounters,
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
        Self {
            index,
            pipeline: ti.pipeline,
            short: if ti.stack_entries == 0 { u8::MAX } else { ti.stack_entries.min(255) as u8 },
            passes: (2 / ti.aabbs_per_cycle) as u8,
            boxes_per_pass: ti.aabbs_per_cycle as u8,
            rays: vec![RaySlot::default(); slots],
            free: (0..slots as u8).rev().collect(),
            entered: vec![0; slots],
            setup: Pipe::new(ti.setup_cycles),
            front: Front::new(ti, (&ti.trv_l1, ti.trv_lines_per_cycle), config.l2.line_bytes, port, ti.rays_per_trv),
            inner: Pipe::new(inner),
            leaves: VecDeque::with_capacity(slots),
            leaf: Pipe::new(leaf),
            pops: VecDeque::with_capacity(slots),
            stack: Pipe::new(stack),
            returned: VecDeque::with_capacity(slots),
            between: [Slot::Idle; 3],
            activity: Default::default(),
            ticked: None,
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

    /// A ray arrives from the dispatcher.
    ///
    /// # Panics
    /// When no place is free.
    pub fn enter<T: Tiles>(&mut self, now: Cycle, ray: RayRef, tiles: &T) {
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

    /// A line arrived.
    pub fn fill(&mut self, line: u64) {
        self.front.fill(line);
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.front.l1_mut().invalidate(line);
    }

    /// One cycle. Finished rays are appended to `done`, leaf tasks to `tasks`.
    pub fn tick<M: Memory, T: Tiles>(
        &mut self,
        now: Cycle,
        context: &Context<'_, T>,
        tasks: &mut Tasks,
        memory: &mut M,
        done: &mut Vec<RayRef>,
    ) {
        self.account_gap(now);
        self.complete(now, context, tasks, done);
        self.front.look_up(now, memory);
        let issued = self.issue(now, tasks);
        self.account(issued, tasks);
        self.ticked = Some(now);
    }

    /// The next cycle at which something happens here without a push from outside, judged at the end of cycle `now`.
    #[inline]
    pub fn next_event(&self, now: Cycle) -> Option<Cycle> {
        if !self.pops.is_empty() || !self.leaves.is_empty() {
            return Some(now + 1);
        }
        let soonest = self.front.next_event(now).unwrap_or(Cycle::MAX);
        if soonest == now + 1 {
            return Some(soonest);
        }
        let pipes = [self.inner.next_event(), self.stack.next_event(), self.leaf.next_event(), self.setup.next_event()];
        let back = self.returned.front().map(|r| r.0);
        let next = pipes.into_iter().chain([back]).flatten().fold(soonest, Cycle::min);
        (next != Cycle::MAX).then(|| next.max(now + 1))
    }

    /// Closes the accounts of a run of `cycles` cycles.
    pub fn finish(&mut self, cycles: Cycle) -> TrvStats {
        self.account_gap(cycles);
        let names: &[&str] = match self.pipeline {
            Pipeline::Parallel => &["inner", "leaf", "stack"],
            Pipeline::Single | Pipeline::Unified => &["pipeline"],
        };
        TrvStats {
            stages: names.iter().copied().zip(self.activity.map(|stage| stage.activity())).collect(),
            events: self.events,
            front: self.front.counters,
            l1: *self.front.l1().counters(),
        }
    }

    fn complete<T: Tiles>(&mut self, now: Cycle, context: &Context<'_, T>, tasks: &mut Tasks, done: &mut Vec<RayRef>) {
        while let Some((slot, bypass)) = self.inner.pop(now) {
            self.passed(now, slot, bypass, context, done);
        }
        while let Some((slot, ist)) = self.leaf.pop(now) {
            self.leaf_passed(now, slot, ist, context, tasks, done);
        }
        while let Some(slot) = self.stack.pop(now) {
            match self.rays[slot as usize].popped(context.tree) {
                Popped::Empty => self.leave(now, slot, done),
                Popped::Held => self.go_on(now, slot, context, done),
                Popped::Lost(root) => {
                    self.events.restarts += 1;
                    self.visit(slot, root, context);
                }
            }
        }
        while self.returned.front().is_some_and(|r| r.0 <= now) {
            let Some((_, slot)) = self.returned.pop_front() else { break };
            self.go_on(now, slot, context, done);
        }
        while let Some(slot) = self.setup.pop(now) {
            self.go_on(now, slot, context, done);
        }
    }

    /// An operation left the inner-node pipeline.
    #[inline]
    fn passed<T: Tiles>(
        &mut self,
        now: Cycle,
        slot: u8,
        bypass: bool,
        context: &Context<'_, T>,
        done: &mut Vec<RayRef>,
    ) {
        if bypass {
            self.front.push_again(slot);
            return;
        }
        let ray = &mut self.rays[slot as usize];
        if ray.tests > 0 {
            // Unified pipeline: a triangle.
            ray.tests -= 1;
            ray.triangle += 1;
            if ray.tests == 0 {
                self.go_on(now, slot, context, done);
            } else {
                self.front.push(slot, context.layout.triangle(ray.triangle), Region::Triangle);
            }
            return;
        }
        if ray.passes > 1 {
            ray.passes -= 1;
            self.front.push_again(slot);
            return;
        }
        self.events.node_visits += 1;
        if ray.restarting() {
            self.events.restart_visits += 1;
            match ray.visited_again(self.short) {
                Ok(next) => return self.visit(slot, next, context),
                Err(pushes) => self.events.pushes += u64::from(pushes),
            }
        } else {
            self.events.pushes += u64::from(ray.visited(self.short));
        }
        self.go_on(now, slot, context, done);
    }

    fn leaf_passed<T: Tiles>(
        &mut self,
        now: Cycle,
        slot: u8,
        ist: u8,
        context: &Context<'_, T>,
        tasks: &mut Tasks,
        done: &mut Vec<RayRef>,
    ) {
        let ray = &mut self.rays[slot as usize];
        let (tests, triangle) = (std::mem::take(&mut ray.tests), ray.triangle);
        if tests == 0 {
            tasks.release(ist);
            self.go_on(now, slot, context, done);
        } else {
            tasks.send(now, ist, LeafTask { trv: self.index, slot, triangle, tests });
        }
    }

    /// Puts the ray's next operation where it belongs.
    #[inline]
    fn go_on<T: Tiles>(&mut self, now: Cycle, slot: u8, context: &Context<'_, T>, done: &mut Vec<RayRef>) {
        let ray = &mut self.rays[slot as usize];
        match ray.next(context.tiles.work(ray.ray.slot)) {
            Some(OpKind::Visit { node, .. }) => self.visit(slot, node, context),
            Some(OpKind::Leaf { triangle, tests }) => {
                self.events.leaves += 1;
                if self.pipeline != Pipeline::Unified {
                    self.leaves.push_back(slot);
                } else if tests > 0 {
                    self.front.push(slot, context.layout.triangle(triangle), Region::Triangle);
                } else {
                    // An empty leaf: there is nothing to read and nothing to test.
                    self.go_on(now, slot, context, done);
                }
            }
            Some(kind) => {
                self.events.culled += u64::from(matches!(kind, OpKind::Cull { .. }));
                self.pops.push_back(slot);
            }
            None => self.leave(now, slot, done),
        }
    }

    #[inline]
    fn visit<T: Tiles>(&mut self, slot: u8, node: u32, context: &Context<'_, T>) {
        self.rays[slot as usize].passes = self.passes;
        self.front.push(slot, context.layout.node(node), Region::Node);
    }

    /// The ray's hit is known: its place becomes free.
    fn leave(&mut self, now: Cycle, slot: u8, done: &mut Vec<RayRef>) {
        self.events.rays += 1;
        self.events.ray_cycles += now - self.entered[slot as usize];
        self.free.push(slot);
        done.push(self.rays[slot as usize].ray);
    }

    /// Issues what can issue. Returns the class of each stage if it issued.
    #[inline]
    fn issue(&mut self, now: Cycle, tasks: &mut Tasks) -> [Option<Slot>; 3] {
        let mut issued = [None; 3];
        let parallel = self.pipeline == Pipeline::Parallel;
        if let Some(slot) = self.pops.pop_front() {
            self.stack.push(now, slot);
            self.events.stack_operations += 1;
            issued[STACK] = Some(Slot::Busy);
            if !parallel {
                return [Some(Slot::Busy); 3];
            }
        }
        if !self.leaves.is_empty()
            && let Some(ist) = tasks.reserve()
            && let Some(slot) = self.leaves.pop_front()
        {
            self.leaf.push(now, (slot, ist));
            issued[LEAF] = Some(Slot::Busy);
            if !parallel {
                return [Some(Slot::Busy); 3];
            }
        }
        if let Some(issue) = self.front.issue(now) {
            self.inner.push(now, (issue.op, issue.bypass));
            issued[INNER] = Some(if issue.bypass { Slot::Bypass } else { Slot::Busy });
            if issue.bypass {
                self.events.bypasses += 1;
            } else if self.rays[issue.op as usize].tests > 0 {
                self.events.triangle_tests += 1;
            } else {
                self.events.box_tests += u64::from(self.boxes_per_pass);
            }
        }
        issued
    }

    /// Cycles since the last tick in which nothing happened.
    #[inline]
    fn account_gap(&mut self, now: Cycle) {
        let since = self.ticked.map_or(0, |t| t + 1);
        let gap = now - since;
        if gap > 0 {
            for stage in 0..3 {
                self.activity[stage].add(self.between[stage], gap);
            }
        }
    }

    #[inline]
    fn account(&mut self, issued: [Option<Slot>; 3], tasks: &Tasks) {
        let rays = self.free.len() < self.rays.len();
        let mut inner = Slot::of(self.front.waiting(), rays);
        let blocked = !self.leaves.is_empty() && tasks.all_full();
        if self.pipeline != Pipeline::Parallel && inner == Slot::Starved && blocked {
            inner = Slot::Blocked;
        }
        let none = if rays { Slot::Starved } else { Slot::Idle };
        self.between = [inner, if blocked { Slot::Blocked } else { none }, none];
        for stage in 0..3 {
            self.activity[stage].add(issued[stage].unwrap_or(self.between[stage]), 1);
        }
    }
}
