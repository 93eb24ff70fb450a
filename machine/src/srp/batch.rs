//! The batch that the array runs, and which comes next.
//!
//! The array runs one batch at a time: items of one queue, so of one tile, kernel and (with an inspector) branch. Rules, all
//! estimates:
//!
//! * A queue is *ready* when it has `batch_min` items, or nothing can be added to it before it runs (the kernels without rays as
//!   input get all items of a round at once; the others get no more when no ray of the tile is out), or its items send rays and
//!   fewer rays of this core are out than `rays_low_percent` of what the T&I unit holds: then starving the unit costs more than a prologue.
//! * `raygen` is not ready while the output queue is more than `output_high_percent` full: the array would only wait.
//! * Of the ready queues the longest runs, when the unit is low on rays the longest of those that send rays. Ties: the tile given
//!   first, then the order of kernels, then the smaller material. At most `batch_max` items, of `shade` `gather_entries`.
//! * Batches follow each other without a gap. The choice is made in the T&I cycle in which the batch before ends.
//! * The rays of an item enter the output queue (`output_rays` rays) when it is complete, in order: shadow rays, reflection,
//!   refraction. While the queue is full the array stands still, and all later items move back.

use std::cmp::Ordering;
use std::collections::VecDeque;

use super::clock::Clock;
use super::gather::Gather;
use super::kernels::{Costs, KernelId, Sends};
use super::queues::QueueId;
use super::stats::ArrayCounters;
use super::tile::Slot;
use crate::link::RayRef;
use crate::time::{ClockCycle, SrpCycle, TiCycle};
use crate::work::{NO_RAY, RayWork, TileWork};

/// A ready queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Slot.
    pub slot: u8,
    /// Queue of the slot.
    pub queue: QueueId,
    urgent: bool,
    items: usize,
    age: u64,
}

/// What the choice depends on, apart from the queues.
#[derive(Clone, Copy, Debug)]
pub struct Choosing {
    /// `srp.batch_min`.
    pub batch_min: usize,
    /// Whether few rays of this core are out.
    pub low: bool,
    /// Whether the output queue is too full for primary rays.
    pub output_full: bool,
}

/// The queue that runs next.
pub fn choose(slots: &[Slot], by: Choosing) -> Option<Choice> {
    let mut best: Option<Choice> = None;
    for (id, slot) in slots.iter().enumerate().filter(|(_, s)| s.pending > s.rays_out) {
        slot.queues.each(|queue, items| {
            let kernel = queue.kernel;
            let of_hits = matches!(kernel, KernelId::Shade | KernelId::Miss | KernelId::ShadowResult);
            let grows = of_hits && slot.rays_out > 0;
            let urgent = by.low && kernel.emits();
            let held = kernel == KernelId::Raygen && by.output_full;
            if held || !(items >= by.batch_min || !grows || urgent) {
                return;
            }
            let new = Choice { slot: id as u8, queue, urgent, items, age: slot.age };
            if best.is_none_or(|old| new.rank(&old) == Ordering::Greater) {
                best = Some(new);
            }
        });
    }
    best
}

impl Choice {
    fn rank(&self, other: &Self) -> Ordering {
        self.urgent.cmp(&other.urgent).then(self.items.cmp(&other.items)).then(other.age.cmp(&self.age))
    }
}

/// Ray `k` that an item sends.
#[inline]
pub fn sent_ray(kernel: KernelId, work: &TileWork, ray: u32, k: u32) -> Option<u32> {
    if kernel != KernelId::Shade {
        return (kernel == KernelId::Raygen && k == 0).then_some(ray);
    }
    let parent = &work.rays[ray as usize];
    let shadows = u32::from(parent.shadows);
    if k < shadows {
        return Some(ray + 1 + k);
    }
    let children = [parent.reflect, parent.refract];
    children.into_iter().filter(|&child| child != NO_RAY).nth((k - shadows) as usize)
}

/// How far the batch could go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// It is over.
    Ended,
    /// Its next item is complete at this T&I cycle.
    At(TiCycle),
    /// Its next item waits for its reads.
    Reads,
    /// Its next ray waits for room in the output queue.
    Output,
}

/// The batch that the array runs.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Slot.
    pub slot: u8,
    /// Kernel.
    pub kernel: KernelId,
    rays: Vec<u32>,
    items: u64,
    next: usize,
    branches: u64,
    inspector: u64,
    prologue: u64,
    sent: u32,
    complete: bool,
    blocked: bool,
    /// SRP cycle up to which the array's time is spent.
    at: SrpCycle,
}

/// What a running batch acts on.
pub struct BatchContext<'a> {
    /// Clocks.
    pub clock: Clock,
    /// Costs.
    pub costs: &'a Costs,
    /// Its slot.
    pub slot: &'a mut Slot,
    /// Reads.
    pub gather: &'a Gather,
    /// Rays that the output queue holds.
    pub output_rays: usize,
    /// Output queue.
    pub output: &'a mut VecDeque<RayRef>,
    /// Rays of the core that are out.
    pub rays_out: &'a mut usize,
    /// Counters.
    pub counters: &'a mut ArrayCounters,
}

impl Batch {
    /// No batch.
    pub fn none() -> Self {
        Self {
            slot: 0,
            kernel: KernelId::Raygen,
            rays: Vec::new(),
            items: 0,
            next: 0,
            branches: 1,
            inspector: 0,
            prologue: 0,
            sent: 0,
            complete: false,
            blocked: false,
            at: SrpCycle::START,
        }
    }

    /// SRP cycle up to which the array's time is spent.
    pub fn at(&self) -> SrpCycle {
        self.at
    }

    /// Takes items from the queue that was chosen; they begin at SRP cycle `at`.
    pub fn begin(
        &mut self,
        at: SrpCycle,
        choice: Choice,
        most: usize,
        slot: &mut Slot,
        costs: &Costs,
        gather: &mut Gather,
    ) {
        let kernel = choice.queue.kernel;
        let most = if kernel == KernelId::Shade { most.min(gather.entries()) } else { most };
        self.rays.clear();
        self.items = slot.queues.take(choice.queue, most, &mut self.rays) as u64;
        (self.slot, self.kernel, self.at) = (choice.slot, kernel, at);
        (self.next, self.sent, self.complete, self.blocked) = (0, 0, false, false);
        self.inspector = costs.inspector(kernel, self.items);
        self.prologue = costs.prologue(kernel);
        self.branches = if costs.sorts() { 1 } else { branches(kernel, &self.rays, slot) };
        if kernel == KernelId::Shade {
            for (reader, &ray) in self.rays.iter().enumerate() {
                gather.add(reader as u8, &slot.work.rays[ray as usize]);
            }
        }
    }

    /// Goes as far as it can by cycle `now`.
    pub fn progress(&mut self, now: TiCycle, context: &mut BatchContext<'_>) -> Progress {
        if !self.kernel.emits() {
            return self.whole(now, context);
        }
        while let Some(&ray) = self.rays.get(self.next) {
            if !self.complete {
                match self.complete_item(now, ray, context) {
                    Progress::Ended => {}
                    waits => return waits,
                }
            }
            if !self.send(now, ray, context) {
                return Progress::Output;
            }
            context.slot.pending -= 1;
            (self.next, self.sent, self.complete) = (self.next + 1, 0, false);
        }
        Progress::Ended
    }

    /// Kernels that send nothing: all items count when the last is complete, since nobody sees them earlier.
    fn whole(&mut self, now: TiCycle, context: &mut BatchContext<'_>) -> Progress {
        let cycles = self.prologue + self.items * context.costs.interval(self.kernel, Sends::default()) * self.branches;
        let end = self.at + self.inspector + cycles;
        if context.clock.ti(end) > now {
            return Progress::At(context.clock.ti(end));
        }
        self.spend(cycles, context.counters);
        self.at = end;
        context.slot.pending -= self.items as u32;
        let kernel = &mut context.counters.kernels[self.kernel as usize];
        kernel.items += self.items;
        kernel.ops += self.items * context.costs.ops(self.kernel, Sends::default(), self.branches);
        Progress::Ended
    }

    fn complete_item(&mut self, now: TiCycle, ray: u32, context: &mut BatchContext<'_>) -> Progress {
        let sends = Sends::of(self.kernel, &context.slot.work.rays[ray as usize]);
        let cycles = self.prologue + context.costs.interval(self.kernel, sends) * self.branches;
        let computed = self.at + self.inspector + cycles;
        let ready =
            if self.kernel == KernelId::Shade { context.gather.ready(self.next) } else { Some(SrpCycle::START) };
        let Some(ready) = ready else { return Progress::Reads };
        let at = computed.max(ready);
        if context.clock.ti(at) > now {
            return Progress::At(context.clock.ti(at));
        }
        self.spend(cycles, context.counters);
        context.counters.activity.memory += at - computed;
        (self.at, self.inspector, self.prologue, self.complete) = (at, 0, 0, true);
        let kernel = &mut context.counters.kernels[self.kernel as usize];
        kernel.items += 1;
        kernel.ops += context.costs.ops(self.kernel, sends, self.branches);
        Progress::Ended
    }

    fn spend(&self, cycles: u64, counters: &mut ArrayCounters) {
        counters.activity.inspector += self.inspector;
        counters.activity.busy(self.kernel, cycles);
        counters.kernels[self.kernel as usize].cycles += cycles;
    }

    /// Sends the rays of the complete item. Returns whether all are out.
    fn send(&mut self, now: TiCycle, ray: u32, context: &mut BatchContext<'_>) -> bool {
        while let Some(sent) = sent_ray(self.kernel, &context.slot.work, ray, self.sent) {
            if context.output.len() >= context.output_rays {
                self.blocked = true;
                return false;
            }
            context.output.push_back(RayRef { slot: self.slot, ray: sent });
            context.slot.pending += 1;
            context.slot.rays_out += 1;
            *context.rays_out += 1;
            self.sent += 1;
        }
        if self.blocked {
            let at = self.at.max(context.clock.srp(now));
            context.counters.activity.output += at - self.at;
            (self.at, self.blocked) = (at, false);
        }
        true
    }
}

/// Branches that a mixed batch takes.
pub(super) fn branches(kernel: KernelId, rays: &[u32], slot: &Slot) -> u64 {
    match kernel {
        KernelId::Shade => {
            let material = |&ray: &u32| slot.work.rays[ray as usize].material;
            // Quadratic in the number of items, at most `gather_entries`, and of few different materials.
            let first = |(i, ray): &(usize, &u32)| !rays[..*i].iter().any(|r| material(r) == material(ray));
            rays.iter().enumerate().filter(first).count() as u64
        }
        KernelId::Similarity => {
            let both = slot.round().is_some_and(|w| w.interpolated > 0 && !w.starts.is_empty());
            1 + u64::from(both)
        }
        _ => 1,
    }
}

/// The kernel that takes a ray that came back.
#[inline]
pub fn taker(ray: &RayWork) -> KernelId {
    use crate::work::NO_TRIANGLE;
    use rayreel_formats::tile::RayKind;
    match ray {
        RayWork { kind: RayKind::Shadow, .. } => KernelId::ShadowResult,
        RayWork { triangle: NO_TRIANGLE, .. } => KernelId::Miss,
        _ => KernelId::Shade,
    }
}
