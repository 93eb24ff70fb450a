//! All counters of a run as one list of numbers.
//!
//! A counter of one kind stands in many units: its *kind* is the same in all of them, so that sums over units can be made.

use super::{CoreStats, Stats};
use crate::config::{MachineConfig, Pipeline};
use crate::counters::Activity;
use crate::memory::ChannelCounters;
use crate::srp::KERNELS;
use crate::ti::{IstStats, TiStats, TrvStats};
use crate::traversal::ProcessorStats;

/// Places between the kinds of two groups of counters: no group has as many.
const GROUP: usize = 32;

impl Stats {
    /// Zeros, for the units of a machine.
    pub fn shaped(config: &MachineConfig) -> Self {
        let ti = &config.ti;
        let stages = crate::ti::stage_names(ti.pipeline).iter().map(|name| (*name, Activity::default())).collect();
        let processors = if ti.pipeline == Pipeline::Software { ti.trv } else { 0 };
        let trv = TrvStats { stages, ..TrvStats::default() };
        let ti = TiStats {
            trv: vec![trv; ti.trv as usize],
            ist: vec![IstStats::default(); ti.ist as usize],
            ..TiStats::default()
        };
        let processors = vec![ProcessorStats::default(); processors as usize];
        let core = CoreStats { ti, processors, ..CoreStats::default() };
        let mut stats = Self { cores: vec![core; config.gpu.cores as usize], ..Self::default() };
        stats.memory.channels = vec![ChannelCounters::default(); config.dram.channels as usize];
        stats
    }

    /// Calls `visit` with the kind of each counter and the counter: always in the same order for the same machine.
    pub fn each_mut(&mut self, mut visit: impl FnMut(usize, &mut u64)) {
        let mut group = 0;
        let mut next = || {
            group += GROUP;
            group - GROUP
        };
        let visit = &mut visit;
        let run = next();
        visit(run, &mut self.cycles);
        visit(run + 1, &mut self.tiles);
        let [dispatch, stages, trv, trv_buffer, trv_l1] = [(); 5].map(|()| next());
        // A unit has three stages at most.
        let [_, _, activity, ist, ist_buffer, ist_l1] = [(); 6].map(|()| next());
        let kernels = [(); KERNELS].map(|()| next())[0];
        let [srp, interface, dma, local, srp_l1] = [(); 5].map(|()| next());
        let [l2, channel, read, written, processor, code_l1, raster] = [(); 7].map(|()| next());
        for core in &mut self.cores {
            visit(run + 2, &mut core.srp_cycles);
            core.ti.dispatch.each_mut(|i, c| visit(dispatch + i, c));
            for unit in &mut core.ti.trv {
                for (stage, (_, account)) in unit.stages.iter_mut().enumerate() {
                    account.each_mut(|i, c| visit(stages + stage * GROUP / 4 + i, c));
                }
                unit.events.each_mut(|i, c| visit(trv + i, c));
                unit.buffer.each_mut(|i, c| visit(trv_buffer + i, c));
                unit.l1.each_mut(|i, c| visit(trv_l1 + i, c));
            }
            for unit in &mut core.ti.ist {
                unit.activity.each_mut(|i, c| visit(activity + i, c));
                unit.events.each_mut(|i, c| visit(ist + i, c));
                unit.buffer.each_mut(|i, c| visit(ist_buffer + i, c));
                unit.l1.each_mut(|i, c| visit(ist_l1 + i, c));
            }
            for unit in &mut core.processors {
                unit.counters.each_mut(|i, c| visit(processor + i, c));
                unit.code_l1.each_mut(|i, c| visit(code_l1 + i, c));
            }
            for (number, kernel) in core.srp.kernels.iter_mut().enumerate() {
                kernel.each_mut(|i, c| visit(kernels + number * GROUP + i, c));
            }
            core.srp.activity.each_mut(|i, c| visit(srp + i, c));
            core.srp.interface.each_mut(|i, c| visit(interface + i, c));
            core.srp.dma.each_mut(|i, c| visit(dma + i, c));
            core.srp.raster.each_mut(|i, c| visit(raster + i, c));
            core.srp.local.each_mut(|i, c| visit(local + i, c));
            core.srp_l1.each_mut(|i, c| visit(srp_l1 + i, c));
        }
        self.memory.l2.each_mut(|i, c| visit(l2 + i, c));
        for counters in &mut self.memory.channels {
            counters.each_mut(|i, c| visit(channel + i, c));
        }
        let traffic = &mut self.memory.traffic;
        traffic.read.iter_mut().enumerate().for_each(|(i, c)| visit(read + i, c));
        traffic.written.iter_mut().enumerate().for_each(|(i, c)| visit(written + i, c));
    }

    /// All counters, in the order of [`Stats::each_mut`].
    pub fn list(&self) -> Vec<f64> {
        let mut all = Vec::new();
        self.clone().each_mut(|_, counter| all.push(*counter as f64));
        all
    }

    /// The counters of a run of the same machine as `self`, from a list; what is no count is rounded, or 0.
    #[must_use]
    pub fn with_list(&self, list: &[f64]) -> Self {
        let (mut stats, mut values) = (self.clone(), list.iter());
        stats.each_mut(|_, counter| *counter = values.next().map_or(0, |value| value.round().max(0.0) as u64));
        stats
    }
}
