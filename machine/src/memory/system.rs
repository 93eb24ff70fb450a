//! The memory system: the shared L2 and the DRAM behind it, as one [`Memory`].
//!
//! Reads past the L2 ([`Route::Read`]) and writes ([`Route::Write`]) go to the DRAM's queues directly, in the cycle in which they
//! are accepted. They neither look at the L2 nor change it: rays, samples and pixels never share lines with cached regions.
//! A read does not look into the write queue either.

use super::dram::{ChannelCounters, Dram};
use super::l2::{L2Cache, L2Counters};
use super::{Cycle, Memory, Port, Request, Response, Route};
use crate::config::{self, MachineConfig};
use crate::work::layout::Region;

/// Marks the token of a read past the L2; the rest is its port.
const DIRECT: u32 = 1 << 31;

/// Bytes at the DRAM by what they are for, in the order of [`Region::ALL`]. Counted when the DRAM's queue takes the request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes read.
    pub read: [u64; Region::ALL.len()],
    /// Bytes written.
    pub written: [u64; Region::ALL.len()],
}

impl Traffic {
    /// All bytes.
    pub fn total(&self) -> u64 {
        self.read.iter().chain(&self.written).sum()
    }
}

/// L2 and DRAM.
#[derive(Clone, Debug)]
pub struct MemorySystem {
    l2: L2Cache,
    dram: Dram,
    now: Cycle,
    arrived: Vec<Response>,
    line_bytes: u64,
    burst_bytes: u64,
    traffic: Traffic,
}

impl MemorySystem {
    /// The memory system of a machine, idle and empty.
    pub fn new(config: &MachineConfig) -> Self {
        Self::of(config.ti.clock_mhz, &config.l2, &config.dram)
    }

    /// An L2 in a clock of `clock_mhz`, and DRAM.
    pub fn of(clock_mhz: u32, l2: &config::L2, dram: &config::Dram) -> Self {
        Self {
            l2: L2Cache::new(l2),
            dram: Dram::new(dram, clock_mhz, l2.line_bytes),
            now: 0,
            arrived: Vec::new(),
            line_bytes: l2.line_bytes.into(),
            burst_bytes: dram.burst_bytes.into(),
            traffic: Traffic::default(),
        }
    }

    /// Runs up to and including `now`, from event to event.
    #[inline]
    fn advance(&mut self, now: Cycle) {
        if now <= self.now {
            return;
        }
        while let Some(next) = self.next_due()
            && next <= now
        {
            self.step(next);
        }
        self.dram.run(now);
        self.now = now;
    }

    #[inline]
    fn next_due(&self) -> Option<Cycle> {
        match (self.l2.next_event(self.now), self.dram.next_event()) {
            (Some(l2), Some(dram)) => Some(l2.min(dram)),
            (l2, dram) => l2.or(dram),
        }
    }

    fn step(&mut self, now: Cycle) {
        self.now = now;
        self.dram.run(now);
        while let Some(arrival) = self.dram.take(now) {
            if arrival.token & DIRECT == 0 {
                self.l2.fill(arrival.token, &mut self.arrived);
            } else {
                let port = Port((arrival.token & !DIRECT) as u16);
                self.arrived.push(Response { port, line: arrival.line });
            }
        }
        let (traffic, bytes) = (&mut self.traffic, self.line_bytes);
        self.l2.tick(now, &mut self.dram, &mut self.arrived, |region| traffic.read[region as usize] += bytes);
    }

    /// What the L2 did.
    pub fn l2(&self) -> &L2Cache {
        &self.l2
    }

    /// Counters of the L2.
    pub fn l2_counters(&self) -> &L2Counters {
        self.l2.counters()
    }

    /// Counters of each channel.
    pub fn channels(&self) -> impl Iterator<Item = &ChannelCounters> {
        self.dram.counters()
    }

    /// Counters of all channels, added.
    pub fn dram_counters(&self) -> ChannelCounters {
        let mut sum = ChannelCounters::default();
        self.channels().for_each(|channel| sum += *channel);
        sum
    }

    /// Bytes at the DRAM.
    pub fn traffic(&self) -> &Traffic {
        &self.traffic
    }
}

impl Memory for MemorySystem {
    fn request(&mut self, now: Cycle, request: Request) -> bool {
        self.advance(now);
        let Request { port, line, region, route } = request;
        let bytes = match route {
            Route::Cached => return self.l2.request(port, line, region),
            Route::Read => &mut self.traffic.read,
            Route::Write => &mut self.traffic.written,
        };
        let taken = self.dram.request(now, now, line, route == Route::Write, DIRECT | u32::from(port.0));
        bytes[region as usize] += if taken { self.line_bytes } else { 0 };
        taken
    }

    fn tick(&mut self, now: Cycle, arrived: &mut Vec<Response>) {
        self.advance(now);
        arrived.append(&mut self.arrived);
    }

    fn next_event(&self) -> Option<Cycle> {
        if self.arrived.is_empty() { self.next_due() } else { Some(self.now) }
    }

    fn bytes_moved(&self) -> u64 {
        let dram = self.dram_counters();
        (dram.reads + dram.writes) * self.burst_bytes
    }

    fn take_evicted(&mut self) -> Vec<u64> {
        self.l2.take_evicted()
    }
}

#[cfg(test)]
#[path = "system_tests.rs"]
mod tests;
