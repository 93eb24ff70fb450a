//! The programmable shader of a core (SRP): its kernels, tile slots, DMA engines, and its side of the way to the T&I unit.
//!
//! ```text
//!            give_tile                    rays (direct link, or through memory)
//! dispatcher ---------> tile slots  ---------------------------------------------> T&I unit
//!                        | queues         output queue                                |
//!                        v                     ^                                       |
//!                       array: one batch ------+   hits: shade, miss, update items     |
//!                        ^        at a time     <--------------------------------------+
//!              L1 gather, tile buffer, DMA <-> memory
//! ```
//!
//! An SRP has three parts: the `array` runs kernels (`kernels`: batch timing, `batch`: what runs next, `gather`: reads), the
//! `slots` hold tiles (`tile`: rounds, `local`: the tile buffer), and `transfers` move data (`interface`, `dma`, `raster`, and
//! the `stream` that two of them use). Each module states its rules. SRP time is counted in SRP cycles and meets the T&I clock through the exact ratio of both
//! (`clock`): what is complete at an SRP cycle is seen at the first T&I cycle that does not begin before it.
//!
//! A hit becomes an item in the cycle in which it reaches the SRP; the item may be part of a batch that begins in that cycle.
//!
//! `srp.ideal`: items take no time. A hit's rays are in the output queue in the cycle of the hit, the direct link takes no time,
//! and rays enter the unit as soon as it has room; `raygen` fills the output queue. Reads of `shade` are made but not
//! waited for. Transfers of tiles and an interface through memory take their time.
//!
//! The owner ticks it at least at the cycles that its next event names and at every cycle at which the T&I unit or the memory
//! did something, after the memory's responses. Ticks at other cycles change nothing.

mod array;
mod batch;
mod clock;
mod context;
mod dma;
mod gather;
mod interface;
mod kernels;
mod local;
mod on_threads;
mod per_cycle;
mod queues;
mod raster;
mod rest;
mod slots;
mod stats;
mod stream;
#[cfg(test)]
mod tests;
mod tile;
mod transfers;

pub(crate) use batch::{sent_ray, taker};
pub(crate) use clock::srp_cycles;
pub use context::{SrpContext, SrpPorts};
pub(crate) use gather::ShadeReads;
pub(crate) use kernels::{Costs, Sends};
pub use kernels::{KERNELS, KernelId, Needs, missing_kernels};
pub(crate) use local::TileBuffer;
pub(crate) use queues::{QueueId, Queues};
pub(crate) use raster::{RasterWork, list_offset};
pub use rest::RestOfTile;
pub use stats::{
    DmaCounters, InterfaceCounters, KernelCounters, LocalCounters, RasterCounters, SrpActivity, SrpReport, SrpStats,
};
pub use tile::FrameShape;
pub(crate) use tile::{border_offset, framebuffer_rows};

use std::sync::Arc;

use array::Array;
use raster::Raster;
use slots::TileSlots;
use stats::ArrayCounters;
use transfers::Transfers;

use crate::component::{Component, Tick};
use crate::config::MachineConfig;
use crate::link::{RayRef, RayUnit};
use crate::memory::{L1Cache, Memory, Port, Response, Tags};
use crate::time::{TiCycle, When};
use crate::work::layout::Layout;
use crate::work::{Neighbour, TileWork};

/// The SRP of a core.
pub struct Srp {
    array: Array,
    tiles: TileSlots,
    transfers: Transfers,
    l1_port: Port,
    next: When,
    /// Memory refused a request.
    refused: bool,
    /// Tiles wait for others.
    has_waiting: bool,
}

impl Srp {
    /// The SRP of core `core`, without a tile.
    pub fn new(config: &MachineConfig, layout: Layout, core: u32, ports: SrpPorts, shape: FrameShape) -> Self {
        Self {
            array: Array::new(config, layout, ports.l1, &shape.policy),
            tiles: TileSlots::new(config, layout, core, shape),
            transfers: Transfers::new(config, core, ports),
            l1_port: ports.l1,
            next: When::NEVER,
            refused: false,
            has_waiting: false,
        }
    }

    /// Tile slots that are free.
    #[inline]
    pub fn free_slots(&self) -> usize {
        self.tiles.free_slots()
    }

    /// Whether a tile slot is free.
    #[inline]
    pub fn wants_tile(&self) -> bool {
        self.tiles.wants_tile()
    }

    /// Puts a tile into the first free slot; it begins at the tick of cycle `now`.
    ///
    /// # Panics
    /// When no slot is free.
    pub fn give_tile(&mut self, now: TiCycle, work: Arc<TileWork>) {
        self.array.close_gap(now);
        self.tiles.give(work, &mut self.transfers);
        self.next = self.next.min(When::at(now));
    }

    /// Puts what is left of a tile into the first free slot, before the first tick. Rays that were out are sent again.
    pub(crate) fn resume(&mut self, rest: &RestOfTile) {
        let slot = self.tiles.resume(rest, &mut self.transfers);
        self.array.output.extend(rest.rays_out.iter().map(|&ray| RayRef { slot, ray }));
        self.next = When::at(TiCycle(0));
    }

    /// The tile of a slot. What it held stays readable until the slot is given another.
    #[inline]
    pub fn work(&self, slot: u8) -> &TileWork {
        self.tiles.work(slot)
    }

    /// The slots that hold a tile, with its number.
    pub fn held(&self) -> impl Iterator<Item = (usize, u32)> {
        let slots = self.tiles.all().iter().enumerate();
        slots.filter(|(_, slot)| !slot.is_free()).map(|(id, slot)| (id, slot.work.tile))
    }

    /// The first slot whose tile need not wait any longer: `is_open` tells which neighbours are not far enough.
    #[inline]
    pub fn released(&self, is_open: impl Fn(Neighbour) -> bool) -> Option<u8> {
        // Looking at the slots takes longer than most cycles.
        if self.has_waiting { self.tiles.released(is_open) } else { None }
    }

    /// Whether it works on the rounds of `neighbour` that must be done.
    pub fn is_open(&self, neighbour: Neighbour) -> bool {
        self.tiles.is_open(neighbour)
    }

    /// What the tile of `slot` waited for is done in cycle `now`: it goes on in the next.
    pub fn release(&mut self, now: TiCycle, slot: u8) {
        self.tiles.release(slot, &mut self.transfers);
        self.has_waiting = self.tiles.has_waiting();
        self.next = self.next.min(When::at(now + 1));
    }

    /// A line for one of the ports arrived. To be followed by a tick at the same cycle.
    pub fn respond(&mut self, now: TiCycle, response: Response) {
        if response.port == self.l1_port {
            self.array.gather.fill(now, response.line);
        } else {
            self.transfers.respond(response.line);
        }
        self.next = self.next.min(When::at(now));
    }

    /// Whether it waits for room in the unit or in the memory: to be ticked whenever something happens.
    #[inline]
    pub fn waits(&self) -> bool {
        self.refused || self.transfers.interface.blocked()
    }

    /// Whether no slot has a tile and nothing is under way.
    #[inline]
    pub fn is_done(&self) -> bool {
        !self.array.is_running()
            && self.tiles.taken() == 0
            && self.transfers.dma.is_idle()
            && self.array.gather.is_idle()
    }

    /// SRP cycles that begin before T&I cycle `now`: the sum of all activities of a run that ends there.
    pub fn cycles(&self, now: TiCycle) -> u64 {
        self.array.cycles(now)
    }

    /// What is under way, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        let (tiles, rays, queued) = (self.tiles.taken(), self.tiles.rays_out(), self.array.output.len());
        let batch = if self.array.is_running() { "a batch" } else { "no batch" };
        let (reads, next) = (self.array.gather.describe(), self.next.cycle().map(|at| at.0));
        format!("tiles {tiles}, rays out {rays}, output queue {queued}, {batch}, {reads}, next event {next:?}")
    }

    /// All counters but those of the L1.
    pub fn stats(&self) -> SrpStats {
        self.stats_of(self.array.counters())
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> SrpReport {
        let stats = self.stats_of(&self.array.counters_before(end));
        SrpReport { stats, l1: *self.l1().counters(), cycles: self.cycles(end) }
    }

    /// Fills the empty L1.
    pub(crate) fn warm(&mut self, tags: &Tags) {
        self.l1_mut().warm(tags);
    }

    fn stats_of(&self, array: &ArrayCounters) -> SrpStats {
        SrpStats {
            kernels: array.kernels,
            activity: array.activity,
            interface: *self.transfers.interface.counters(),
            dma: self.transfers.traffic(),
            raster: self.transfers.raster.as_ref().map(Raster::work).unwrap_or_default(),
            local: *self.tiles.counters(),
        }
    }

    /// What the array did so far.
    pub fn activity(&self) -> &SrpActivity {
        &self.array.counters().activity
    }

    /// Primaries that a rasteriser has delivered.
    pub(crate) fn primaries_delivered(&self) -> u64 {
        self.transfers.raster.as_ref().map_or(0, Raster::delivered)
    }

    /// The work that the array has done, in SRP cycles of items; nothing where they take no time.
    pub(crate) fn work_done(&self) -> u64 {
        self.array.work_done()
    }

    /// Tiles that are done.
    pub fn tiles_done(&self) -> u64 {
        self.tiles.counters().tiles
    }

    /// The L1, for its counters.
    pub fn l1(&self) -> &L1Cache {
        self.array.gather.l1()
    }

    /// The L1, to drop lines that left an inclusive L2.
    pub fn l1_mut(&mut self) -> &mut L1Cache {
        self.array.gather.l1_mut()
    }

    fn run<U: RayUnit, M: Memory>(&mut self, now: TiCycle, SrpContext { unit, memory }: SrpContext<'_, U, M>) {
        let Self { array, tiles, transfers, .. } = self;
        array.close_gap(now);
        array.gather.look_up(now, memory);
        transfers.interface.tick(now, SrpContext { unit: &mut *unit, memory: &mut *memory });
        while let Some(ray) = transfers.interface.take_hit(now) {
            tiles.ray_returned(ray, array.sorts());
        }
        while let Some(ray) = transfers.take_primary(now) {
            tiles.add_item(ray, array.sorts());
        }
        transfers.tick_raster(now, memory);
        transfers.interface.enter(now, unit);
        loop {
            let sent = transfers.interface.send(now, &mut array.output, unit);
            let worked = array.run(now, tiles, transfers, unit);
            // A batch that has just begun reads in this cycle already, and what hits may be all it waits for.
            let read = array.gather.look_up(now, memory);
            if !sent && !worked && !read {
                break;
            }
        }
        transfers.dma.tick(now, memory);
        self.plan(now, unit);
    }

    /// What the next cycles are, and when something happens again.
    #[inline]
    fn plan<U: RayUnit>(&mut self, now: TiCycle, unit: &mut U) {
        let Self { array, tiles, transfers, .. } = self;
        array.open_gap(tiles);
        let next = transfers.next_event(now, !array.output.is_empty()).min(array.next_event(now));
        // A tile whose last write was accepted in this very tick goes on in the next cycle.
        let step = When::only_if(tiles.can_advance(transfers), now + 1);
        let result = When::from(unit.results().front().map(|result| result.at)).after(now);
        self.next = next.min(step).min(result);
        self.refused = transfers.refused() || array.gather.refused();
        self.has_waiting = tiles.has_waiting();
    }
}

impl Component for Srp {
    type Report = SrpReport;

    #[inline]
    fn next_event(&self, now: TiCycle) -> When {
        self.next.after(now)
    }

    fn finish(&mut self, end: TiCycle) -> SrpReport {
        self.array.close_gap(end);
        SrpReport { stats: self.stats(), l1: self.array.gather.finish(end), cycles: self.cycles(end) }
    }
}

impl<U: RayUnit, M: Memory> Tick<SrpContext<'_, U, M>> for Srp {
    #[inline]
    fn tick(&mut self, now: TiCycle, context: SrpContext<'_, U, M>) {
        let unit = &mut *context.unit;
        let freed = self.refused || (self.transfers.interface.blocked() && unit.has_room());
        let due = freed || self.next.is_due(now) || unit.has_finished_jobs() || unit.job_room() > 0;
        if due || unit.results().front().is_some_and(|result| result.at <= now) {
            self.run(now, context);
        }
    }
}
