//! Primary visibility from a rasteriser.
//!
//! The rasteriser makes `raster.samples_per_cycle` samples of a wave's primaries a T&I cycle. Their G-buffer goes through memory
//! (see `stream`): `gbuffer_bytes` a sample written, then read by the SRP, which takes them as primary hits, again at most
//! `samples_per_cycle` a cycle. Its own shading and geometry work is not modelled. (Estimate.)

use std::collections::VecDeque;

use super::SrpPorts;
use super::interface::earliest;
use super::stats::DmaCounters;
use super::stream::Stream;
use crate::config::MachineConfig;
use crate::link::RayRef;
use crate::memory::{Cycle, Memory};
use crate::work::layout::Region;

/// The rasteriser of a core.
#[derive(Clone, Debug)]
pub struct Raster {
    rate: u32,
    waiting: VecDeque<RayRef>,
    stream: Stream,
    made: (Option<Cycle>, u32),
    taken: (Option<Cycle>, u32),
}

impl Raster {
    /// The rasteriser of core `core`.
    pub fn new(config: &MachineConfig, core: u32, ports: SrpPorts) -> Self {
        let line_bytes = u64::from(config.l2.line_bytes);
        let first_line = (Region::GBuffer.base() + (u64::from(core) << 32)) / line_bytes;
        let bytes = u64::from(config.raster.gbuffer_bytes);
        Self {
            rate: config.raster.samples_per_cycle.max(1),
            waiting: VecDeque::new(),
            stream: Stream::new(ports.dma, Region::GBuffer, first_line, line_bytes, bytes),
            made: (None, 0),
            taken: (None, 0),
        }
    }

    /// Asks for a primary.
    pub fn add(&mut self, ray: RayRef) {
        self.waiting.push_back(ray);
    }

    /// Makes samples and moves lines.
    pub fn tick<M: Memory>(&mut self, now: Cycle, memory: &mut M, counters: &mut DmaCounters) {
        if self.made.0 != Some(now) {
            self.made = (Some(now), 0);
        }
        while self.made.1 < self.rate {
            let Some(ray) = self.waiting.pop_front() else { break };
            self.stream.push(now, ray);
            self.made.1 += 1;
            if self.waiting.is_empty() {
                self.stream.close();
            }
        }
        self.stream.tick(now, memory, counters);
    }

    /// The next primary hit.
    pub fn take(&mut self, now: Cycle) -> Option<RayRef> {
        if self.taken.0 != Some(now) {
            self.taken = (Some(now), 0);
        }
        if self.taken.1 == self.rate {
            return None;
        }
        let ray = self.stream.pop();
        self.taken.1 += u32::from(ray.is_some());
        ray
    }

    /// A line arrived; `false` if it is not of the G-buffer.
    pub fn respond(&mut self, line: u64) -> bool {
        let own = self.stream.owns(line);
        if own {
            self.stream.respond(line);
        }
        own
    }

    /// Whether memory refused a request.
    pub fn waits(&self) -> bool {
        self.stream.refused()
    }

    /// When something happens here by itself.
    pub fn next_event(&self, now: Cycle) -> Option<Cycle> {
        let busy = !self.waiting.is_empty() || self.stream.has_ready();
        earliest(self.stream.next_event(now), busy.then_some(now + 1))
    }
}
