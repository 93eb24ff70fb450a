//! A T&I unit that gathers coherent rays (`ti.pipeline = "gathering"`), after PowerVR's Wizard: rays wait for others that need the
//! same node or triangle, and are tested against it together, with one read of it.
//!
//! The dispatcher gives a ray a cycle to the unit with most free places, the first of equals.

mod gatherer;
mod queues;

use std::collections::VecDeque;

use gatherer::Gatherer;

use crate::component::{Component, Tick};
use crate::config::{MachineConfig, Pipeline};
use crate::counters::StageBusy;
use crate::link::{RayMessage, RayRef, RayUnit};
use crate::memory::{Memory, Port, Tags};
use crate::ti::{DispatchCounters, TiContext, TiStats, Tiles, stage_names};
use crate::time::{TiCycle, When};
use crate::work::cost;

/// The units of a core.
#[derive(Debug)]
pub struct GatherUnit {
    entries: usize,
    ray_buffer: VecDeque<RayMessage>,
    units: Vec<Gatherer>,
    first_port: u16,
    finished: VecDeque<RayRef>,
    results: VecDeque<RayMessage>,
    inside: usize,
    accounted: TiCycle,
    counters: DispatchCounters,
}

impl GatherUnit {
    /// The units of a core. Their L1s take the ports from `first_port` on, [`GatherUnit::ports`] of them.
    pub fn new(config: &MachineConfig, first_port: Port) -> Self {
        let port = |i: u32| Port(first_port.0 + i as u16);
        Self {
            entries: config.ti.ray_fifo_entries as usize,
            ray_buffer: VecDeque::new(),
            units: (0..config.ti.trv).map(|i| Gatherer::new(config, port(i))).collect(),
            first_port: first_port.0,
            finished: VecDeque::new(),
            results: VecDeque::new(),
            inside: 0,
            accounted: TiCycle::default(),
            counters: DispatchCounters::default(),
        }
    }

    /// L1s, and so ports, of a core.
    pub fn ports(config: &MachineConfig) -> u16 {
        config.ti.trv as u16
    }

    /// A line arrived at `port` in cycle `now`.
    pub fn fill(&mut self, now: TiCycle, port: Port, line: u64) {
        self.units[usize::from(port.0 - self.first_port)].fill(now, line);
    }

    /// Fills the empty L1s.
    pub(crate) fn warm(&mut self, tags: &[Tags]) {
        self.units.iter_mut().zip(tags).for_each(|(unit, tags)| unit.warm(tags));
    }

    /// What the L1s hold.
    pub(crate) fn tags(&self) -> Vec<Tags> {
        self.units.iter().map(|unit| unit.tags().clone()).collect()
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.units.iter_mut().for_each(|unit| unit.invalidate(line));
    }

    /// Busy cycles of each stage so far, for a timeline.
    pub fn busy(&self, mut see: impl FnMut(StageBusy)) {
        for (index, unit) in self.units.iter().enumerate() {
            let stages = stage_names(Pipeline::Gathering).iter().zip(unit.busy());
            stages.for_each(|(stage, cycles)| see(StageBusy { unit: "TRV", index, stage, cycles }));
        }
    }

    /// What is inside, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        let free: Vec<_> = self.units.iter().map(Gatherer::free).collect();
        format!("ray buffer {} of {}, free places of gathering units {free:?}", self.ray_buffer.len(), self.entries)
    }

    /// The work that is done, as [`cost`] counts it.
    pub(crate) fn done(&self) -> f64 {
        let sum = |sum: (u64, u64), unit: &Gatherer| (sum.0 + unit.work_done().0, sum.1 + unit.work_done().1);
        let (visits, tests) = self.units.iter().fold((0, 0), sum);
        cost(visits, tests, self.counters.rays)
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> TiStats {
        TiStats {
            dispatch: self.counters_before(end),
            trv: self.units.iter().map(|unit| unit.report(end)).collect(),
            ist: Vec::new(),
        }
    }

    fn account(&mut self, now: TiCycle) {
        self.counters = self.counters_before(now);
        self.accounted = now;
    }

    fn counters_before(&self, now: TiCycle) -> DispatchCounters {
        let (mut counters, gap) = (self.counters, now.since(self.accounted));
        counters.active += if self.inside > 0 { gap } else { 0 };
        counters.full += if !self.ray_buffer.is_empty() && self.most_free().1 == 0 { gap } else { 0 };
        counters
    }

    /// The first unit with most free places, and how many.
    fn most_free(&self) -> (usize, usize) {
        let first = |best: (usize, usize), (i, unit): (usize, &Gatherer)| {
            if unit.free() > best.1 { (i, unit.free()) } else { best }
        };
        self.units.iter().enumerate().fold((0, 0), first)
    }

    fn dispatch<T: Tiles>(&mut self, now: TiCycle, tiles: &T) {
        let (unit, free) = self.most_free();
        if free > 0
            && self.ray_buffer.front().is_some_and(|ray| ray.at <= now)
            && let Some(RayMessage { ray, .. }) = self.ray_buffer.pop_front()
        {
            self.counters.rays += 1;
            self.units[unit].enter(now, ray, tiles);
        }
    }
}

impl Component for GatherUnit {
    type Report = TiStats;

    fn next_event(&self, now: TiCycle) -> When {
        let ray = When::from(self.ray_buffer.front().filter(|_| self.most_free().1 > 0).map(|ray| ray.at)).after(now);
        self.units.iter().map(|unit| unit.next_event(now)).fold(ray, When::min)
    }

    fn finish(&mut self, end: TiCycle) -> TiStats {
        self.report(end)
    }
}

impl<T: Tiles, M: Memory> Tick<TiContext<'_, T, M>> for GatherUnit {
    /// Runs cycle `now`, after the lines of this cycle were filled.
    fn tick(&mut self, now: TiCycle, TiContext { layout, tiles, memory, .. }: TiContext<'_, T, M>) {
        self.account(now);
        self.dispatch(now, tiles);
        for unit in &mut self.units {
            unit.tick(now, (layout, tiles, &mut *memory), &mut self.finished);
        }
        self.inside -= self.finished.len();
        self.results.extend(self.finished.drain(..).map(|ray| RayMessage { at: now, ray }));
    }
}

impl RayUnit for GatherUnit {
    #[inline]
    fn has_room(&self) -> bool {
        self.ray_buffer.len() < self.entries
    }

    fn push(&mut self, now: TiCycle, ray: RayRef) {
        assert!(self.has_room(), "the ray buffer is full");
        self.account(now);
        self.ray_buffer.push_back(RayMessage { at: now + 1, ray });
        self.inside += 1;
    }

    #[inline]
    fn results(&mut self) -> &mut VecDeque<RayMessage> {
        &mut self.results
    }

    #[inline]
    fn rays_inside(&self) -> usize {
        self.inside
    }
}
