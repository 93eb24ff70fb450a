//! The memory system: the shared L2 and the DRAM behind it, as one [`Memory`].
//!
//! Reads past the L2 ([`Route::Read`]) and writes ([`Route::Write`]) go to the DRAM's queues directly, in the cycle in which they
//! are accepted. They neither look at the L2 nor change it: rays, samples and pixels never share lines with cached regions.
//! A read does not look into the write queue either.

use crate::component::{Component, Tick};
use crate::config::{self, MachineConfig};
use crate::memory::dram::{ChannelCounters, Dram, LineRead};
use crate::memory::interface::Memory;
use crate::memory::l2::{L2Cache, L2Context, L2Counters};
use crate::memory::request::{Port, Request, Response, Route};
use crate::memory::stats::MemoryStats;
use crate::memory::tags::Tags;
use crate::memory::traffic::Traffic;
use crate::time::{ClockCycle, TiCycle, When};

/// Marks the token of a read past the L2; the rest is its port.
const DIRECT: u32 = 1 << 31;

/// L2 and DRAM.
#[derive(Clone, Debug)]
pub struct MemorySystem {
    l2: L2Cache,
    dram: Dram,
    now: TiCycle,
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
            now: TiCycle::START,
            arrived: Vec::new(),
            line_bytes: l2.line_bytes.into(),
            burst_bytes: dram.burst_bytes.into(),
            traffic: Traffic::default(),
        }
    }

    /// Runs up to and including `now`, from event to event.
    #[inline]
    fn advance(&mut self, now: TiCycle) {
        if now > self.now {
            self.run(now);
        }
    }

    fn run(&mut self, now: TiCycle) {
        while let Some(next) = self.next_due().due(now) {
            self.step(next);
        }
        self.dram.tick(now, ());
        self.now = now;
    }

    #[inline]
    fn next_due(&self) -> When {
        self.l2.next_event(self.now).min(self.dram.next_event(self.now))
    }

    fn step(&mut self, now: TiCycle) {
        self.now = now;
        self.dram.tick(now, ());
        while let Some(LineRead { line, token }) = self.dram.take(now) {
            if token & DIRECT == 0 {
                self.l2.fill(token, &mut self.arrived);
            } else {
                self.arrived.push(Response { port: Port((token & !DIRECT) as u16), line });
            }
        }
        let (dram, traffic, arrived) = (&mut self.dram, &mut self.traffic, &mut self.arrived);
        self.l2.tick(now, L2Context { dram, traffic, arrived });
    }

    /// Fills the empty L2.
    pub(crate) fn warm(&mut self, tags: &Tags) {
        self.l2.warm(tags);
    }

    /// What was counted before `end`.
    pub(crate) fn report(&self, end: TiCycle) -> MemoryStats {
        MemoryStats { l2: *self.l2.counters(), channels: self.dram.counters_before(end), traffic: self.traffic }
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
    fn request(&mut self, now: TiCycle, request: Request) -> bool {
        self.advance(now);
        let Request { port, line, region, route } = request;
        let direct = LineRead { line, token: DIRECT | u32::from(port.0) };
        let (taken, bytes) = match route {
            Route::Cached => return self.l2.request(port, line, region),
            Route::Read => (self.dram.read(now, now, direct), &mut self.traffic.read),
            Route::Write => (self.dram.write(now, line), &mut self.traffic.written),
        };
        bytes[region as usize] += if taken { self.line_bytes } else { 0 };
        taken
    }

    fn bytes_moved(&self) -> u64 {
        let dram = self.dram_counters();
        (dram.reads + dram.writes) * self.burst_bytes
    }

    fn take_evicted(&mut self) -> Vec<u64> {
        self.l2.take_evicted()
    }
}

impl Component for MemorySystem {
    type Report = MemoryStats;

    fn next_event(&self, now: TiCycle) -> When {
        if self.arrived.is_empty() { self.next_due().after(now) } else { When::at(now + 1) }
    }

    fn finish(&mut self, end: TiCycle) -> MemoryStats {
        MemoryStats { l2: self.l2.finish(end), channels: self.dram.finish(end), traffic: self.traffic }
    }
}

impl Tick<&mut Vec<Response>> for MemorySystem {
    fn tick(&mut self, now: TiCycle, arrived: &mut Vec<Response>) {
        self.advance(now);
        arrived.append(&mut self.arrived);
    }
}

#[cfg(test)]
mod tests;
