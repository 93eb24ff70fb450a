//! Kernels on the threads of processors: a machine without an array.
//!
//! While a place for a warp is free, the queue that an array would run next gives a warp of items: at most `processor.lanes`.
//! Items of a warp that take another branch or another number of operations than the longest wait for it. Reads of `shade` go
//! through the data cache of the processor.

use super::batch::{Choosing, choose, sent_ray};
use super::gather::ShadeReads;
use super::kernels::{Costs, KERNELS, KernelId, Sends};
use super::slots::TileSlots;
use super::stats::ArrayCounters;
use crate::config::MachineConfig;
use crate::link::{Job, RayRef, RayUnit};
use crate::time::TiCycle;
use crate::traversal::CodeLayout;
use crate::work::layout::{Layout, Lines, Region};

/// Items that a warp has.
#[derive(Clone, Debug)]
struct Items {
    slot: u8,
    kernel: KernelId,
    count: u32,
    rays: Vec<u32>,
    operations: u64,
}

/// The items that processors have, and where the code of kernels lies.
pub struct OnThreads {
    lanes: usize,
    reads: ShadeReads,
    code: [Lines; KERNELS],
    /// By tag.
    given: Vec<Option<Items>>,
    under_way: usize,
}

impl OnThreads {
    /// Of a machine whose kernels cost so much.
    pub fn new(config: &MachineConfig, layout: Layout, costs: &Costs) -> Self {
        let mut code = CodeLayout::behind_traversal(config, &layout);
        let most = Sends { shadows: 2, known: 0, secondary: 1 };
        let instructions =
            |kernel| costs.ops(kernel, if kernel == KernelId::Shade { most } else { Sends::default() }, 1);
        Self {
            lanes: config.processor.lanes as usize,
            reads: ShadeReads::new(config, layout),
            code: KernelId::ALL.map(|kernel| code.next(instructions(kernel))),
            given: Vec::new(),
            under_way: 0,
        }
    }

    /// Whether items are under way.
    pub fn is_running(&self) -> bool {
        self.under_way > 0
    }

    /// Takes note of warps of items that are done: their rays go to `output`.
    pub fn finish<U: RayUnit>(
        &mut self,
        unit: &mut U,
        tiles: &mut TileSlots,
        output: &mut impl Extend<RayRef>,
        counters: &mut ArrayCounters,
    ) -> bool {
        let mut worked = false;
        while let Some(tag) = unit.finished_job() {
            let Some(items) = self.given.get_mut(tag as usize).and_then(Option::take) else { continue };
            self.under_way -= 1;
            worked = true;
            let (slot, rays_out) = tiles.slot_mut(items.slot.into());
            let mut sent = 0;
            for &ray in &items.rays {
                for k in 0.. {
                    let Some(child) = sent_ray(items.kernel, &slot.work, ray, k) else { break };
                    output.extend([RayRef { slot: items.slot, ray: child }]);
                    sent += 1;
                }
            }
            slot.pending = slot.pending + sent - items.count;
            slot.rays_out += sent;
            *rays_out += sent as usize;
            let counted = &mut counters.kernels[items.kernel as usize];
            counted.items += u64::from(items.count);
            counted.ops += items.operations;
        }
        worked
    }

    /// Gives a warp of items to the processors, if one is ready and there is room; whether it did.
    pub fn start<U: RayUnit>(
        &mut self,
        now: TiCycle,
        unit: &mut U,
        tiles: &mut TileSlots,
        (costs, choosing, counters): (&Costs, Choosing, &mut ArrayCounters),
    ) -> bool {
        if unit.job_room() == 0 {
            return false;
        }
        let Some(choice) = choose(tiles.all(), choosing) else { return false };
        let (slot, kernel) = (choice.slot, choice.queue.kernel);
        let (tile, _) = tiles.slot_mut(slot.into());
        let mut rays = Vec::with_capacity(self.lanes);
        let count = tile.queues.take(choice.queue, self.lanes, &mut rays) as u32;
        let (mut longest, mut operations) = (0, 0);
        let mut reads: Vec<(u64, Region)> = Vec::new();
        // A thread by itself takes one branch.
        let branches = if costs.sorts() || self.lanes == 1 { 1 } else { super::batch::branches(kernel, &rays, tile) };
        for &ray in &rays {
            let work = &tile.work.rays[ray as usize];
            let ops = costs.ops(kernel, Sends::of(kernel, work), branches);
            (longest, operations) = (ops.max(longest), operations + ops);
            if kernel == KernelId::Shade {
                for read in self.reads.lines(work) {
                    if !reads.contains(&read) {
                        reads.push(read);
                    }
                }
            }
        }
        if rays.is_empty() {
            longest = costs.ops(kernel, Sends::default(), branches);
            operations = longest * u64::from(count);
        }
        let tag = self.given.iter().position(Option::is_none).unwrap_or_else(|| {
            self.given.push(None);
            self.given.len() - 1
        });
        self.given[tag] = Some(Items { slot, kernel, count, rays, operations });
        self.under_way += 1;
        counters.kernels[kernel as usize].batches += 1;
        let code = self.code[kernel as usize];
        unit.push_job(now, Job { tag: tag as u32, lanes: count, longest, operations, code, reads });
        true
    }
}
