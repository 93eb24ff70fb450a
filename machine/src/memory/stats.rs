//! What the memory behind the L1s counted.

use super::dram::ChannelCounters;
use super::l2::L2Counters;
use super::traffic::Traffic;

/// L2, DRAM and traffic: what the cores share.
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
    /// All channels, added.
    pub fn dram(&self) -> ChannelCounters {
        let mut sum = ChannelCounters::default();
        self.channels.iter().for_each(|channel| sum += *channel);
        sum
    }

    /// Adds another run of the same machine, channel by channel.
    pub fn add(&mut self, other: &Self) {
        self.l2 += other.l2;
        self.channels.iter_mut().zip(&other.channels).for_each(|(sum, channel)| *sum += *channel);
        self.traffic += other.traffic;
    }
}
