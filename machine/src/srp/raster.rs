//! Primary visibility from a rasteriser.
//!
//! The rasteriser makes `raster.samples_per_cycle` samples of a round's primaries a T&I cycle. Their G-buffer goes through memory
//! (see `stream`): `gbuffer_bytes` a sample written, then read by the SRP, which takes them as primary hits, again at most
//! `samples_per_cycle` a cycle.
//!
//! Of each tile and round the triangles that its samples see are rasterised, and `overdraw_percent` of that: as many as lie behind
//! them. Triangles are binned before: the list of a tile is written and read again, `triangle_bytes` a triangle. A round's triangles
//! are set up first, `setup_cycles` each, then its samples are made; of those behind only the energy counts, for the testers of a
//! quad drop them in the cycle in which they see what is in front. Which triangles lie behind is not recorded. (Estimate.)

use std::collections::VecDeque;

use super::context::SrpPorts;
use super::per_cycle::PerCycle;
use super::stats::{DmaCounters, RasterCounters};
use super::stream::Stream;
use crate::component::{Component, Tick};
use crate::config::{self, MachineConfig};
use crate::link::RayRef;
use crate::memory::Memory;
use crate::time::{TiCycle, When};
use crate::work::layout::Region;
use crate::work::{NO_TRIANGLE, TileWork};
use rayreel_formats::tile::RayKind;

/// What of a round is rasterised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RasterWork {
    /// Triangles, those behind included.
    pub triangles: u64,
    /// Samples, those behind included.
    pub samples: u64,
    /// Bytes of the triangles in the list of the tile.
    pub list_bytes: u64,
}

impl RasterWork {
    /// Of the primaries among `starts`.
    pub fn of(config: &config::Raster, work: &TileWork, starts: &[u32]) -> Self {
        let primaries = starts.iter().map(|&ray| &work.rays[ray as usize]).filter(|ray| ray.kind == RayKind::Primary);
        let mut seen: Vec<u32> =
            primaries.map(|ray| ray.triangle).filter(|&triangle| triangle != NO_TRIANGLE).collect();
        let with_hidden = |count: usize| (count as u64 * u64::from(config.overdraw_percent)).div_ceil(100);
        let samples = with_hidden(seen.len());
        seen.sort_unstable();
        seen.dedup();
        let triangles = with_hidden(seen.len());
        Self { triangles, samples, list_bytes: triangles * u64::from(config.triangle_bytes) }
    }
}

/// Where the list of a tile lies in the region of the G-buffer.
pub fn list_offset(tile: u32) -> u64 {
    (1 << 38) + u64::from(tile) * ((1 << 20) + 0x1040)
}

/// What the rasteriser does next.
#[derive(Clone, Copy, Debug)]
enum Item {
    /// It sets up triangles for so many cycles.
    Setup(u64),
    /// It makes a sample.
    Sample(RayRef),
}

/// The rasteriser of a core.
#[derive(Clone, Debug)]
pub struct Raster {
    config: config::Raster,
    /// Samples a cycle.
    rate: u64,
    waiting: VecDeque<Item>,
    /// The triangles at hand are set up.
    set_up: Option<TiCycle>,
    work: RasterCounters,
    /// Primaries that it has delivered.
    delivered: u64,
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
            config: config.raster.clone(),
            set_up: None,
            work: RasterCounters::default(),
            delivered: 0,
            rate: config.raster.samples_per_cycle.max(1).into(),
            waiting: VecDeque::new(),
            stream: Stream::new(config, ports.dma, (Region::GBuffer, address), bytes),
            made: PerCycle::default(),
            taken: PerCycle::default(),
        }
    }

    /// The triangles of a round come before its primaries; gives the bytes of their list.
    pub fn begin(&mut self, work: &TileWork, starts: &[u32]) -> u64 {
        let RasterWork { triangles, samples, list_bytes } = RasterWork::of(&self.config, work, starts);
        if triangles > 0 {
            self.waiting.push_back(Item::Setup(triangles * u64::from(self.config.setup_cycles)));
        }
        self.work += RasterCounters { triangles, samples };
        list_bytes
    }

    /// Asks for a primary.
    pub fn add(&mut self, ray: RayRef) {
        self.waiting.push_back(Item::Sample(ray));
    }

    /// Primaries that it has delivered.
    pub fn delivered(&self) -> u64 {
        self.delivered
    }

    /// What it rasterised so far.
    pub fn work(&self) -> RasterCounters {
        self.work
    }

    /// The next primary hit.
    pub fn take(&mut self, now: TiCycle) -> Option<RayRef> {
        let taken = self.taken.used(now);
        if *taken == self.rate {
            return None;
        }
        let ray = self.stream.pop();
        self.delivered += u64::from(ray.is_some());
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
        let makes = match self.set_up {
            Some(at) if at > now => When::at(at),
            _ => When::only_if(!self.waiting.is_empty(), now + 1),
        };
        self.stream.next_event(now).min(makes).min(When::only_if(self.stream.has_ready(), now + 1))
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
            let ray = match self.waiting.front() {
                None => break,
                Some(&Item::Setup(cycles)) => {
                    if *self.set_up.get_or_insert(now + cycles) > now {
                        break;
                    }
                    self.waiting.pop_front();
                    self.set_up = None;
                    continue;
                }
                Some(&Item::Sample(ray)) => ray,
            };
            self.waiting.pop_front();
            self.stream.push(now, ray);
            *made += 1;
            if self.waiting.is_empty() {
                self.stream.close();
            }
        }
        self.stream.tick(now, memory);
    }
}
