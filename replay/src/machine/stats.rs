//! What a run of the machine counted: everything, by unit, as integers. Ratios are made in the report.

use super::memory::Cycle;
use super::memory::dram::ChannelCounters;
use super::memory::l1::CacheCounters;
use super::memory::l2::L2Counters;
use super::memory::system::{MemorySystem, Traffic};
use super::srp::SrpStats;
use super::ti::TiStats;

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
