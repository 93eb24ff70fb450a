//! The tiles of a core: its slots, what they share, and how many of their rays are out.

use std::sync::Arc;

use rayreel_formats::tile::RayKind;

use super::batch::taker;
use super::kernels::KernelId;
use super::local::TileBuffer;
use super::rest::RestOfTile;
use super::stats::LocalCounters;
use super::tile::{FrameShape, Slot, TileContext};
use super::transfers::Transfers;
use crate::config::MachineConfig;
use crate::link::RayRef;
use crate::work::history::HistoryLayout;
use crate::work::layout::Layout;
use crate::work::{Neighbour, TileWork};

/// The tile slots of a core.
pub struct TileSlots {
    slots: Vec<Slot>,
    /// Slots without a tile.
    free: usize,
    given: u64,
    /// Rays of the core that are out, primaries of a rasteriser not.
    rays_out: usize,
    buffer: TileBuffer,
    layout: Layout,
    history: HistoryLayout,
    shape: FrameShape,
    core: u32,
    counters: LocalCounters,
}

impl TileSlots {
    /// The slots of core `core`, all free.
    pub fn new(config: &MachineConfig, layout: Layout, core: u32, shape: FrameShape) -> Self {
        let slots = config.gpu.tiles_in_flight.clamp(1, 255) as usize;
        Self {
            slots: vec![Slot::new(); slots],
            free: slots,
            given: 0,
            rays_out: 0,
            buffer: TileBuffer::new(config, &shape.policy),
            layout,
            history: HistoryLayout::new(&config.srp.sample, shape.tile_samples),
            shape,
            core,
            counters: LocalCounters::default(),
        }
    }

    /// All slots.
    #[inline]
    pub fn all(&self) -> &[Slot] {
        &self.slots
    }

    /// A slot, and the number of rays of the core that are out.
    #[inline]
    pub fn slot_mut(&mut self, id: usize) -> (&mut Slot, &mut usize) {
        (&mut self.slots[id], &mut self.rays_out)
    }

    /// Rays of the core that are out.
    #[inline]
    pub fn rays_out(&self) -> usize {
        self.rays_out
    }

    /// The tile of a slot. What it held stays readable until the slot is given another.
    #[inline]
    pub fn work(&self, slot: u8) -> &TileWork {
        &self.slots[slot as usize].work
    }

    /// Slots that hold a tile.
    #[inline]
    pub fn taken(&self) -> usize {
        self.slots.len() - self.free
    }

    /// Whether all its tiles wait for others.
    pub fn all_wait(&self) -> bool {
        self.slots.iter().all(|slot| !slot.is_at_work())
    }

    /// Slots that hold no tile.
    #[inline]
    pub fn free_slots(&self) -> usize {
        self.free
    }

    /// Whether a slot is free.
    #[inline]
    pub fn wants_tile(&self) -> bool {
        self.free > 0
    }

    /// Whether a tile waits for others.
    pub fn has_waiting(&self) -> bool {
        self.slots.iter().any(|slot| slot.waits_for(|_| true).is_some())
    }

    /// The first slot whose tile need not wait any longer: `is_open` tells which neighbours are not far enough.
    pub fn released(&self, is_open: impl Fn(Neighbour) -> bool) -> Option<u8> {
        let slot = self.slots.iter().position(|slot| slot.waits_for(&is_open) == Some(false));
        slot.map(|slot| slot as u8)
    }

    /// Whether a slot works on the rounds of `neighbour` that must be done.
    pub fn is_open(&self, neighbour: Neighbour) -> bool {
        self.slots.iter().any(|slot| slot.is_open(neighbour))
    }

    /// The tile of slot `id` need not wait any longer.
    pub fn release(&mut self, id: u8, transfers: &mut Transfers) {
        let (slot, mut context) = self.with_context(id.into(), transfers);
        slot.release(id, &mut context);
    }

    /// What was counted so far.
    pub fn counters(&self) -> &LocalCounters {
        &self.counters
    }

    /// Puts a tile into the first free slot.
    ///
    /// # Panics
    /// When no slot is free.
    pub fn give(&mut self, work: Arc<TileWork>, transfers: &mut Transfers) {
        let (id, age) = self.take_slot();
        let (slot, mut context) = self.with_context(id, transfers);
        slot.give(id as u8, age, work, &mut context);
    }

    /// As [`TileSlots::give`], for what is left of a tile; gives the slot.
    pub fn resume(&mut self, rest: &RestOfTile, transfers: &mut Transfers) -> u8 {
        let (id, age) = self.take_slot();
        self.rays_out += rest.rays_out.len();
        let (slot, mut context) = self.with_context(id, transfers);
        slot.resume(id as u8, age, rest, &mut context);
        id as u8
    }

    /// The first free slot, and the number of the tile that it gets.
    fn take_slot(&mut self) -> (usize, u64) {
        let free = self.slots.iter().position(Slot::is_free);
        let id = free.expect("a tile is given only to an SRP that wants one");
        self.free -= 1;
        self.given += 1;
        (id, self.given)
    }

    /// A ray came back from the T&I unit: its item.
    #[inline]
    pub fn ray_returned(&mut self, ray: RayRef, sorts: bool) {
        self.rays_out -= 1;
        self.add_item(ray, sorts);
    }

    /// The item of a ray that came back. One pending ray less, one pending item more; `sorts` tells whether hits are sorted by
    /// material.
    #[inline]
    pub fn add_item(&mut self, RayRef { slot, ray }: RayRef, sorts: bool) {
        let slot = &mut self.slots[slot as usize];
        let work = &slot.work.rays[ray as usize];
        slot.rays_out -= 1;
        let kernel = taker(work);
        match kernel {
            KernelId::Shade => slot.queues.push_shade(if sorts { work.material } else { 0 }, ray),
            _ => slot.queues.push_ray(kernel, ray),
        }
        self.buffer.count(kernel, work.kind == RayKind::Primary, 1, &mut self.counters);
    }

    /// Takes every step of every tile that is due. Returns whether there was one.
    #[inline]
    pub fn advance(&mut self, transfers: &mut Transfers) -> bool {
        // Mostly every tile has something pending.
        self.slots.iter().any(|slot| slot.pending == 0 && slot.is_at_work()) && self.advance_idle(transfers)
    }

    fn advance_idle(&mut self, transfers: &mut Transfers) -> bool {
        let mut stepped = false;
        for id in 0..self.slots.len() {
            if !self.slots[id].is_at_work() || self.slots[id].pending > 0 {
                continue;
            }
            let (slot, mut context) = self.with_context(id, transfers);
            while slot.advance(id as u8, &mut context) {
                stepped = true;
            }
            self.free += usize::from(self.slots[id].is_free());
        }
        stepped
    }

    /// Whether a tile can take a step: a write of it was the last thing that it waited for.
    #[inline]
    pub fn can_advance(&self, transfers: &Transfers) -> bool {
        let steps =
            |(id, slot): (usize, &Slot)| slot.pending == 0 && slot.is_at_work() && transfers.dma.pending(id as u8) == 0;
        self.slots.iter().enumerate().any(steps)
    }

    fn with_context<'a>(&'a mut self, id: usize, transfers: &'a mut Transfers) -> (&'a mut Slot, TileContext<'a>) {
        let context = TileContext {
            dma: &mut transfers.dma,
            raster: transfers.raster.as_mut(),
            buffer: &self.buffer,
            layout: self.layout,
            history: self.history,
            shape: self.shape,
            core: self.core,
            counters: &mut self.counters,
        };
        (&mut self.slots[id], context)
    }
}
