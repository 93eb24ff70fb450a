//! The programmable shader of a core (SRP): its kernels, tile slots, DMA engines, and its side of the way to the T&I unit.
//!
//! ```text
//!            give_tile                    rays (direct link, or through memory)
//! dispatcher ---------> tile slots  ---------------------------------------------> T&I unit
//!                        | queues         output queue (32 rays)                       |
//!                        v                     ^                                       |
//!                       array: one batch ------+   hits: shade, miss, update items     |
//!                        ^        at a time     <--------------------------------------+
//!              L1 gather, tile buffer, DMA <-> memory
//! ```
//!
//! Rules stand in the modules: `kernels` (batch timing), `batch` (what runs next, output), `tile` (waves), `interface`, `stream`,
//! `raster`, `gather`, `local`, `dma`. SRP time is counted in SRP cycles and meets the T&I clock through the exact ratio of both
//! (`clock`): what is complete at an SRP cycle is seen at the first T&I cycle that does not begin before it.
//!
//! A hit becomes an item in the cycle in which it reaches the SRP; the item may be part of a batch that begins in that cycle.
//!
//! `srp.ideal`: items take no time. A hit's rays are in the output queue in the cycle of the hit, the direct link takes no time,
//! and rays enter the unit as soon as it has room; `raygen` fills the output queue up to 32 rays. Reads of `shade` are made but
//! not waited for. Transfers of tiles and an interface through memory take their time.
//!
//! The owner calls [`Srp::tick`] at least at the cycles that [`Srp::next_event`] names and at every cycle at which the T&I unit or
//! the memory did something (memory responses and the unit's own tick come first). Calls at other cycles change nothing.

mod batch;
mod clock;
mod dma;
mod gather;
mod interface;
mod kernels;
mod local;
mod queues;
mod raster;
mod stats;
mod stream;
#[cfg(test)]
mod tests;
mod tile;

use std::collections::VecDeque;

use self::batch::{Around, Batch, Choosing, Progress, choose, sent_ray, taker};
use self::clock::Clock;
use self::dma::Dma;
use self::gather::Gather;
use self::interface::{Interface, earliest};
use self::kernels::Costs;
use self::local::TileBuffer;
use self::raster::Raster;
use self::tile::{Outside, Slot};

pub use self::batch::OUTPUT_RAYS;
pub use self::interface::UNWRITTEN_LINES;
pub use self::kernels::{KernelId, Needs, missing_kernels};
pub use self::stats::{DmaCounters, InterfaceCounters, KernelCounters, LocalCounters, SrpActivity, SrpStats};
pub use self::stream::FLUSH_CYCLES;
use super::config::{MachineConfig, PrimaryVisibility};
use super::link::{RayRef, RayUnit};
use super::memory::l1::L1Cache;
use super::memory::{Cycle, Memory, Port, Response};
use super::work::TileWork;
use super::work::layout::Layout;

/// Memory ports of an SRP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SrpPorts {
    /// Of its L1.
    pub l1: Port,
    /// Of its DMA engine and streams.
    pub dma: Port,
}

/// The framebuffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameShape {
    /// Width of the frame in pixels.
    pub width_pixels: u32,
    /// Samples of a pixel in a row, and in a column.
    pub samples_per_axis: u32,
    /// Bytes a pixel (`layout.pixel_bytes`).
    pub pixel_bytes: u32,
}

/// What the array does while it runs no batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Gap {
    Idle,
    Unit,
    Transfer,
}

/// The SRP of a core.
pub struct Srp {
    clock: Clock,
    costs: Costs,
    layout: Layout,
    shape: FrameShape,
    core: u32,
    ports: SrpPorts,
    ideal: bool,
    batch_min: usize,
    batch_max: usize,
    low_rays: usize,
    slots: Vec<Slot>,
    tiles_given: u64,
    batch: Batch,
    running: Option<Progress>,
    output: VecDeque<RayRef>,
    rays_out: usize,
    gather: Gather,
    dma: Dma,
    interface: Interface,
    raster: Option<Raster>,
    buffer: TileBuffer,
    stats: SrpStats,
    accounted: u64,
    gap: Gap,
    next: Option<Cycle>,
    waits: bool,
    /// Rays of the queue that is worked on, kept for its memory (`srp.ideal`).
    scratch: Vec<u32>,
}

impl Srp {
    /// The SRP of core `core`, without a tile.
    pub fn new(config: &MachineConfig, layout: Layout, core: u32, ports: SrpPorts, shape: FrameShape) -> Self {
        let clock = Clock::new(config);
        let slots = config.gpu.tiles_in_flight.clamp(1, 255) as usize;
        Self {
            clock,
            costs: Costs::new(config),
            layout,
            shape,
            core,
            ports,
            ideal: config.srp.ideal,
            batch_min: config.srp.batch_min.max(1) as usize,
            batch_max: config.srp.batch_max.max(1) as usize,
            low_rays: (config.ti.ray_fifo_entries + config.ti.trv * config.ti.rays_per_trv).div_ceil(2) as usize,
            slots: vec![Slot::new(); slots],
            tiles_given: 0,
            batch: Batch::none(),
            running: None,
            output: VecDeque::new(),
            rays_out: 0,
            gather: Gather::new(config, layout, clock, ports.l1),
            dma: Dma::new(ports.dma, config.l2.line_bytes.into(), slots),
            interface: Interface::new(config, core, ports),
            raster: (config.gpu.primary_visibility == PrimaryVisibility::Raster)
                .then(|| Raster::new(config, core, ports)),
            buffer: TileBuffer::new(config),
            stats: SrpStats::default(),
            accounted: 0,
            gap: Gap::Idle,
            next: None,
            waits: false,
            scratch: Vec::new(),
        }
    }

    /// Whether a tile slot is free.
    pub fn wants_tile(&self) -> bool {
        self.slots.iter().any(Slot::is_free)
    }

    /// Puts a tile into the first free slot; it begins at the tick of cycle `now`.
    ///
    /// # Panics
    /// When no slot is free.
    pub fn give_tile(&mut self, now: Cycle, work: TileWork) {
        self.close_gap(now);
        let free = self.slots.iter().position(Slot::is_free);
        let id = free.expect("a tile is given only to an SRP that wants one");
        self.tiles_given += 1;
        let age = self.tiles_given;
        self.with_slot(id, |slot, outside| slot.give(id as u8, age, work, outside));
        self.next = earliest(self.next, Some(now));
    }

    /// The tile of a slot. What it held stays readable until the slot is given another.
    #[inline]
    pub fn work(&self, slot: u8) -> &TileWork {
        &self.slots[slot as usize].work
    }

    /// Does what is due at T&I cycle `now`.
    #[inline]
    pub fn tick<U: RayUnit, M: Memory>(&mut self, now: Cycle, unit: &mut U, memory: &mut M) {
        let freed = self.waits || (self.interface.blocked() && unit.has_room());
        let due = freed || self.next.is_some_and(|at| at <= now);
        if due || unit.results().front().is_some_and(|(at, _)| *at <= now) {
            self.run(now, unit, memory);
        }
    }

    /// A line for one of the ports arrived. To be followed by a tick at the same cycle.
    pub fn respond(&mut self, now: Cycle, response: Response) {
        if response.port == self.ports.l1 {
            self.gather.fill(now, response.line);
        } else if !self.interface.respond(response.line)
            && !self.raster.as_mut().is_some_and(|r| r.respond(response.line))
        {
            self.dma.respond(response.line);
        }
        self.next = earliest(self.next, Some(now));
    }

    /// The next T&I cycle at which something happens by itself. `None`: it waits for the unit, the memory or a tile.
    pub fn next_event(&self) -> Option<Cycle> {
        self.next
    }

    /// Whether it waits for room in the unit or in the memory: to be ticked whenever something happens.
    #[inline]
    pub fn waits(&self) -> bool {
        self.waits || self.interface.blocked()
    }

    /// Whether no slot has a tile and nothing is under way.
    pub fn is_done(&self) -> bool {
        self.running.is_none() && self.slots.iter().all(Slot::is_free) && self.dma.is_idle() && self.gather.is_idle()
    }

    /// Closes the accounts at the end of the run, cycle `now`: the activity then adds up to the SRP cycles that have begun.
    pub fn finish(&mut self, now: Cycle) {
        self.close_gap(now);
    }

    /// SRP cycles that begin before T&I cycle `now`: the sum of all activities after [`Srp::finish`].
    pub fn cycles(&self, now: Cycle) -> u64 {
        self.clock.srp(now)
    }

    /// What is under way, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        let tiles = self.slots.iter().filter(|slot| !slot.is_free()).count();
        let batch = if self.running.is_some() { "a batch" } else { "no batch" };
        let reads = self.gather.describe();
        let next = self.next;
        format!(
            "tiles {tiles}, rays out {}, output queue {}, {batch}, {reads}, next event {next:?}",
            self.rays_out,
            self.output.len()
        )
    }

    /// All counters but those of the L1.
    pub fn stats(&self) -> &SrpStats {
        &self.stats
    }

    /// The L1, for its counters.
    pub fn l1(&self) -> &L1Cache {
        self.gather.l1()
    }

    /// The L1, to drop lines that left an inclusive L2.
    pub fn l1_mut(&mut self) -> &mut L1Cache {
        self.gather.l1_mut()
    }

    fn run<U: RayUnit, M: Memory>(&mut self, now: Cycle, unit: &mut U, memory: &mut M) {
        self.close_gap(now);
        self.gather.tick(now, memory);
        self.interface.collect(now, unit, memory, (&mut self.stats.interface, &mut self.stats.dma));
        self.take_hits(now);
        if let Some(raster) = &mut self.raster {
            raster.tick(now, memory, &mut self.stats.dma);
        }
        self.interface.enter(now, unit);
        loop {
            let sent = self.interface.send(now, &mut self.output, unit, &mut self.stats.interface);
            let worked = if self.ideal { self.work_ideally() } else { self.work_array(now) };
            // A batch that has just begun reads in this cycle already, and what hits may be all it waits for.
            let read = self.gather.tick(now, memory);
            if !sent && !worked && !read {
                break;
            }
        }
        self.dma.tick(now, memory, &mut self.stats.dma);
        self.plan(now, unit);
    }

    fn take_hits(&mut self, now: Cycle) {
        while let Some(ray) = self.interface.take_hit(now) {
            self.rays_out -= 1;
            self.add_item(ray);
        }
        while let Some(ray) = self.raster.as_mut().and_then(|r| r.take(now)) {
            self.add_item(ray);
        }
    }

    /// A ray came back: its item. One pending ray less, one pending item more.
    #[inline]
    fn add_item(&mut self, RayRef { slot, ray }: RayRef) {
        let slot = &mut self.slots[slot as usize];
        let own = &slot.work.rays[ray as usize];
        slot.rays_out -= 1;
        let kernel = taker(own);
        match kernel {
            KernelId::Shade => slot.queues.push_shade(if self.costs.sorts() { own.material } else { 0 }, ray),
            _ => slot.queues.push_ray(kernel, ray),
        }
        let primary = own.kind == rayreel_formats::tile::RayKind::Primary;
        self.buffer.count(kernel, primary, 1, &mut self.stats.local);
    }

    /// Runs the array up to `now`. Returns whether it did something.
    fn work_array(&mut self, now: Cycle) -> bool {
        let mut worked = self.advance_tiles();
        loop {
            if let Some(progress) = self.running {
                let early = matches!(progress, Progress::At(at) if at > now);
                if early || !self.go_on(now, &mut worked) {
                    return worked;
                }
                self.advance_tiles();
            }
            let choosing = Choosing {
                batch_min: self.batch_min,
                low: self.rays_out < self.low_rays,
                output_full: self.output.len() > OUTPUT_RAYS / 2,
            };
            let Some(choice) = choose(&self.slots, choosing) else { return worked };
            let slot = &mut self.slots[choice.slot as usize];
            self.batch.begin(self.accounted, choice, self.batch_max, slot, &self.costs, &mut self.gather);
            self.stats.kernels[self.batch.kernel as usize].batches += 1;
            self.running = Some(Progress::Reads);
            worked = true;
        }
    }

    /// Runs the batch up to `now`. Returns whether it ended.
    fn go_on(&mut self, now: Cycle, worked: &mut bool) -> bool {
        let slot = &mut self.slots[self.batch.slot as usize];
        let mut around = Around {
            clock: self.clock,
            costs: &self.costs,
            slot,
            gather: &self.gather,
            output: &mut self.output,
            rays_out: &mut self.rays_out,
            stats: &mut self.stats,
        };
        let before = around.output.len();
        let progress = self.batch.progress(now, &mut around);
        *worked |= before != self.output.len() || progress == Progress::Ended;
        self.accounted = self.batch.at();
        self.running = (progress != Progress::Ended).then_some(progress);
        progress == Progress::Ended
    }

    /// All items at once, without time. Returns whether something was done.
    fn work_ideally(&mut self) -> bool {
        let mut worked = self.advance_tiles();
        for id in 0..self.slots.len() {
            loop {
                let room = OUTPUT_RAYS.saturating_sub(self.output.len());
                let mut queue = None;
                self.slots[id].queues.each(|q, _| {
                    // Rays of hits go first: primaries fill what is left.
                    if queue.is_none_or(|(k, _)| k == KernelId::Raygen) && (q.kernel != KernelId::Raygen || room > 0) {
                        queue = Some((q.kernel, q));
                    }
                });
                let Some((kernel, queue)) = queue else { break };
                let most = if kernel == KernelId::Raygen { room } else { usize::MAX };
                self.run_ideally(id, kernel, queue, most);
                worked = true;
            }
        }
        worked | self.advance_tiles()
    }

    fn run_ideally(&mut self, id: usize, kernel: KernelId, queue: queues::QueueId, most: usize) {
        let mut rays = std::mem::take(&mut self.scratch);
        rays.clear();
        let slot = &mut self.slots[id];
        let items = slot.queues.take(queue, most, &mut rays);
        let counters = &mut self.stats.kernels[kernel as usize];
        counters.batches += 1;
        counters.items += items as u64;
        slot.pending -= items as u32;
        if rays.is_empty() {
            counters.ops += items as u64 * self.costs.ops(kernel, 0);
        }
        for &ray in &rays {
            let own = &slot.work.rays[ray as usize];
            counters.ops += self.costs.ops(kernel, if kernel == KernelId::Shade { own.shadows } else { 0 });
            if kernel == KernelId::Shade {
                self.gather.add(0, own);
            }
            let mut sent = 0;
            while let Some(child) = sent_ray(kernel, &slot.work, ray, sent) {
                self.output.push_back(RayRef { slot: id as u8, ray: child });
                sent += 1;
            }
            (slot.pending, slot.rays_out) = (slot.pending + sent, slot.rays_out + sent);
            self.rays_out += sent as usize;
        }
        self.scratch = rays;
    }

    fn advance_tiles(&mut self) -> bool {
        let mut any = false;
        for id in 0..self.slots.len() {
            if self.slots[id].is_free() || self.slots[id].pending > 0 {
                continue;
            }
            while self.with_slot(id, |slot, outside| slot.advance(id as u8, outside)) {
                any = true;
            }
        }
        any
    }

    fn with_slot<R>(&mut self, id: usize, act: impl FnOnce(&mut Slot, &mut Outside<'_>) -> R) -> R {
        let mut outside = Outside {
            dma: &mut self.dma,
            raster: self.raster.as_mut(),
            buffer: &self.buffer,
            layout: self.layout,
            shape: self.shape,
            core: self.core,
            counters: &mut self.stats.local,
        };
        act(&mut self.slots[id], &mut outside)
    }

    /// Accounts for the SRP cycles before `now` in which the array had no batch.
    fn close_gap(&mut self, now: Cycle) {
        let until = self.clock.srp(now);
        if self.running.is_some() || until <= self.accounted {
            return;
        }
        let cycles = until - self.accounted;
        *match self.gap {
            Gap::Idle => &mut self.stats.activity.idle,
            Gap::Unit => &mut self.stats.activity.unit,
            Gap::Transfer => &mut self.stats.activity.transfer,
        } += cycles;
        self.accounted = until;
    }

    /// What the next cycles are, and when something happens again.
    fn plan<U: RayUnit>(&mut self, now: Cycle, unit: &mut U) {
        self.gap = match () {
            () if self.rays_out > 0 => Gap::Unit,
            () if self.slots.iter().all(Slot::is_free) => Gap::Idle,
            () => Gap::Transfer,
        };
        let mut next = self.interface.next_event(now, !self.output.is_empty());
        if let Some(Progress::At(at)) = self.running {
            next = earliest(next, Some(at));
        }
        next = earliest(next, self.gather.next_event(now));
        next = earliest(next, self.dma.next_event(now));
        if let Some(raster) = &self.raster {
            next = earliest(next, raster.next_event(now));
        }
        // A tile whose last write was accepted in this very tick goes on in the next cycle.
        let step = |(id, s): (usize, &Slot)| !s.is_free() && s.pending == 0 && self.dma.pending(id as u8) == 0;
        if self.slots.iter().enumerate().any(step) {
            next = Some(now + 1);
        }
        let result = unit.results().front().map(|(at, _)| (*at).max(now + 1));
        self.next = earliest(next, result);
        self.waits = self.interface.waits()
            || self.gather.refused()
            || self.dma.refused()
            || self.raster.as_ref().is_some_and(Raster::waits);
    }
}
