//! Primary visibility from a rasteriser.
//!
//! The rasteriser makes `raster.samples_per_cycle` samples of a round's primaries a T&I cycle. Their G-buffer goes through memory
//! (see `stream`): `gbuffer_bytes` a sample written, then read by the SRP, which takes them as primary hits, again at most
//! `samples_per_cycle` a cycle. The shading and geometry work of the rasteriser is not modelled. (Estimate.)

use std::collections::VecDeque;

use super::context::SrpPorts;
use super::per_cycle::PerCycle;
use super::stats::DmaCounters;
use super::stream::Stream;
use crate::component::{Component, Tick};
use crate::config::MachineConfig;
use crate::link::RayRef;
use crate::memory::Memory;
use crate::time::{TiCycle, When};
use crate::work::layout::Region;

/// The rasteriser of a core.
#[derive(Clone, Debug)]
pub struct Raster {
    /// Samples a cycle.
    rate: u64,
    waiting: VecDeque<RayRef>,
    stream: Stream,
    made: PerCycle,
    taken: PerCycle,
}

impl Raster {
    /// The rasteriser of core `core`.
    pub fn new(config: &MachineConfig, core: u32, ports: SrpPorts) -> Self {
        let address = Region::GBuffer.base() + (u64::from(core) << 32);
        let bytes = u64::from(config.raster.gbuffer_bytes);
        Self {
            rate: config.raster.samples_per_cycle.max(1).into(),
            waiting: VecDeque::new(),
            stream: Stream::new(config, ports.dma, (Region::GBuffer, address), bytes),
            made: PerCycle::default(),
            taken: PerCycle::default(),
        }
    }

    /// Asks for a primary.
    pub fn add(&mut self, ray: RayRef) {
        self.waiting.push_back(ray);
    }

    /// The next primary hit.
    pub fn take(&mut self, now: TiCycle) -> Option<RayRef> {
        let taken = self.taken.used(now);
        if *taken == self.rate {
            return None;
        }
        let ray = self.stream.pop();
        *taken += u64::from(ray.is_some());
        ray
    }

    /// A line arrived; `false` if it is not of the G-buffer.
    pub fn respond(&mut self, line: u64) -> bool {
        let mine = self.stream.owns(line);
        if mine {
            self.stream.respond(line);
        }
        mine
    }

    /// Whether memory refused a request.
    pub fn refused(&self) -> bool {
        self.stream.refused()
    }

    /// What the G-buffer moved so far.
    pub fn counters(&self) -> &DmaCounters {
        self.stream.counters()
    }
}

impl Component for Raster {
    type Report = DmaCounters;

    fn next_event(&self, now: TiCycle) -> When {
        let busy = !self.waiting.is_empty() || self.stream.has_ready();
        self.stream.next_event(now).min(When::only_if(busy, now + 1))
    }

    fn finish(&mut self, end: TiCycle) -> DmaCounters {
        self.stream.finish(end)
    }
}

impl<M: Memory> Tick<&mut M> for Raster {
    /// Makes samples and moves lines.
    fn tick(&mut self, now: TiCycle, memory: &mut M) {
        let made = self.made.used(now);
        while *made < self.rate {
            let Some(ray) = self.waiting.pop_front() else { break };
            self.stream.push(now, ray);
            *made += 1;
            if self.waiting.is_empty() {
                self.stream.close();
            }
        }
        self.stream.tick(now, memory);
    }
}
