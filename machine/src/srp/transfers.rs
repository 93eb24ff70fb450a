//! Everything of an SRP that moves data between core, T&I unit and memory: DMA engine, interface, rasteriser.

use super::context::SrpPorts;
use super::dma::Dma;
use super::interface::Interface;
use super::raster::Raster;
use super::stats::DmaCounters;
use crate::component::{Component, Tick};
use crate::config::{MachineConfig, PrimaryVisibility};
use crate::link::RayRef;
use crate::memory::Memory;
use crate::time::{TiCycle, When};

/// The engines that move data.
pub struct Transfers {
    /// Blocks of lines that a tile waits for.
    pub dma: Dma,
    /// Rays to and hits from the T&I unit.
    pub interface: Interface,
    /// Primaries of a rasteriser, if primary visibility is its work.
    pub raster: Option<Raster>,
}

impl Transfers {
    /// The engines of core `core`, idle.
    pub fn new(config: &MachineConfig, core: u32, ports: SrpPorts) -> Self {
        let slots = config.gpu.tiles_in_flight.clamp(1, 255) as usize;
        let rasters = config.gpu.primary_visibility == PrimaryVisibility::Raster;
        Self {
            dma: Dma::new(config, ports.dma, slots),
            interface: Interface::new(config, core, ports),
            raster: rasters.then(|| Raster::new(config, core, ports)),
        }
    }

    /// A line arrived at the port of DMA and streams: it belongs to a stream, or to a transfer.
    pub fn respond(&mut self, line: u64) {
        let streamed = self.interface.respond(line) || self.raster.as_mut().is_some_and(|r| r.respond(line));
        if !streamed {
            self.dma.respond(line);
        }
    }

    /// The next primary that the rasteriser delivers.
    #[inline]
    pub fn take_primary(&mut self, now: TiCycle) -> Option<RayRef> {
        self.raster.as_mut()?.take(now)
    }

    /// Moves lines of the G-buffer.
    #[inline]
    pub fn tick_raster<M: Memory>(&mut self, now: TiCycle, memory: &mut M) {
        if let Some(raster) = &mut self.raster {
            raster.tick(now, memory);
        }
    }

    /// When something happens here by itself; `sends` tells whether the SRP has rays to send.
    pub fn next_event(&self, now: TiCycle, sends: bool) -> When {
        let sent = if sends { self.interface.next_send(now) } else { When::NEVER };
        let raster = self.raster.as_ref().map_or(When::NEVER, |raster| raster.next_event(now));
        self.interface.next_event(now).min(sent).min(self.dma.next_event(now)).min(raster)
    }

    /// Whether memory refused a request of an engine.
    #[inline]
    pub fn refused(&self) -> bool {
        self.interface.refused() || self.dma.refused() || self.raster.as_ref().is_some_and(Raster::refused)
    }

    /// Lines moved so far, by all engines.
    pub fn traffic(&self) -> DmaCounters {
        let mut sum = *self.dma.counters();
        sum += self.interface.traffic();
        if let Some(raster) = &self.raster {
            sum += *raster.counters();
        }
        sum
    }
}
