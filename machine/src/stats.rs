//! What a run of the machine counted: everything, by unit, as integers. Ratios are made in the report.

use super::memory::Cycle;
use super::memory::dram::ChannelCounters;
use super::memory::l1::CacheCounters;
use super::memory::l2::L2Counters;
use super::memory::system::{MemorySystem, Traffic};
use super::srp::SrpStats;
use super::ti::TiStats;
use super::ti::ist::IstStats;
use super::ti::trv::TrvStats;

/// One core.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CoreStats {
    /// T&I unit.
    pub ti: TiStats,
    /// SRP, interface and DMA.
    pub srp: SrpStats,
    /// The SRP's L1.
    pub srp_l1: CacheCounters,
    /// Length of the run in SRP cycles.
    pub srp_cycles: u64,
}

/// What the cores share.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MemoryStats {
    /// L2.
    pub l2: L2Counters,
    /// Each DRAM channel.
    pub channels: Vec<ChannelCounters>,
    /// Bytes at the DRAM by what they are for.
    pub traffic: Traffic,
}

impl MemoryStats {
    /// The counters of a memory system.
    pub fn of(memory: &MemorySystem) -> Self {
        Self { l2: *memory.l2_counters(), channels: memory.channels().copied().collect(), traffic: *memory.traffic() }
    }

    /// All channels, added.
    pub fn dram(&self) -> ChannelCounters {
        let mut sum = ChannelCounters::default();
        self.channels.iter().for_each(|channel| sum += *channel);
        sum
    }
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Length of the run, cycles of the T&I clock.
    pub cycles: Cycle,
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
        self.cores.iter_mut().zip(&other.cores).for_each(|(own, more)| own.add(more));
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

    /// Rays that the T&I units took.
    pub fn rays(&self) -> u64 {
        self.cores.iter().map(|core| core.ti.dispatch.rays).sum()
    }
}

impl CoreStats {
    fn add(&mut self, other: &Self) {
        self.ti.dispatch += other.ti.dispatch;
        for (own, more) in self.ti.trv.iter_mut().zip(&other.ti.trv) {
            own.stages.iter_mut().zip(&more.stages).for_each(|(own, more)| own.1 += more.1);
            own.events += more.events;
            own.front += more.front;
            own.l1 += more.l1;
        }
        for (own, more) in self.ti.ist.iter_mut().zip(&other.ti.ist) {
            own.activity += more.activity;
            own.events += more.events;
            own.front += more.front;
            own.l1 += more.l1;
        }
        self.srp.kernels.iter_mut().zip(&other.srp.kernels).for_each(|(own, more)| *own += *more);
        self.srp.activity += other.srp.activity;
        self.srp.interface += other.srp.interface;
        self.srp.dma += other.srp.dma;
        self.srp.local += other.srp.local;
        self.srp_l1 += other.srp_l1;
        self.srp_cycles += other.srp_cycles;
    }
}

impl MemoryStats {
    fn add(&mut self, other: &Self) {
        self.l2 += other.l2;
        self.channels.iter_mut().zip(&other.channels).for_each(|(own, more)| *own += *more);
        let (own, more) = (&mut self.traffic, &other.traffic);
        own.read.iter_mut().zip(&more.read).for_each(|(own, more)| *own += more);
        own.written.iter_mut().zip(&more.written).for_each(|(own, more)| *own += more);
    }
}
