//! The traversal and intersection unit of a core: ray buffer, dispatcher, traversal units, crossbar, intersection units.
//!
//! ```text
//!          ray buffer -> dispatcher -> TRV 0..n  <=> crossbar <=> IST 0..m -> hits
//!                                       | L1                       | L1
//!                                       +------------ L2 ----------+
//! ```
//!
//! The dispatcher gives one ray a cycle to the traversal unit with most free places, the first of equals.

mod context;
mod crossbar;
mod fetch_port;
mod input_buffer;
mod ist;
mod ray;
mod stage;
mod trv;
mod trv_stats;
mod wheel;

#[cfg(test)]
mod tests;

pub use context::{TiContext, Tiles};
pub use input_buffer::InputBufferCounters;
pub use ist::{IstCounters, IstStats};
pub(crate) use trv_stats::stage_names;
pub use trv_stats::{TrvCounters, TrvStats};

use std::collections::VecDeque;

use context::EventContext;
use crossbar::LeafCrossbar;
use ist::Ist;
use trv::{Step, Trv};
use wheel::{Event, EventKind, Wheel};

use crate::component::{Component, Tick};
use crate::config::MachineConfig;
use crate::counters::{StageBusy, counters};
use crate::link::{RayMessage, RayRef, RayUnit};
use crate::memory::{Memory, Port, Tags};
use crate::time::{TiCycle, When};
use crate::work::cost;
use crate::work::layout::Region;

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

/// The T&I unit of a core.
#[derive(Debug)]
pub struct TiUnit {
    /// Entries of the ray buffer, and the rays in it.
    entries: usize,
    ray_buffer: VecDeque<RayMessage>,
    trv: Vec<Trv>,
    ist: Vec<Ist>,
    crossbar: LeafCrossbar,
    first_port: u16,
    results: VecDeque<RayMessage>,
    inside: usize,
    /// Free places of all traversal units.
    places: usize,
    wheel: Wheel,
    /// Cycles before this one are in the counters.
    accounted: TiCycle,
    counters: DispatchCounters,
    done: Vec<RayRef>,
}

/// How far ahead a unit books events: its deepest pipeline, and one operation of every ray before it.
fn reach(config: &MachineConfig) -> u32 {
    let ti = &config.ti;
    let depth = ti.inner_cycles + ti.leaf_cycles + ti.stack_cycles + ti.ist_cycles + ti.setup_cycles;
    // What an operation takes of the data port of its L1, and a cycle of its stage.
    let lines = |bytes: u32| bytes.div_ceil(config.l2.line_bytes) + 1;
    let layout = &config.layout;
    let node = lines(layout.node_bytes.max(layout.triangle_bytes)).div_ceil(ti.trv_lines_per_cycle) + 1;
    let triangle = lines(layout.triangle_bytes).div_ceil(ti.ist_lines_per_cycle) + 1;
    let rays = ti.trv * ti.rays_per_trv * node + ti.ist_entries * triangle;
    depth + ti.crossbar_cycles + ti.trv_l1.latency_cycles + ti.ist_l1.latency_cycles + rays
}

impl TiUnit {
    /// The unit of a core. Its L1s take the ports from `first_port` on: those of the traversal units, then those of the
    /// intersection units; [`TiUnit::ports`] of them.
    pub fn new(config: &MachineConfig, first_port: Port) -> Self {
        let ti = &config.ti;
        let port = |i: u32| Port(first_port.0 + i as u16);
        Self {
            entries: ti.ray_fifo_entries as usize,
            ray_buffer: VecDeque::with_capacity(ti.ray_fifo_entries as usize),
            trv: (0..ti.trv).map(|i| Trv::new(config, i as u8, port(i))).collect(),
            ist: (0..ti.ist).map(|i| Ist::new(config, i as u8, port(ti.trv + i))).collect(),
            crossbar: LeafCrossbar::new(config),
            first_port: first_port.0,
            results: VecDeque::new(),
            inside: 0,
            places: (ti.trv * ti.rays_per_trv) as usize,
            wheel: Wheel::new(reach(config)),
            accounted: TiCycle::default(),
            counters: DispatchCounters::default(),
            done: Vec::new(),
        }
    }

    /// L1s, and so ports, of a unit.
    pub fn ports(config: &MachineConfig) -> u16 {
        (config.ti.trv + config.ti.ist) as u16
    }

    /// A line arrived at `port` in cycle `now`.
    pub fn fill(&mut self, now: TiCycle, port: Port, line: u64) {
        self.wheel.advance(now);
        let unit = usize::from(port.0 - self.first_port);
        match unit.checked_sub(self.trv.len()) {
            None => self.trv[unit].fill(now, line, &mut self.wheel),
            Some(ist) => self.ist[ist].fill(now, line, &mut self.wheel),
        }
    }

    /// Fills the empty L1s.
    pub(crate) fn warm(&mut self, trv: &[Tags], ist: &[Tags]) {
        self.trv.iter_mut().zip(trv).for_each(|(unit, tags)| unit.port.warm(tags));
        self.ist.iter_mut().zip(ist).for_each(|(unit, tags)| unit.port.warm(tags));
    }

    /// What the L1s hold: those of the traversal units, and those of the intersection units.
    pub(crate) fn tags(&self) -> [Vec<Tags>; 2] {
        [
            self.trv.iter().map(|unit| unit.port.tags().clone()).collect(),
            self.ist.iter().map(|unit| unit.port.tags().clone()).collect(),
        ]
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.trv.iter_mut().for_each(|unit| unit.invalidate(line));
        self.ist.iter_mut().for_each(|unit| unit.invalidate(line));
    }

    /// The events of cycle `now`.
    fn handle<T: Tiles, M: Memory>(&mut self, now: TiCycle, with: TiContext<'_, T, M>) {
        let TiContext { tree, layout, tiles, memory } = with;
        let (crossbar, wheel, done) = (&mut self.crossbar, &mut self.wheel, &mut self.done);
        let mut context = EventContext { now, tree, layout, tiles, memory, crossbar, wheel, done };
        while let Some(event) = context.wheel.take(now) {
            let (unit, slot) = (event.unit as usize, event.slot);
            let step = match event.kind {
                EventKind::Setup | EventKind::Returned => Step::Next,
                EventKind::Inner => self.trv[unit].inner_done(slot, &mut context),
                EventKind::Stack => self.trv[unit].stack_done(slot, &mut context),
                EventKind::Leaf => self.trv[unit].leaf_done(slot, event.extra, &mut context),
                _ => {
                    Self::handle_rarer(&mut self.trv, &mut self.ist, event, &mut context);
                    continue;
                }
            };
            self.trv[unit].go_on(step, slot, &mut context);
        }
    }

    /// Events that move no ray along.
    #[inline]
    fn handle_rarer<T: Tiles, M: Memory>(
        trv: &mut [Trv],
        ist: &mut [Ist],
        event: Event,
        context: &mut EventContext<'_, T, M>,
    ) {
        let (unit, slot) = (event.unit as usize, event.slot);
        match event.kind {
            EventKind::InnerBypass => trv[unit].retry(slot, context),
            EventKind::Task => {
                if let Some(slot) = ist[unit].accept(context) {
                    Self::next_triangle(trv, &mut ist[unit], slot, context);
                }
            }
            EventKind::NextTriangle => Self::next_triangle(trv, &mut ist[unit], slot, context),
            EventKind::LastTriangle => ist[unit].task_done(slot, context),
            EventKind::TriangleBypass => ist[unit].retry(slot, context),
            EventKind::RetryLookup => trv[unit].retry_lookup(event, context),
            EventKind::RetryTriangleLookup => ist[unit].retry_lookup(event, context),
            EventKind::Setup | EventKind::Returned | EventKind::Inner | EventKind::Stack | EventKind::Leaf => {}
        }
    }

    /// The next triangle of the task in `slot`.
    #[inline(always)]
    fn next_triangle<T: Tiles, M: Memory>(trv: &[Trv], ist: &mut Ist, slot: u8, context: &mut EventContext<'_, T, M>) {
        if M::LISTENS {
            let task = ist.task(slot);
            let ray = trv[task.trv as usize].ray(task.slot);
            context.tell(ist.port.l1_port(), ray, (Region::Triangle, task.triangle));
        }
        ist.fetch(slot, context);
    }

    /// Busy cycles of each issue stage so far, for a timeline.
    pub fn busy(&self, mut see: impl FnMut(StageBusy)) {
        for (index, unit) in self.trv.iter().enumerate() {
            unit.busy().for_each(|(stage, cycles)| see(StageBusy { unit: "TRV", index, stage, cycles }));
        }
        for (index, unit) in self.ist.iter().enumerate() {
            see(StageBusy { unit: "IST", index, stage: "", cycles: unit.busy() });
        }
    }

    /// What is inside, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        let rays: Vec<_> = self.trv.iter().map(Trv::rays).collect();
        format!("ray buffer {} of {}, rays in traversal units {rays:?}", self.ray_buffer.len(), self.entries)
    }

    /// Gives the first ray of the buffer to a traversal unit.
    fn dispatch<T: Tiles>(&mut self, now: TiCycle, tiles: &T) {
        let Some(&RayMessage { at, ray }) = self.ray_buffer.front() else { return };
        if at > now || self.places == 0 {
            return;
        }
        let mut best = 0;
        for i in 1..self.trv.len() {
            if self.trv[i].free() > self.trv[best].free() {
                best = i;
            }
        }
        self.ray_buffer.pop_front();
        self.places -= 1;
        self.trv[best].enter(now, ray, tiles, &mut self.wheel);
        self.counters.rays += 1;
    }

    /// Accounts the cycles before `now`, in which nothing has changed.
    fn account(&mut self, now: TiCycle) {
        self.counters = self.counters_before(now);
        self.accounted = now;
    }

    /// The counters with the cycles before `now`, in which nothing has changed.
    fn counters_before(&self, now: TiCycle) -> DispatchCounters {
        let (mut counters, gap) = (self.counters, now - self.accounted);
        counters.active += if self.inside > 0 { gap } else { 0 };
        if !self.ray_buffer.is_empty() && self.places == 0 {
            counters.full += gap;
        }
        counters
    }

    /// The work that is done, as [`cost`] counts it.
    pub(crate) fn done(&self) -> f64 {
        let (visits, tests) = self.trv.iter().map(Trv::done).fold((0, 0), |sum, unit| (sum.0 + unit.0, sum.1 + unit.1));
        let tests = tests + self.ist.iter().map(Ist::tests).sum::<u64>();
        cost(visits, tests, self.counters.rays)
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> TiStats {
        TiStats {
            dispatch: self.counters_before(end),
            trv: self.trv.iter().map(|unit| unit.report(end)).collect(),
            ist: self.ist.iter().map(|unit| unit.report(end)).collect(),
        }
    }
}

impl Component for TiUnit {
    type Report = TiStats;

    #[inline]
    fn next_event(&self, now: TiCycle) -> When {
        let next = self.wheel.next_event();
        match self.ray_buffer.front() {
            Some(&RayMessage { at, .. }) if self.places > 0 => next.min(When::at(at).after(now)),
            _ => next,
        }
    }

    fn finish(&mut self, end: TiCycle) -> TiStats {
        self.report(end)
    }
}

impl<T: Tiles, M: Memory> Tick<TiContext<'_, T, M>> for TiUnit {
    /// Runs cycle `now`, after the lines of this cycle were filled.
    fn tick(&mut self, now: TiCycle, context: TiContext<'_, T, M>) {
        self.account(now);
        self.wheel.advance(now);
        self.dispatch(now, context.tiles);
        self.handle(now, context);
        for ray in self.done.drain(..) {
            self.results.push_back(RayMessage { at: now, ray });
            self.inside -= 1;
            self.places += 1;
        }
        while let Some(grant) = self.crossbar.grant() {
            self.trv[grant.request.trv as usize].leaf_granted(now + 1, grant, &mut self.wheel);
        }
    }
}

impl RayUnit for TiUnit {
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
