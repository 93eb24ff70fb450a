//! Which counters do not depend on time.

use crate::config::{Divergence, Interface, MachineConfig, Pipeline, PrimaryVisibility};
use crate::memory::{CacheCounters, ChannelCounters, L2Counters};
use crate::srp::{DmaCounters, InterfaceCounters, KernelId, LocalCounters, RasterCounters};
use crate::stats::Stats;
use crate::ti::{InputBufferCounters, IstCounters, TrvCounters};
use crate::work::layout::Region;

/// The counters whose sums over all units are the same whenever things happen are 1, all others 0.
pub fn exact_counters(config: &MachineConfig) -> Stats {
    let mut exact = Stats::shaped(config);
    exact.tiles = 1;
    let alone = config.ti.pipeline == Pipeline::Software && config.processor.lanes == 1;
    let predicated = config.srp.divergence == Divergence::Naive && !alone;
    for core in &mut exact.cores {
        core.ti.dispatch.rays = 1;
        for unit in &mut core.ti.trv {
            unit.events = TrvCounters {
                rays: 1,
                node_visits: 1,
                restart_visits: 1,
                box_tests: 1,
                leaves: 1,
                triangle_tests: 1,
                stack_operations: 1,
                culled: 1,
                pushes: 1,
                restarts: 1,
                bypasses: 0,
                ray_cycles: 0,
            };
        }
        for unit in &mut core.ti.ist {
            unit.events = IstCounters { tasks: 1, triangle_tests: 1, bypasses: 0 };
        }
        for (id, kernel) in KernelId::ALL.into_iter().zip(&mut core.srp.kernels) {
            // Predicated, an item does the operations of the branches of its batch.
            (kernel.items, kernel.ops) = (1, u64::from(!predicated || !id.branches()));
        }
        core.srp.interface =
            InterfaceCounters { rays: 1, hits: 1, ray_bytes: 1, hit_bytes: 1, ray_busy: 1, hit_busy: 1 };
        core.srp.local = LocalCounters { reads: 1, writes: 1, spilled_samples: 1, tiles: 1 };
        core.srp.raster = RasterCounters { triangles: 1, samples: 1 };
        core.srp.dma = DmaCounters {
            framebuffer_written: 1,
            sample_written: 1,
            sample_read: 1,
            border_written: 1,
            border_read: 1,
            history_written: 1,
            history_read: 1,
            ..streams(config)
        };
        core.srp_l1.lookups = 1;
    }
    let traffic = &mut exact.memory.traffic;
    for region in [Region::Framebuffer, Region::Sample, Region::Border, Region::History] {
        (traffic.read[region as usize], traffic.written[region as usize]) = (1, 1);
    }
    exact
}

/// The counters that a machine without time counts, exactly or nearly so, are 1, all others 0: whatever else happens takes time.
pub fn counted_counters(config: &MachineConfig) -> Stats {
    let mut counted = exact_counters(config);
    let buffer = InputBufferCounters { record_writes: 1, record_reads: 1, ..InputBufferCounters::default() };
    let l1 = CacheCounters { lookups: 1, hits: 1, misses: 1, fills: 1, evictions: 1, ..CacheCounters::default() };
    for core in &mut counted.cores {
        core.ti.trv.iter_mut().for_each(|unit| (unit.buffer, unit.l1) = (buffer, l1));
        core.ti.ist.iter_mut().for_each(|unit| (unit.buffer, unit.l1) = (buffer, l1));
        core.srp_l1 = l1;
        core.srp.dma.each_mut(|_, counter| *counter = 1);
    }
    let memory = &mut counted.memory;
    memory.l2 = L2Counters { lookups: 1, hits: 1, misses: 1, fills: 1, evictions: 1, ..L2Counters::default() };
    for channel in &mut memory.channels {
        // Which rows are open depends on when they are closed.
        *channel = ChannelCounters { reads: 1, writes: 1, read_lines: 1, write_lines: 1, ..ChannelCounters::default() };
    }
    for region in Region::ALL.into_iter().filter(|region| *region != Region::Code) {
        (memory.traffic.read[region as usize], memory.traffic.written[region as usize]) = (1, 1);
    }
    counted
}

/// Streams write lines that are not full after some time; where there is no stream their bytes are known to be none.
fn streams(config: &MachineConfig) -> DmaCounters {
    let rays = u64::from(config.gpu.interface == Interface::Direct);
    let gbuffer = u64::from(config.gpu.primary_visibility != PrimaryVisibility::Raster);
    DmaCounters {
        gbuffer_written: gbuffer,
        gbuffer_read: gbuffer,
        ray_written: rays,
        ray_read: rays,
        ..DmaCounters::default()
    }
}
