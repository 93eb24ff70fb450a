//! The SIMD array of an SRP: which batch it runs, what its rays and reads do, and what it did in every cycle.

use std::collections::VecDeque;

use super::batch::{Batch, BatchContext, Choosing, Progress, choose, sent_ray};
use super::clock::Clock;
use super::gather::Gather;
use super::kernels::{Costs, KernelId, Sends};
use super::on_threads::OnThreads;
use super::queues::QueueId;
use super::slots::TileSlots;
use super::stats::ArrayCounters;
use super::transfers::Transfers;
use crate::component::Component;
use crate::config::{MachineConfig, Pipeline};
use crate::link::{RayRef, RayUnit};
use crate::memory::Port;
use crate::time::{ClockCycle, SrpCycle, TiCycle, When};
use crate::work::PolicyReads;
use crate::work::layout::Layout;

/// What the array waits for while it runs no batch: for a tile, for rays that are out, for a tile's transfers, or for tiles beside
/// its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Gap {
    Idle,
    Unit,
    Transfer,
    Border,
}

impl Gap {
    /// The cycles that were lost to it.
    fn of(self, counters: &mut ArrayCounters) -> &mut u64 {
        match self {
            Self::Idle => &mut counters.activity.idle,
            Self::Unit => &mut counters.activity.unit,
            Self::Transfer => &mut counters.activity.transfer,
            Self::Border => &mut counters.activity.border,
        }
    }
}

/// The array with its output queue and its reads.
pub struct Array {
    clock: Clock,
    costs: Costs,
    ideal: bool,
    batch_min: usize,
    batch_max: usize,
    /// Rays that the output queue holds, and with more than how many no primaries are begun.
    output_rays: usize,
    output_high: usize,
    /// With fewer rays out than this, kernels that send rays go first.
    low_rays: usize,
    batch: Batch,
    running: Option<Progress>,
    /// Rays that wait for the interface.
    pub output: VecDeque<RayRef>,
    /// Reads of `shade`.
    pub gather: Gather,
    /// Kernels run on threads: there is no array.
    threads: Option<OnThreads>,
    /// SRP cycles before this one are in the counters.
    accounted: SrpCycle,
    gap: Gap,
    counters: ArrayCounters,
    /// Rays of the queue that is worked on, kept for its memory (`srp.ideal`).
    scratch: Vec<u32>,
}

impl Array {
    /// The array of a machine under a policy; its L1 is at `port`.
    pub fn new(config: &MachineConfig, layout: Layout, port: Port, policy: &PolicyReads) -> Self {
        let (clock, costs) = (Clock::new(config), Costs::new(config, policy));
        let has_threads = config.ti.pipeline == Pipeline::Software;
        Self {
            clock,
            threads: has_threads.then(|| OnThreads::new(config, layout, &costs)),
            costs,
            ideal: config.srp.ideal,
            batch_min: config.srp.batch_min.max(1) as usize,
            batch_max: config.srp.batch_max.max(1) as usize,
            output_rays: config.srp.output_rays.max(1) as usize,
            output_high: config.output_high_rays() as usize,
            low_rays: config.low_rays() as usize,
            batch: Batch::none(),
            running: None,
            output: VecDeque::new(),
            gather: Gather::new(config, layout, clock, port),
            accounted: SrpCycle::START,
            gap: Gap::Idle,
            counters: ArrayCounters::default(),
            scratch: Vec::new(),
        }
    }

    /// Whether hits are sorted by material.
    #[inline]
    pub fn sorts(&self) -> bool {
        self.costs.sorts()
    }

    /// Whether a batch runs, or items on threads.
    pub fn is_running(&self) -> bool {
        self.running.is_some() || self.has_jobs()
    }

    fn has_jobs(&self) -> bool {
        self.threads.as_ref().is_some_and(OnThreads::is_running)
    }

    /// The work that is done ([`Costs::work`]).
    pub fn work_done(&self) -> u64 {
        let kernels = KernelId::ALL.iter().zip(&self.counters.kernels);
        kernels.map(|(&kernel, counted)| self.costs.work(kernel, counted.items)).sum()
    }

    /// SRP cycles that begin before T&I cycle `now`.
    pub fn cycles(&self, now: TiCycle) -> u64 {
        self.clock.srp(now) - SrpCycle::START
    }

    /// What was counted so far.
    pub fn counters(&self) -> &ArrayCounters {
        &self.counters
    }

    /// When something happens here by itself. A batch that waits for reads or for room has no event.
    #[inline]
    pub fn next_event(&self, now: TiCycle) -> When {
        let item = match self.running {
            Some(Progress::At(at)) => When::at(at),
            _ => When::NEVER,
        };
        item.min(self.gather.next_event(now))
    }

    /// Runs everything up to `now`, and the steps of tiles that this leads to. Returns whether something was done.
    pub fn run<U: RayUnit>(
        &mut self,
        now: TiCycle,
        tiles: &mut TileSlots,
        transfers: &mut Transfers,
        unit: &mut U,
    ) -> bool {
        match &self.threads {
            Some(_) => self.run_on_threads(now, tiles, transfers, unit),
            None if self.ideal => self.run_ideally(tiles, transfers),
            None => self.run_batches(now, tiles, transfers),
        }
    }

    fn run_on_threads<U: RayUnit>(
        &mut self,
        now: TiCycle,
        tiles: &mut TileSlots,
        transfers: &mut Transfers,
        unit: &mut U,
    ) -> bool {
        let Some(threads) = &mut self.threads else { return false };
        let mut worked = threads.finish(unit, tiles, &mut self.output, &mut self.counters);
        worked |= tiles.advance(transfers);
        loop {
            let choosing = self.choosing(tiles);
            let Some(threads) = &mut self.threads else { return worked };
            if !threads.start(now, unit, tiles, (&self.costs, choosing, &mut self.counters)) {
                return worked;
            }
            worked = true;
        }
    }

    fn run_batches(&mut self, now: TiCycle, tiles: &mut TileSlots, transfers: &mut Transfers) -> bool {
        let mut worked = tiles.advance(transfers);
        loop {
            if let Some(progress) = self.running {
                let early = matches!(progress, Progress::At(at) if at > now);
                if early || !self.continue_batch(now, tiles, &mut worked) {
                    return worked;
                }
                tiles.advance(transfers);
            }
            let choosing = self.choosing(tiles);
            let Some(choice) = choose(tiles.all(), choosing) else { return worked };
            let (slot, _) = tiles.slot_mut(choice.slot as usize);
            self.batch.begin(self.accounted, choice, self.batch_max, slot, &self.costs, &mut self.gather);
            self.counters.kernels[self.batch.kernel as usize].batches += 1;
            self.running = Some(Progress::Reads);
            worked = true;
        }
    }

    /// Runs the batch up to `now`. Returns whether it ended.
    fn continue_batch(&mut self, now: TiCycle, tiles: &mut TileSlots, worked: &mut bool) -> bool {
        let (slot, rays_out) = tiles.slot_mut(self.batch.slot as usize);
        let mut context = BatchContext {
            clock: self.clock,
            costs: &self.costs,
            slot,
            gather: &self.gather,
            output_rays: self.output_rays,
            output: &mut self.output,
            rays_out,
            counters: &mut self.counters,
        };
        let before = context.output.len();
        let progress = self.batch.progress(now, &mut context);
        *worked |= before != self.output.len() || progress == Progress::Ended;
        self.accounted = self.batch.at();
        self.running = (progress != Progress::Ended).then_some(progress);
        progress == Progress::Ended
    }

    /// What the choice of the next queue depends on.
    fn choosing(&self, tiles: &TileSlots) -> Choosing {
        Choosing {
            batch_min: self.batch_min,
            low: tiles.rays_out() < self.low_rays,
            output_full: self.output.len() > self.output_high,
        }
    }

    /// All items at once, without time (`srp.ideal`).
    fn run_ideally(&mut self, tiles: &mut TileSlots, transfers: &mut Transfers) -> bool {
        let mut worked = tiles.advance(transfers);
        for id in 0..tiles.all().len() {
            while let Some(queue) = self.next_ideal_queue(id, tiles) {
                self.run_queue_ideally(id, queue, tiles);
                worked = true;
            }
        }
        worked | tiles.advance(transfers)
    }

    /// Rays of hits go first: primaries fill what is left of the output queue.
    fn next_ideal_queue(&self, id: usize, tiles: &TileSlots) -> Option<QueueId> {
        let mut next: Option<QueueId> = None;
        tiles.all()[id].queues.each(|queue, _| {
            let first = next.is_none_or(|other| other.kernel == KernelId::Raygen);
            if first && (queue.kernel != KernelId::Raygen || self.ideal_room() > 0) {
                next = Some(queue);
            }
        });
        next
    }

    fn ideal_room(&self) -> usize {
        self.output_rays.saturating_sub(self.output.len())
    }

    fn run_queue_ideally(&mut self, id: usize, queue: QueueId, tiles: &mut TileSlots) {
        let kernel = queue.kernel;
        let most = if kernel == KernelId::Raygen { self.ideal_room() } else { usize::MAX };
        let mut rays = std::mem::take(&mut self.scratch);
        rays.clear();
        let (slot, rays_out) = tiles.slot_mut(id);
        let items = slot.queues.take(queue, most, &mut rays);
        let counters = &mut self.counters.kernels[kernel as usize];
        counters.batches += 1;
        counters.items += items as u64;
        slot.pending -= items as u32;
        if rays.is_empty() {
            counters.ops += items as u64 * self.costs.ops(kernel, Sends::default(), 1);
        }
        for &ray in &rays {
            let work = &slot.work.rays[ray as usize];
            counters.ops += self.costs.ops(kernel, Sends::of(kernel, work), 1);
            if kernel == KernelId::Shade {
                self.gather.add(0, work);
            }
            let mut sent = 0;
            while let Some(child) = sent_ray(kernel, &slot.work, ray, sent) {
                self.output.push_back(RayRef { slot: id as u8, ray: child });
                sent += 1;
            }
            (slot.pending, slot.rays_out) = (slot.pending + sent, slot.rays_out + sent);
            *rays_out += sent as usize;
        }
        self.scratch = rays;
    }

    /// Accounts for the SRP cycles before `now` in which the array had no batch.
    #[inline]
    pub fn close_gap(&mut self, now: TiCycle) {
        if self.running.is_some() {
            return;
        }
        let until = self.clock.srp(now);
        if until > self.accounted {
            *self.gap.of(&mut self.counters) += until - self.accounted;
            self.accounted = until;
        }
    }

    /// The counters with the SRP cycles before `now` in which the array had no batch.
    pub fn counters_before(&self, now: TiCycle) -> ArrayCounters {
        let (mut counters, until) = (self.counters, self.clock.srp(now));
        if self.running.is_none() && until > self.accounted {
            *self.gap.of(&mut counters) += until - self.accounted;
        }
        counters
    }

    /// Notes what the array waits for from now on, if it runs no batch.
    #[inline]
    pub fn open_gap(&mut self, tiles: &TileSlots) {
        self.gap = match () {
            () if tiles.rays_out() > 0 || self.has_jobs() => Gap::Unit,
            () if tiles.taken() == 0 => Gap::Idle,
            () if tiles.all_wait() => Gap::Border,
            () => Gap::Transfer,
        };
    }
}
