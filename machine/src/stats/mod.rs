//! What a run of the machine counted: everything, by unit, as integers. Ratios are made in the report.

mod estimated;
mod places;
#[cfg(test)]
mod tests;
mod work_done;

use crate::memory::{CacheCounters, MemoryStats};
use crate::srp::SrpStats;
use crate::ti::{IstStats, TiStats, TrvStats};
use crate::traversal::ProcessorStats;

/// One core.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CoreStats {
    /// T&I unit; processors stand in the list of its traversal units.
    pub ti: TiStats,
    /// What only processors count (`ti.pipeline = "software"`).
    pub processors: Vec<ProcessorStats>,
    /// SRP, interface and DMA.
    pub srp: SrpStats,
    /// The SRP's L1.
    pub srp_l1: CacheCounters,
    /// Length of the run in SRP cycles.
    pub srp_cycles: u64,
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Length of the run, cycles of the T&I clock.
    pub cycles: u64,
    /// Tiles.
    pub tiles: u64,
    /// Cores.
    pub cores: Vec<CoreStats>,
    /// L2, DRAM and traffic.
    pub memory: MemoryStats,
}

impl Stats {
    /// Adds another run of the same machine, unit by unit.
    pub fn add(&mut self, other: &Self) {
        if self.cores.is_empty() {
            self.clone_from(other);
            return;
        }
        self.cycles += other.cycles;
        self.tiles += other.tiles;
        self.cores.iter_mut().zip(&other.cores).for_each(|(core, more)| core.add(more));
        self.memory.add(&other.memory);
    }

    /// All traversal units of all cores.
    pub fn trv(&self) -> impl Iterator<Item = &TrvStats> {
        self.cores.iter().flat_map(|core| &core.ti.trv)
    }

    /// All intersection units of all cores.
    pub fn ist(&self) -> impl Iterator<Item = &IstStats> {
        self.cores.iter().flat_map(|core| &core.ti.ist)
    }

    /// All processors of all cores.
    pub fn processors(&self) -> impl Iterator<Item = &ProcessorStats> {
        self.cores.iter().flat_map(|core| &core.processors)
    }

    /// Rays that the T&I units took.
    pub fn rays(&self) -> u64 {
        self.cores.iter().map(|core| core.ti.dispatch.rays).sum()
    }
}

impl CoreStats {
    fn add(&mut self, other: &Self) {
        self.ti.dispatch += other.ti.dispatch;
        for (trv, more) in self.ti.trv.iter_mut().zip(&other.ti.trv) {
            trv.stages.iter_mut().zip(&more.stages).for_each(|(stage, more)| stage.1 += more.1);
            trv.events += more.events;
            trv.buffer += more.buffer;
            trv.l1 += more.l1;
        }
        for (ist, more) in self.ti.ist.iter_mut().zip(&other.ti.ist) {
            ist.activity += more.activity;
            ist.events += more.events;
            ist.buffer += more.buffer;
            ist.l1 += more.l1;
        }
        for (processor, more) in self.processors.iter_mut().zip(&other.processors) {
            processor.counters += more.counters;
            processor.code_l1 += more.code_l1;
        }
        self.srp.kernels.iter_mut().zip(&other.srp.kernels).for_each(|(kernel, more)| *kernel += *more);
        self.srp.activity += other.srp.activity;
        self.srp.interface += other.srp.interface;
        self.srp.dma += other.srp.dma;
        self.srp.raster += other.srp.raster;
        self.srp.local += other.srp.local;
        self.srp_l1 += other.srp_l1;
        self.srp_cycles += other.srp_cycles;
    }
}
