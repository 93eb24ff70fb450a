//! A tile slot: from the first round to the pixels in the framebuffer.
//!
//! ```text
//! free -> [reads of the round -> tests -> interpolations and started rays] per round -> border and spill traffic -> resolve -> store -> free
//! ```
//!
//! A step begins when the one before is completely done: no item queued or running, no ray out, no transfer of this tile under
//! way. So a round begins when the one before is done (paper: tests see what was traced before). Started rays are queued in the
//! order of the round. With two tiles in flight SRP and T&I unit overlap.
//!
//! A tile that closes the last columns and rows of other tiles waits for these before the rounds that do so: for the first round
//! of the tile to the left, and for the X step of the tile above. A tile that is in no slot is done, since tiles come in order.
//! It goes on in the cycle after the one that it waited for. Border samples of others are read before the second round.
//!
//! Store: the pixels of the tile, into a framebuffer of one frame: row by row of the picture, or as one stretch a tile
//! (`layout.framebuffer`). Border samples: `sample.total()` bytes each, read before the second round, and written at the end of
//! the tile for others. (Estimate.)

use std::sync::Arc;

use super::dma::Dma;
use super::kernels::KernelId;
use super::local::TileBuffer;
use super::queues::Queues;
use super::raster::{Raster, list_offset};
use super::rest::RestOfTile;
use super::stats::LocalCounters;
use crate::link::RayRef;
use crate::memory::Route;
use crate::work::history::HistoryLayout;
use crate::work::layout::{Layout, Region};
use crate::work::{Neighbour, PolicyReads, Round, TileWork};
use rayreel_formats::scene::Rect;
use rayreel_formats::tile::RayKind;

/// The framebuffer, and what the policy reads: the same for all tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameShape {
    /// Width of the frame in pixels.
    pub width_pixels: u32,
    /// Samples of a pixel in a row, and in a column.
    pub samples_per_axis: u32,
    /// Bytes a pixel (`layout.pixel_bytes`).
    pub pixel_bytes: u32,
    /// Bytes from one tile's pixels to the next one's; 0 where pixels lie row by row of the picture.
    pub tile_bytes: u64,
    /// Samples of a whole tile.
    pub tile_samples: u32,
    /// What the policy reads.
    pub policy: PolicyReads,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Free,
    /// Other tiles have to come first.
    Waits,
    Reads,
    Tests,
    Samples,
    Traffic,
    Resolve,
    Store,
}

/// What a slot works with.
pub struct TileContext<'a> {
    /// DMA engine.
    pub dma: &'a mut Dma,
    /// Rasteriser, if primary visibility is its work.
    pub raster: Option<&'a mut Raster>,
    /// Tile buffer.
    pub buffer: &'a TileBuffer,
    /// Addresses.
    pub layout: Layout,
    /// Histories.
    pub history: HistoryLayout,
    /// Framebuffer.
    pub shape: FrameShape,
    /// Core.
    pub core: u32,
    /// Counters.
    pub counters: &'a mut LocalCounters,
}

/// A tile slot.
#[derive(Clone, Debug)]
pub struct Slot {
    /// The tile.
    pub work: Arc<TileWork>,
    /// Number of the tile in the order in which this core got them.
    pub age: u64,
    /// Items queued or running, and rays out.
    pub pending: u32,
    /// Rays that have not come back, primaries that the rasteriser has not delivered.
    pub rays_out: u32,
    /// Item queues.
    pub queues: Queues,
    phase: Phase,
    round: usize,
    written_bytes: u64,
}

impl Slot {
    /// A free slot.
    pub fn new() -> Self {
        let work = TileWork::empty(0, 0, Rect { x: 0, y: 0, width: 0, height: 0 });
        Self {
            work: Arc::new(work),
            age: 0,
            pending: 0,
            rays_out: 0,
            queues: Queues::default(),
            phase: Phase::Free,
            round: 0,
            written_bytes: 0,
        }
    }

    /// Whether there is no tile.
    #[inline]
    pub fn is_free(&self) -> bool {
        self.phase == Phase::Free
    }

    /// Whether it has a tile that does not wait for others.
    #[inline]
    pub fn is_at_work(&self) -> bool {
        !matches!(self.phase, Phase::Free | Phase::Waits)
    }

    /// The round that runs.
    pub fn round(&self) -> Option<&Round> {
        self.work.rounds.get(self.round)
    }

    /// Takes a tile.
    pub fn give(&mut self, id: u8, age: u64, work: Arc<TileWork>, context: &mut TileContext<'_>) {
        assert!(self.is_free(), "tile slot {id} is taken");
        (self.work, self.age, self.round, self.written_bytes) = (work, age, 0, 0);
        self.begin_round(id, context);
    }

    /// Takes what is left of a tile.
    pub fn resume(&mut self, id: u8, age: u64, rest: &RestOfTile, context: &mut TileContext<'_>) {
        let Some(round) = rest.begun.checked_sub(1) else { return self.give(id, age, Arc::clone(&rest.work), context) };
        assert!(self.is_free(), "tile slot {id} is taken");
        (self.work, self.age, self.round, self.written_bytes) =
            (Arc::clone(&rest.work), age, round, rest.written_bytes);
        self.queues = rest.queues.clone();
        self.rays_out = rest.rays_out.len() as u32;
        self.pending = self.queues.items() as u32 + self.rays_out;
        self.phase = Phase::Samples;
    }

    /// Whether it waits for tiles that `is_open` tells to be not far enough; nothing if it does not wait at all.
    pub fn waits_for(&self, is_open: impl Fn(Neighbour) -> bool) -> Option<bool> {
        (self.phase == Phase::Waits).then(|| self.work.neighbours_before(self.round).any(is_open))
    }

    /// Whether it works on the rounds of `neighbour` that must be done.
    pub fn is_open(&self, neighbour: Neighbour) -> bool {
        !self.is_free() && self.work.tile == neighbour.tile && self.round < neighbour.rounds as usize
    }

    /// What it waited for is done.
    pub fn release(&mut self, id: u8, context: &mut TileContext<'_>) {
        self.read_round(id, context);
    }

    /// Takes the next step if the one before is done. Returns whether it did.
    pub fn advance(&mut self, id: u8, context: &mut TileContext<'_>) -> bool {
        if !self.is_at_work() || self.pending > 0 || context.dma.pending(id) > 0 {
            return false;
        }
        match self.phase {
            Phase::Free | Phase::Waits => {}
            Phase::Reads => {
                let (tests, colours) = self.round().map_or((0, 0), |w| (w.tests, w.colours));
                self.queue(KernelId::Similarity, tests, context);
                self.queue(KernelId::Colour, colours, context);
                self.phase = Phase::Tests;
            }
            Phase::Tests => {
                self.begin_samples(id, context);
                self.phase = Phase::Samples;
            }
            Phase::Samples => {
                let bytes = self.round().map_or(0, |w| context.buffer.round_written_bytes(w));
                self.transfer(id, Region::Sample, Route::Write, self.written_bytes, bytes, context);
                self.written_bytes += bytes;
                self.round += 1;
                self.begin_round(id, context);
            }
            Phase::Traffic => {
                self.queue(KernelId::Colour, self.work.audited_samples, context);
                self.queue(KernelId::Control, context.shape.policy.control.into(), context);
                self.queue(KernelId::Resolve, self.work.rect.len() as u32, context);
                self.phase = Phase::Resolve;
            }
            Phase::Resolve => {
                self.store(id, context);
                self.phase = Phase::Store;
            }
            Phase::Store => {
                context.counters.tiles += 1;
                self.phase = Phase::Free;
            }
        }
        true
    }

    fn queue(&mut self, kernel: KernelId, items: u32, context: &mut TileContext<'_>) {
        self.queues.push_count(kernel, items);
        self.pending += items;
        context.buffer.count(kernel, false, items.into(), context.counters);
    }

    fn begin_round(&mut self, id: u8, context: &mut TileContext<'_>) {
        if self.round().is_none() {
            return self.end_rounds(id, context);
        }
        if self.work.neighbours_before(self.round).next().is_some() {
            self.phase = Phase::Waits;
        } else {
            self.read_round(id, context);
        }
    }

    /// What the tests of the round at hand read from memory.
    fn read_round(&mut self, id: u8, context: &mut TileContext<'_>) {
        let bytes = self.round().map_or(0, |round| context.buffer.round_read_bytes(round));
        self.transfer(id, Region::Sample, Route::Read, 0, bytes, context);
        if self.round == 0 {
            let history = context.history;
            for (offset, bytes) in history.reads(self.work.frame, &self.work.history) {
                self.move_history(id, Route::Read, offset, bytes, context);
            }
        }
        if self.round == 1 {
            let border = u64::from(self.work.border_samples) * context.buffer.sample_bytes();
            self.transfer(id, Region::Border, Route::Read, 0, border, context);
        }
        self.phase = Phase::Reads;
    }

    fn begin_samples(&mut self, id: u8, context: &mut TileContext<'_>) {
        let of = |w: &Round| (w.interpolated, w.attributes, w.shaded, w.looked_back);
        let (interpolated, attributes, shaded, looked_back) = self.round().map_or((0, 0, 0, 0), of);
        self.queue(KernelId::Interpolate, interpolated, context);
        self.queue(KernelId::Attributes, attributes, context);
        self.queue(KernelId::Reshade, shaded, context);
        self.queue(KernelId::LookBack, looked_back, context);
        let Some(round) = self.work.rounds.get(self.round) else { return };
        self.pending += round.starts.len() as u32;
        if let Some(raster) = &mut context.raster {
            let bytes = raster.begin(&self.work, &round.starts);
            for route in [Route::Write, Route::Read] {
                self.transfer(id, Region::GBuffer, route, 0, bytes, context);
            }
        }
        for &ray in &round.starts {
            match &mut context.raster {
                // A rasteriser sees what the eye sees; rays from interpolated hits are traced.
                Some(raster) if self.work.rays[ray as usize].kind == RayKind::Primary => {
                    self.rays_out += 1;
                    raster.add(RayRef { slot: id, ray });
                }
                _ => self.queues.push_ray(KernelId::Raygen, ray),
            }
        }
    }

    fn end_rounds(&mut self, id: u8, context: &mut TileContext<'_>) {
        let sample = context.buffer.sample_bytes();
        let spilled = context.buffer.spilled_samples(&self.work);
        context.counters.spilled_samples += spilled;
        for route in [Route::Write, Route::Read] {
            self.transfer(id, Region::Sample, route, 0, spilled * sample, context);
        }
        let kept = u64::from(self.work.kept_samples) * sample;
        self.transfer(id, Region::Border, Route::Write, 0, kept, context);
        let work = &self.work;
        for (offset, bytes) in context.history.writes(work.frame, work.tile, &work.history) {
            self.move_history(id, Route::Write, offset, bytes, context);
        }
        self.phase = Phase::Traffic;
    }

    /// Moves `bytes` from `offset` of this slot's (tile's, for borders) part of a region on.
    fn transfer(&self, id: u8, region: Region, route: Route, offset: u64, bytes: u64, context: &mut TileContext<'_>) {
        if bytes == 0 {
            return;
        }
        let part = match region {
            Region::Border => border_offset(self.work.tile),
            Region::GBuffer => list_offset(self.work.tile),
            _ => (u64::from(context.core) * 256 + u64::from(id)) * SLOT_BYTES,
        };
        context.dma.add(id, region, route, context.layout.lines(region.base() + part + offset, bytes));
    }

    fn move_history(&self, id: u8, route: Route, offset: u64, bytes: u64, context: &mut TileContext<'_>) {
        let lines = context.layout.lines(Region::History.base() + offset, bytes);
        context.dma.add(id, Region::History, route, lines);
    }

    fn store(&self, id: u8, context: &mut TileContext<'_>) {
        for (address, bytes) in framebuffer_rows(context.shape, &self.work) {
            context.dma.add(id, Region::Framebuffer, Route::Write, context.layout.lines(address, bytes));
        }
    }
}

/// From the samples of one tile slot in memory to those of the next: an odd number of lines, so that slots do not all begin in the
/// same sets and banks.
const SLOT_BYTES: u64 = (1 << 24) + 0x1040;

/// Where the border samples of a tile lie in their region; the distance of tiles is an odd number of lines.
pub fn border_offset(tile: u32) -> u64 {
    u64::from(tile) * ((1 << 16) + 0x1040)
}

/// The pixels of a tile in the framebuffer: address and bytes of each stretch; none of an empty tile.
pub fn framebuffer_rows(shape: FrameShape, work: &TileWork) -> impl Iterator<Item = (u64, u64)> + use<> {
    let FrameShape { width_pixels, samples_per_axis, pixel_bytes, tile_bytes, .. } = shape;
    let (rect, tile) = (work.rect, work.tile);
    let per_pixel = samples_per_axis.max(1);
    let (left, right) = (rect.x / per_pixel, (rect.x + rect.width).div_ceil(per_pixel));
    let (top, bottom) = (rect.y / per_pixel, (rect.y + rect.height).div_ceil(per_pixel));
    let tiled = tile_bytes > 0;
    let rows = match rect.is_empty() {
        true => 0..0,
        false if tiled => 0..1,
        false => top..bottom,
    };
    rows.map(move |y| {
        if tiled {
            let pixels = u64::from(right - left) * u64::from(bottom - top);
            return (Region::Framebuffer.base() + u64::from(tile) * tile_bytes, pixels * u64::from(pixel_bytes));
        }
        let pixel = u64::from(y) * u64::from(width_pixels) + u64::from(left);
        let address = Region::Framebuffer.base() + pixel * u64::from(pixel_bytes);
        (address, u64::from(right - left) * u64::from(pixel_bytes))
    })
}
