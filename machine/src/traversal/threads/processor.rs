//! A processor: warps that execute blocks of code, what they share, and its two caches.
//!
//! * A warp executes a block at a time. First the lines of its code are looked up in the instruction cache and those of its data
//!   in the data cache, in this order, each line once a warp; it waits until all have come. A refused lookup is tried again each
//!   cycle, the first first.
//! * Then it takes its instructions' places: `issue` and one for each class of units, so many a cycle, first come, first served.
//!   Lanes that are off take places too, but of reciprocals. The block is over when all its places are, and not before the
//!   cycles that the warp takes alone: an instruction a cycle, what the thread waits for its own results, and the latency of the
//!   data cache if it loads.
//! * The next block begins in the cycle in which the one before is over. The hits of a warp leave when its last lane is through.

use std::collections::VecDeque;

use super::events::{Event, Events, What};
use super::places::Places;
use super::program::{Asked, BlockId, CLASSES, Program};
use super::stats::{ProcessorCounters, ProcessorStats};
use super::warp::{State, Task, Warp, is_in};
use crate::config::MachineConfig;
use crate::counters::Activity;
use crate::link::{Job, RayRef};
use crate::memory::{Access, L1Cache, Memory, Port, Tags};
use crate::ti::{Tiles, TrvCounters, TrvStats, stage_names};
use crate::time::TiCycle;
use crate::traversal::cursor::Cursor;
use crate::work::layout::{Layout, Lines, Region};

/// What a processor works with.
pub struct Context<'a, T, M> {
    pub now: TiCycle,
    pub layout: &'a Layout,
    pub tiles: &'a T,
    pub memory: &'a mut M,
    pub events: &'a mut Events,
    /// Finished rays are appended here.
    pub rays: &'a mut VecDeque<RayRef>,
    /// Tags of finished jobs are appended here.
    pub jobs: &'a mut VecDeque<u32>,
}

/// A lookup that was refused.
#[derive(Clone, Copy, Debug)]
struct Lookup {
    warp: u8,
    line: u64,
    region: Region,
}

/// A processor.
#[derive(Debug)]
pub struct Processor {
    index: u8,
    lanes: u32,
    program: Program,
    warps: Vec<Warp>,
    free: Vec<u8>,
    issue: Places,
    units: [Places; CLASSES],
    data: L1Cache,
    code: L1Cache,
    refused: VecDeque<Lookup>,
    /// Lines of the block that begins, kept for its memory.
    reads: Vec<(u64, Region)>,
    events: TrvCounters,
    counters: ProcessorCounters,
    activity: Activity,
    /// Cycles before this one are in the activity.
    accounted: TiCycle,
    executing: u32,
}

impl Processor {
    /// Processor `index` of a core, its caches at these ports.
    pub fn new(config: &MachineConfig, index: u8, data: Port, code: Port) -> Self {
        let (ti, processor) = (&config.ti, &config.processor);
        let warps = (ti.rays_per_trv / processor.lanes).max(1);
        let units = &processor.units;
        let kinds = [units.add, units.multiply, units.compare, units.integer, units.special, units.memory];
        Self {
            index,
            lanes: processor.lanes,
            program: Program::new(config, &Layout::new(config)),
            warps: vec![Warp::new(); warps as usize],
            free: (0..warps as u8).rev().collect(),
            issue: Places::new(processor.issue),
            units: kinds.map(Places::new),
            data: L1Cache::new(&ti.trv_l1, config.l2.line_bytes, data),
            code: L1Cache::new(&processor.code_l1, config.l2.line_bytes, code),
            refused: VecDeque::new(),
            reads: Vec::new(),
            events: TrvCounters::default(),
            counters: ProcessorCounters::default(),
            activity: Activity::default(),
            accounted: TiCycle::default(),
            executing: 0,
        }
    }

    /// Places for warps that are free.
    #[inline]
    pub fn free(&self) -> usize {
        self.free.len()
    }

    /// Starts a warp of rays.
    ///
    /// # Panics
    /// When no place is free.
    pub fn start_rays<T: Tiles, M: Memory>(
        &mut self,
        rays: impl Iterator<Item = RayRef>,
        context: &mut Context<'_, T, M>,
    ) {
        let id = self.take_place(context.now);
        let (warp, leaves) = (&mut self.warps[usize::from(id)], &mut self.events.leaves);
        warp.lanes.clear();
        warp.lanes.extend(rays.map(|ray| Cursor::new(ray, context.now, context.tiles.work(ray.slot), leaves)));
        warp.task = Task::Rays(BlockId::Ray);
        self.begin(id, context);
    }

    /// Starts a warp of items of a kernel.
    ///
    /// # Panics
    /// When no place is free.
    pub fn start_job<T: Tiles, M: Memory>(&mut self, job: Job, context: &mut Context<'_, T, M>) {
        let id = self.take_place(context.now);
        self.warps[usize::from(id)].task = Task::Items(job);
        self.begin(id, context);
    }

    fn take_place(&mut self, now: TiCycle) -> u8 {
        self.account(now);
        self.counters.warps += 1;
        self.free.pop().expect("a warp is started only where a place is free")
    }

    /// A line arrived at the data cache, or at the instruction cache.
    pub fn fill(&mut self, now: TiCycle, line: u64, is_code: bool, events: &mut Events) {
        self.account(now);
        let mut waiters = if is_code { self.code.fill(line) } else { self.data.fill(line) };
        while waiters != 0 {
            let id = waiters.trailing_zeros() as u8;
            waiters &= waiters - 1;
            self.arrived(now, id, events);
        }
    }

    /// A line that a warp waited for is there.
    fn arrived(&mut self, now: TiCycle, id: u8, events: &mut Events) {
        let warp = &mut self.warps[usize::from(id)];
        warp.missing -= 1;
        if warp.missing == 0 {
            self.execute(now, id, events);
        }
    }

    /// Looks up what the block at hand of a warp needs; it executes if everything is there.
    fn begin<T, M: Memory>(&mut self, id: u8, context: &mut Context<'_, T, M>) {
        let warp = &mut self.warps[usize::from(id)];
        let mut reads = std::mem::take(&mut self.reads);
        reads.clear();
        let (code, asked) = match &warp.task {
            Task::Rays(block) => {
                warp.data(*block, context.layout, &mut reads);
                let active = warp.lanes.iter().filter(|lane| is_in(lane, *block)).count() as u64;
                (self.program.code(*block), self.program.block(*block, active))
            }
            Task::Items(job) => {
                reads.extend_from_slice(&job.reads);
                (job.code, self.program.kernel(job.longest, job.operations, job.lanes.into()))
            }
            Task::None => unreachable!("an empty place has no block"),
        };
        warp.asked = Some(asked);
        // It waits until all are looked up: nothing may arrive in between.
        (warp.missing, warp.state) = (1, State::Waits(context.now));
        let Lines { first, last } = code;
        (first..=last).for_each(|line| self.look_up(Lookup { warp: id, line, region: Region::Code }, context));
        reads.iter().for_each(|&(line, region)| self.look_up(Lookup { warp: id, line, region }, context));
        self.reads = reads;
        self.arrived(context.now, id, context.events);
    }

    fn look_up<T, M: Memory>(&mut self, lookup: Lookup, context: &mut Context<'_, T, M>) {
        match self.access(lookup, context) {
            Access::Hit => return,
            Access::Miss | Access::Merged => {}
            Access::Rejected => {
                if self.refused.is_empty() {
                    context.events.push(context.now + 1, Event { processor: self.index, what: What::Retry });
                }
                self.refused.push_back(lookup);
            }
        }
        self.warps[usize::from(lookup.warp)].missing += 1;
    }

    fn access<T, M: Memory>(&mut self, lookup: Lookup, context: &mut Context<'_, T, M>) -> Access {
        let Lookup { warp, line, region } = lookup;
        let cache = if region == Region::Code { &mut self.code } else { &mut self.data };
        cache.access(context.now, line, region, warp, context.memory)
    }

    /// Tries refused lookups again.
    pub fn retry<T, M: Memory>(&mut self, context: &mut Context<'_, T, M>) {
        self.account(context.now);
        while let Some(&lookup) = self.refused.front() {
            match self.access(lookup, context) {
                Access::Rejected => {
                    context.events.push(context.now + 1, Event { processor: self.index, what: What::Retry });
                    return;
                }
                Access::Hit => self.arrived(context.now, lookup.warp, context.events),
                Access::Miss | Access::Merged => {}
            }
            self.refused.pop_front();
        }
    }

    /// All lines are there.
    fn execute(&mut self, now: TiCycle, id: u8, events: &mut Events) {
        let warp = &mut self.warps[usize::from(id)];
        let Some(asked) = warp.asked.take() else { return };
        if let State::Waits(since) = warp.state {
            self.counters.memory += now - since;
        }
        let alone = now + asked.cycles;
        let mut end = alone.0.max(self.issue.take(now.0, asked.instructions));
        for (unit, places) in self.units.iter_mut().zip(asked.places) {
            end = end.max(unit.take(now.0, places));
        }
        warp.state = State::Executes(now, alone, TiCycle(end));
        self.executing += 1;
        self.count(&asked);
        events.push(TiCycle(end), Event { processor: self.index, what: What::Done(id) });
    }

    fn count(&mut self, asked: &Asked) {
        let counters = &mut self.counters;
        counters.instructions += asked.instructions;
        counters.lane_instructions += asked.lane_instructions;
        counters.lanes_off += asked.instructions * u64::from(self.lanes) - asked.lane_instructions;
        let [add, multiply, compare, integer, special, words] = asked.operations;
        counters.add += add;
        counters.multiply += multiply;
        counters.compare += compare;
        counters.integer += integer;
        counters.special += special;
        counters.words += words;
    }

    /// The block of a warp is over.
    pub fn done<T: Tiles, M: Memory>(&mut self, id: u8, context: &mut Context<'_, T, M>) {
        self.account(context.now);
        self.executing -= 1;
        let warp = &mut self.warps[usize::from(id)];
        if let State::Executes(from, alone, end) = warp.state {
            self.counters.executing += alone - from;
            self.counters.units += end - alone;
        }
        let next = match &warp.task {
            Task::Rays(block) => {
                let block = *block;
                if block != BlockId::Ray {
                    for lane in warp.lanes.iter_mut().filter(|lane| is_in(lane, block)) {
                        lane.want.count(&mut self.events);
                        lane.go_on(&context.tiles.work(lane.ray.slot).ops, &mut self.events.leaves);
                    }
                }
                warp.block_after(block)
            }
            _ => None,
        };
        if let Some(block) = next {
            warp.task = Task::Rays(block);
            return self.begin(id, context);
        }
        match std::mem::replace(&mut warp.task, Task::None) {
            Task::Items(job) => context.jobs.push_back(job.tag),
            _ => {
                self.events.rays += warp.lanes.len() as u64;
                self.events.ray_cycles += warp.lanes.iter().map(|lane| context.now - lane.entered).sum::<u64>();
                context.rays.extend(warp.lanes.iter().map(|lane| lane.ray));
            }
        }
        warp.state = State::Empty;
        self.free.push(id);
    }

    /// Accounts for the cycles before `now`, in which nothing has changed.
    fn account(&mut self, now: TiCycle) {
        self.activity = self.activity_before(now);
        self.accounted = now;
    }

    fn activity_before(&self, now: TiCycle) -> Activity {
        let (mut activity, cycles) = (self.activity, now.since(self.accounted));
        *match () {
            () if self.executing > 0 => &mut activity.busy,
            () if self.free.len() < self.warps.len() => &mut activity.memory,
            () => &mut activity.idle,
        } += cycles;
        activity
    }

    /// Cycles in which a warp executed.
    pub fn busy(&self) -> u64 {
        self.activity.busy
    }

    /// Node visits and triangle tests that are done.
    pub fn work_done(&self) -> (u64, u64) {
        (self.events.node_visits, self.events.triangle_tests)
    }

    /// What the data cache holds.
    pub fn tags(&self) -> &Tags {
        self.data.tags()
    }

    /// Fills the empty caches: the data cache with `data`, the instruction cache with the traversal.
    pub fn warm(&mut self, data: &Tags) {
        self.data.warm(data);
        let mut code = self.code.tags().clone();
        for block in [BlockId::Ray, BlockId::Visit, BlockId::Triangle, BlockId::Pop] {
            self.program.code(block).each(|line| {
                if !code.touch(line) {
                    code.insert(line);
                }
            });
        }
        self.code.warm(&code);
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.data.invalidate(line);
        self.code.invalidate(line);
    }

    /// What was counted before cycle `end`, as a traversal unit counts it.
    pub fn report(&self, end: TiCycle) -> TrvStats {
        let stages = stage_names(crate::config::Pipeline::Software);
        TrvStats {
            stages: stages.iter().map(|name| (*name, self.activity_before(end))).collect(),
            events: self.events,
            l1: *self.data.counters(),
            ..TrvStats::default()
        }
    }

    /// Instructions and warps before cycle `end`.
    pub fn processor_report(&self, end: TiCycle) -> ProcessorStats {
        let mut counters = self.counters;
        for warp in &self.warps {
            match warp.state {
                State::Empty => {}
                State::Waits(since) => counters.memory += end.since(since),
                State::Executes(from, alone, _) => {
                    counters.executing += end.min(alone).since(from);
                    counters.units += end.since(alone);
                }
            }
        }
        let all = self.warps.len() as u64 * end.0;
        counters.empty = all - counters.executing - counters.units - counters.memory;
        ProcessorStats { counters, code_l1: *self.code.counters() }
    }
}
