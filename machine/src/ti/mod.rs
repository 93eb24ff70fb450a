//! The traversal and intersection unit of a core: ray buffer, dispatcher, traversal units, crossbar, intersection units.
//!
//! ```text
//!          ray buffer -> dispatcher -> TRV 0..n  <=> crossbar <=> IST 0..m -> hits
//!                                       | L1                       | L1
//!                                       +------------ L2 ----------+
//! ```
//!
//! The dispatcher gives one ray a cycle to the traversal unit with most free places, the first of equals.

pub mod front;
pub mod ist;
pub mod ray;
pub mod stage;
pub mod trv;
pub mod wheel;

#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use self::ist::{Ist, IstStats, Tasks};
use self::trv::{Tick, Trv, TrvStats};
use self::wheel::{Event, Kind, Wheel};
use super::config::MachineConfig;
use super::counters::counters;
use super::link::{RayRef, RayUnit};
use super::memory::{Cycle, Memory, Port};
use super::timeline::Busy;
use super::work::TileWork;
use super::work::layout::Layout;
use super::work::topology::Topology;

/// Where a unit finds the tiles of its core.
pub trait Tiles {
    /// The work of the tile in slot `slot`.
    fn work(&self, slot: u8) -> &TileWork;
}

impl Tiles for Vec<TileWork> {
    fn work(&self, slot: u8) -> &TileWork {
        &self[slot as usize]
    }
}

/// What the units look things up in.
#[derive(Debug)]
pub struct Context<'a, T> {
    /// The tree.
    pub tree: &'a Topology,
    /// Addresses.
    pub layout: &'a Layout,
    /// The tiles of the core.
    pub tiles: &'a T,
}

counters! {
    /// What the ray buffer and the dispatcher did.
    pub struct DispatchCounters {
        rays: "rays", "rays dispatched to traversal units";
        full: "cycles", "cycles in which the ray buffer held a ray and no traversal unit had a free place";
        active: "cycles", "cycles in which at least one ray was in the T&I unit";
    }
}

/// What a T&I unit reports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TiStats {
    /// Dispatcher.
    pub dispatch: DispatchCounters,
    /// Traversal units.
    pub trv: Vec<TrvStats>,
    /// Intersection units.
    pub ist: Vec<IstStats>,
}

/// See the module.
#[derive(Debug)]
pub struct TiUnit {
    entries: usize,
    fifo: VecDeque<(Cycle, RayRef)>,
    trv: Vec<Trv>,
    ist: Vec<Ist>,
    tasks: Tasks,
    first_port: u16,
    results: VecDeque<(Cycle, RayRef)>,
    inside: usize,
    wheel: Wheel,
    /// Cycles before this one are in the counters.
    accounted: Cycle,
    counters: DispatchCounters,
    done: Vec<RayRef>,
    events: Vec<Event>,
}

/// How far ahead a unit books events: its deepest pipeline, and one operation of every ray before it.
fn reach(config: &MachineConfig) -> u32 {
    let ti = &config.ti;
    let depth = ti.inner_cycles + ti.leaf_cycles + ti.stack_cycles + ti.ist_cycles + ti.setup_cycles;
    let rays = ti.trv * ti.rays_per_trv + ti.ist_entries;
    depth + ti.crossbar_cycles + ti.trv_l1.latency_cycles + ti.ist_l1.latency_cycles + 2 * rays
}

/// Never.
const NEVER: Cycle = Cycle::MAX;

impl TiUnit {
    /// The unit of a core. Its L1s take the ports from `first_port` on: those of the traversal units, then those of the
    /// intersection units; [`TiUnit::ports`] of them.
    pub fn new(config: &MachineConfig, first_port: Port) -> Self {
        let ti = &config.ti;
        let port = |i: u32| Port(first_port.0 + i as u16);
        Self {
            entries: ti.ray_fifo_entries as usize,
            fifo: VecDeque::with_capacity(ti.ray_fifo_entries as usize),
            trv: (0..ti.trv).map(|i| Trv::new(config, i as u8, port(i))).collect(),
            ist: (0..ti.ist).map(|i| Ist::new(config, i as u8, port(ti.trv + i))).collect(),
            tasks: Tasks::new(config),
            first_port: first_port.0,
            results: VecDeque::new(),
            inside: 0,
            wheel: Wheel::new(reach(config)),
            accounted: 0,
            counters: DispatchCounters::default(),
            done: Vec::new(),
            events: Vec::new(),
        }
    }

    /// L1s, and so ports, of a unit.
    pub fn ports(config: &MachineConfig) -> u16 {
        (config.ti.trv + config.ti.ist) as u16
    }

    /// A line arrived at `port` in cycle `now`.
    pub fn fill(&mut self, now: Cycle, port: Port, line: u64) {
        self.wheel.advance(now);
        let unit = usize::from(port.0 - self.first_port);
        match unit.checked_sub(self.trv.len()) {
            None => self.trv[unit].fill(now, line, &mut self.wheel),
            Some(ist) => self.ist[ist].fill(now, line, &mut self.wheel),
        }
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.trv.iter_mut().for_each(|unit| unit.invalidate(line));
        self.ist.iter_mut().for_each(|unit| unit.invalidate(line));
    }

    /// Runs cycle `now`, after the lines of this cycle were filled.
    pub fn tick<M: Memory, T: Tiles>(&mut self, now: Cycle, context: &Context<'_, T>, memory: &mut M) {
        self.account(now);
        self.wheel.advance(now);
        self.dispatch(now, context);
        if self.wheel.next_event() <= now {
            self.handle(now, context, memory);
        }
        for ray in self.done.drain(..) {
            self.results.push_back((now, ray));
            self.inside -= 1;
        }
        while let Some((trv, slot, arrived, ist)) = self.tasks.grant() {
            self.trv[trv as usize].leaf_granted(now + 1, slot, arrived, ist, &mut self.wheel);
        }
    }

    /// The events of cycle `now`.
    fn handle<M: Memory, T: Tiles>(&mut self, now: Cycle, context: &Context<'_, T>, memory: &mut M) {
        let mut events = std::mem::take(&mut self.events);
        while self.wheel.take(now, &mut events) {
            let (tasks, wheel, done) = (&mut self.tasks, &mut self.wheel, &mut self.done);
            let mut tick = Tick { now, context, tasks, memory: &mut *memory, wheel, done };
            for &event in &events {
                let (unit, slot) = (event.unit as usize, event.slot);
                match event.kind {
                    Kind::Setup | Kind::Returned => self.trv[unit].go_on(slot, &mut tick),
                    Kind::Inner => self.trv[unit].passed(slot, &mut tick),
                    Kind::InnerBypass => self.trv[unit].again(slot, &mut tick),
                    Kind::Leaf => self.trv[unit].leaf_passed(slot, event.extra, &mut tick),
                    Kind::Stack => self.trv[unit].popped(slot, &mut tick),
                    Kind::LookUpAgain => self.trv[unit].look_up_again(event, &mut tick),
                    Kind::Task => self.ist[unit].accept(&mut tick),
                    Kind::NextTriangle => self.ist[unit].arrive(slot, &mut tick),
                    Kind::LastTriangle => self.ist[unit].finished(slot, &mut tick),
                    Kind::TriangleBypass => self.ist[unit].again(slot, &mut tick),
                    Kind::TriangleLookUpAgain => self.ist[unit].look_up_again(event, &mut tick),
                }
            }
        }
        self.events = events;
    }

    /// The next cycle after `now` at which something happens without a push or a fill from outside.
    pub fn next_event(&self, now: Cycle) -> Option<Cycle> {
        let mut next = self.wheel.next_event();
        if let Some(&(at, _)) = self.fifo.front()
            && self.trv.iter().any(|unit| unit.free() > 0)
        {
            next = next.min(at.max(now + 1));
        }
        (next != NEVER).then_some(next)
    }

    /// Closes the accounts of a run of `cycles` cycles.
    pub fn finish(&mut self, cycles: Cycle) -> TiStats {
        self.account(cycles);
        TiStats {
            dispatch: self.counters,
            trv: self.trv.iter_mut().map(|unit| unit.finish(cycles)).collect(),
            ist: self.ist.iter_mut().map(|unit| unit.finish(cycles)).collect(),
        }
    }

    /// Busy cycles of each issue stage so far, for a timeline.
    pub fn busy(&self, mut see: impl FnMut(Busy)) {
        for (index, unit) in self.trv.iter().enumerate() {
            unit.busy().for_each(|(stage, cycles)| see(Busy { unit: "TRV", index, stage, cycles }));
        }
        for (index, unit) in self.ist.iter().enumerate() {
            see(Busy { unit: "IST", index, stage: "", cycles: unit.busy() });
        }
    }

    /// What is inside, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        let rays: Vec<_> = self.trv.iter().map(Trv::rays).collect();
        format!("ray buffer {} of {}, rays in traversal units {rays:?}", self.fifo.len(), self.entries)
    }

    fn dispatch<T: Tiles>(&mut self, now: Cycle, context: &Context<'_, T>) {
        let Some(&(at, ray)) = self.fifo.front() else { return };
        if at > now {
            return;
        }
        let mut best = 0;
        for i in 1..self.trv.len() {
            if self.trv[i].free() > self.trv[best].free() {
                best = i;
            }
        }
        if self.trv[best].free() == 0 {
            return;
        }
        self.fifo.pop_front();
        self.trv[best].enter(now, ray, context.tiles, &mut self.wheel);
        self.counters.rays += 1;
    }

    /// Accounts the cycles before `now`, in which nothing has changed.
    fn account(&mut self, now: Cycle) {
        let gap = now - self.accounted;
        self.accounted = now;
        self.counters.active += if self.inside > 0 { gap } else { 0 };
        if !self.fifo.is_empty() && self.trv.iter().all(|unit| unit.free() == 0) {
            self.counters.full += gap;
        }
    }
}

impl RayUnit for TiUnit {
    fn has_room(&self) -> bool {
        self.fifo.len() < self.entries
    }

    fn push(&mut self, now: Cycle, ray: RayRef) {
        assert!(self.has_room(), "the ray buffer is full");
        self.account(now);
        self.fifo.push_back((now + 1, ray));
        self.inside += 1;
    }

    fn results(&mut self) -> &mut VecDeque<(Cycle, RayRef)> {
        &mut self.results
    }

    fn rays_inside(&self) -> usize {
        self.inside
    }
}
