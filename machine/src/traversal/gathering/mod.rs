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
use crate::ti::{TiContext, TiStats, Tiles, stage_names};
use crate::time::{TiCycle, When};
use crate::traversal::buffer::RayBuffer;
use crate::work::cost;

/// The units of a core.
#[derive(Debug)]
pub struct GatherUnit {
    buffer: RayBuffer,
    units: Vec<Gatherer>,
    first_port: u16,
    finished: VecDeque<RayRef>,
}

impl GatherUnit {
    /// The units of a core. Their L1s take the ports from `first_port` on, [`GatherUnit::ports`] of them.
    pub fn new(config: &MachineConfig, first_port: Port) -> Self {
        let port = |i: u32| Port(first_port.0 + i as u16);
        Self {
            buffer: RayBuffer::new(config.ti.ray_fifo_entries),
            units: (0..config.ti.trv).map(|i| Gatherer::new(config, port(i))).collect(),
            first_port: first_port.0,
            finished: VecDeque::new(),
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
        format!("{}, free places of gathering units {free:?}", self.buffer.describe())
    }

    /// The work that is done, as [`cost`] counts it.
    pub(crate) fn done(&self) -> f64 {
        let sum = |sum: (u64, u64), unit: &Gatherer| (sum.0 + unit.work_done().0, sum.1 + unit.work_done().1);
        let (visits, tests) = self.units.iter().fold((0, 0), sum);
        cost(visits, tests, self.buffer.rays())
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> TiStats {
        TiStats {
            dispatch: self.buffer.counters_before(end, self.most_free().1),
            trv: self.units.iter().map(|unit| unit.report(end)).collect(),
            ist: Vec::new(),
        }
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
        if free > 0 {
            self.buffer.take(now, 1).for_each(|ray| self.units[unit].enter(now, ray, tiles));
        }
    }
}

impl Component for GatherUnit {
    type Report = TiStats;

    fn next_event(&self, now: TiCycle) -> When {
        let ray = if self.most_free().1 > 0 { self.buffer.taken_from(0).after(now) } else { When::NEVER };
        self.units.iter().map(|unit| unit.next_event(now)).fold(ray, When::min)
    }

    fn finish(&mut self, end: TiCycle) -> TiStats {
        self.report(end)
    }
}

impl<T: Tiles, M: Memory> Tick<TiContext<'_, T, M>> for GatherUnit {
    /// Runs cycle `now`, after the lines of this cycle were filled.
    fn tick(&mut self, now: TiCycle, TiContext { layout, tiles, memory, .. }: TiContext<'_, T, M>) {
        self.buffer.account(now, self.most_free().1);
        self.dispatch(now, tiles);
        for unit in &mut self.units {
            unit.tick(now, (layout, tiles, &mut *memory), &mut self.finished);
        }
        self.buffer.finish(now, &mut self.finished);
    }
}

impl RayUnit for GatherUnit {
    #[inline]
    fn has_room(&self) -> bool {
        self.buffer.has_room()
    }

    fn push(&mut self, now: TiCycle, ray: RayRef) {
        self.buffer.account(now, self.most_free().1);
        self.buffer.push(now, ray);
    }

    #[inline]
    fn results(&mut self) -> &mut VecDeque<RayMessage> {
        self.buffer.results()
    }

    #[inline]
    fn rays_inside(&self) -> usize {
        self.buffer.inside()
    }
}
