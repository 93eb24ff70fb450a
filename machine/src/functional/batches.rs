//! What a core does next: which batch its SRP runs, by the rules of the SRP as far as they need no time.
//!
//! One rule differs: a simulated SRP stands still until the last ray of a batch is in the output queue, while here it may run batches
//! that send nothing meanwhile. Standing still makes what is read from DRAM worse as long as rays take turns
//! (`docs/accuracy.md`, reads from DRAM).

use std::cmp::Reverse;

use super::in_flight::InFlight;
use crate::config::MachineConfig;
use crate::srp::{KernelId, QueueId};

/// What a core does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    /// The tile of a slot, of which nothing waits, takes its next step.
    Step(usize),
    /// The SRP runs a batch: slot, queue, and most items.
    Batch(usize, QueueId, usize),
    /// The T&I unit works.
    Trace,
}

/// Which queue comes first: the largest rank.
type Rank = (bool, usize, Reverse<usize>);

/// The rules of batches.
pub(super) struct Batches {
    /// The SRP takes no time.
    is_ideal: bool,
    /// Items of a batch.
    least: usize,
    most: usize,
    most_of_shade: usize,
    /// Rays that the T&I unit holds, and how many are few.
    room: usize,
    low: usize,
    /// Rays that the output queue holds, and how many are too many for primary rays.
    output: usize,
    output_high: usize,
}

impl Batches {
    pub fn new(config: &MachineConfig) -> Self {
        let srp = &config.srp;
        Self {
            is_ideal: srp.ideal,
            least: srp.batch_min.max(1) as usize,
            most: srp.batch_max.max(1) as usize,
            most_of_shade: srp.batch_max.min(srp.gather_entries).max(1) as usize,
            room: config.unit_rays() as usize,
            low: config.low_rays() as usize,
            output: srp.output_rays as usize,
            output_high: config.output_high_rays() as usize,
        }
    }

    /// What a core with these tiles does next while so many of its rays are in the T&I unit; its SRP may run a batch if it is free.
    pub fn next(&self, slots: &[Option<InFlight>], rays: usize, is_free: bool) -> Turn {
        let idle = |tile: &InFlight| tile.rays_out == 0 && tile.rest.queues.items() == 0;
        if let Some(slot) = slots.iter().position(|tile| tile.as_ref().is_some_and(idle)) {
            return Turn::Step(slot);
        }
        if !self.is_ideal && !is_free {
            return Turn::Trace;
        }
        let (low, output) = (rays < self.low, rays.saturating_sub(self.room));
        let mut best: Option<(Rank, Turn)> = None;
        for (slot, tile) in slots.iter().enumerate() {
            let Some(tile) = tile else { continue };
            tile.rest.queues.each(|queue, items| {
                let most = self.most(queue.kernel, rays);
                let emits = queue.kernel.emits();
                let rank = if self.is_ideal {
                    // Hits first; rays are started as far as there is room for them beside those.
                    (queue.kernel != KernelId::Raygen, usize::MAX - slot, Reverse(0))
                } else {
                    (low && emits, items, Reverse(tile.number))
                };
                let grows = queue.kernel != KernelId::Raygen && tile.rays_out > 0;
                let ready = self.is_ideal || items >= self.least || !grows || low && emits;
                // While its output queue is full the SRP stands still, and primary rays are not begun long before.
                let most_out = if queue.kernel == KernelId::Raygen { self.output_high + 1 } else { self.output };
                let waits = !self.is_ideal && emits && output >= most_out;
                if most > 0 && ready && !waits && best.as_ref().is_none_or(|(other, _)| rank > *other) {
                    best = Some((rank, Turn::Batch(slot, queue, most)));
                }
            });
        }
        best.map_or(Turn::Trace, |(_, turn)| turn)
    }

    /// Most items of a batch.
    fn most(&self, kernel: KernelId, rays: usize) -> usize {
        match kernel {
            KernelId::Raygen if self.is_ideal => self.room.saturating_sub(rays),
            _ if self.is_ideal => usize::MAX,
            KernelId::Shade => self.most_of_shade,
            _ => self.most,
        }
    }
}
