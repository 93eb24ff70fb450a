//! What `shade` reads: vertex attributes and texels, gathered ahead of the array through the SRP's L1.
//!
//! * When a batch begins, the reads of its items are queued in item order. One line is looked up a SRP cycle; a hit is there
//!   `srp.l1.latency_cycles` SRP cycles later (at least 1), a miss when its line has arrived. While all MSHRs are taken no line
//!   is looked up. An item is not complete before its lines are there; later items move back with it. (Estimate.)
//! * Attributes: the lines of the hit triangle. Texel: one a hit, as if each sample covered one texel (a perfect choice of the
//!   mip level): square blocks of texels, tiled in the order of the screen, apart by material and by depth. (Estimate.)

use std::collections::VecDeque;

use super::clock::Clock;
use super::per_cycle::PerCycle;
use crate::component::Component;
use crate::config::MachineConfig;
use crate::memory::{Access, CacheCounters, L1Cache, Memory, Port};
use crate::time::{ClockCycle, SrpCycle, TiCycle, When};
use crate::work::RayWork;
use crate::work::layout::{Layout, Region};

/// Items that the L1 can tell apart: the limit of `srp.gather_entries`.
const ENTRIES_MAX: usize = L1Cache::WAITERS as usize;

#[derive(Clone, Copy, Debug)]
struct Read {
    line: u64,
    region: Region,
    reader: u8,
}

/// The lines that a hit reads.
#[derive(Clone, Copy, Debug)]
pub struct ShadeReads {
    layout: Layout,
    /// A hit has attributes.
    attributes: bool,
    texel_block_bytes: u64,
    /// Logarithms of the edges of a block and of a tile of texels.
    block_bits: u32,
    tile_bits: u32,
    textures: bool,
}

impl ShadeReads {
    /// Those of a machine.
    pub fn new(config: &MachineConfig, layout: Layout) -> Self {
        let edge = u64::from(config.layout.texture_block);
        Self {
            layout,
            attributes: config.srp.attribute_bytes > 0,
            texel_block_bytes: edge * edge * u64::from(config.srp.texel_bytes),
            block_bits: config.layout.texture_block.trailing_zeros(),
            tile_bits: config.layout.texture_tile.trailing_zeros(),
            textures: config.srp.textures,
        }
    }

    /// The lines of the hit of `ray`, in order.
    pub fn lines(&self, ray: &RayWork) -> impl Iterator<Item = (u64, Region)> + use<> {
        let attributes = self.layout.attribute(ray.triangle);
        let texel = self.textures.then(|| (self.layout.lines(self.texel_address(ray), 1).first, Region::Texture));
        let has_attributes = self.attributes;
        let attributes = (attributes.first..=attributes.last).filter(move |_| has_attributes);
        attributes.map(|line| (line, Region::Attribute)).chain(texel)
    }

    /// 2^30 bytes a material, a quarter of them for each of four depths: an address space of the model, not hardware. Textures are
    /// tiled: the blocks of a tile together, tiles row by row, 512 a row. So the texels of a tile lie together, and not at a power
    /// of two from each other.
    fn texel_address(&self, ray: &RayWork) -> u64 {
        let (block_bits, tile_bits) = (self.block_bits, self.tile_bits);
        let bits = tile_bits - block_bits;
        let inside = |texel: u32| u64::from((texel >> block_bits) & ((1 << bits) - 1));
        let tile = u64::from(ray.y >> tile_bits) << 9 | u64::from((ray.x >> tile_bits) & 0x1ff);
        let block = tile << (2 * bits) | inside(ray.y) << bits | inside(ray.x);
        let plane = u64::from(ray.material & 0x3ff) << 30 | u64::from(ray.depth & 3) << 28;
        Region::Texture.base() + plane + ((block * self.texel_block_bytes) & 0x0fff_ffff)
    }
}

/// The gather engine with its L1.
pub struct Gather {
    l1: L1Cache,
    reads: ShadeReads,
    clock: Clock,
    latency_cycles: u64,
    mshrs: usize,
    entries: usize,
    queue: VecDeque<Read>,
    outstanding: usize,
    /// Per item the lines that are not there, and since when the others are.
    missing: [u32; ENTRIES_MAX],
    ready: [SrpCycle; ENTRIES_MAX],
    looked_up: PerCycle,
    refused: bool,
}

impl Gather {
    /// The gather engine of a machine.
    pub fn new(config: &MachineConfig, layout: Layout, clock: Clock, port: Port) -> Self {
        Self {
            l1: L1Cache::new(&config.srp.l1, config.l2.line_bytes, port),
            reads: ShadeReads::new(config, layout),
            clock,
            latency_cycles: u64::from(config.srp.l1.latency_cycles.max(1)),
            mshrs: config.srp.l1.mshrs.max(1) as usize,
            entries: (config.srp.gather_entries as usize).clamp(1, ENTRIES_MAX),
            queue: VecDeque::new(),
            outstanding: 0,
            missing: [0; ENTRIES_MAX],
            ready: [SrpCycle::START; ENTRIES_MAX],
            looked_up: PerCycle::default(),
            refused: false,
        }
    }

    /// The L1.
    pub fn l1(&self) -> &L1Cache {
        &self.l1
    }

    /// The L1, to drop lines that left an inclusive L2.
    pub fn l1_mut(&mut self) -> &mut L1Cache {
        &mut self.l1
    }

    /// Items whose reads can be gathered at a time.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// Queues the reads of the hit of `ray` for item `reader` of the batch.
    pub fn add(&mut self, reader: u8, ray: &RayWork) {
        self.missing[reader as usize] = 0;
        self.ready[reader as usize] = SrpCycle::START;
        for (line, region) in self.reads.lines(ray) {
            self.push(line, region, reader);
        }
    }

    fn push(&mut self, line: u64, region: Region, reader: u8) {
        self.queue.push_back(Read { line, region, reader });
        self.missing[reader as usize] += 1;
    }

    /// The SRP cycle from which on item `reader` has its data; `None` while it waits.
    #[inline]
    pub fn ready(&self, reader: usize) -> Option<SrpCycle> {
        (self.missing[reader] == 0).then_some(self.ready[reader])
    }

    /// Looks up as many lines as SRP cycles begin in this T&I cycle; whether a lookup hit.
    #[inline]
    pub fn look_up<M: Memory>(&mut self, now: TiCycle, memory: &mut M) -> bool {
        self.refused = false;
        !self.queue.is_empty() && self.outstanding < self.mshrs && self.look_up_queued(now, memory)
    }

    fn look_up_queued<M: Memory>(&mut self, now: TiCycle, memory: &mut M) -> bool {
        let mut hit = false;
        let (first, cycles) = (self.clock.srp(now), self.clock.srp_cycles_of(now));
        let looked_up = self.looked_up.used(now);
        while *looked_up < cycles && self.outstanding < self.mshrs {
            let Some(&Read { line, region, reader }) = self.queue.front() else { break };
            match self.l1.access(now, line, region, reader, memory) {
                Access::Hit => {
                    hit = true;
                    let r = reader as usize;
                    self.missing[r] = self.missing[r].saturating_sub(1); // with `srp.ideal` all items share a reader
                    self.ready[r] = self.ready[r].max(first + *looked_up + self.latency_cycles);
                }
                Access::Miss => self.outstanding += 1,
                Access::Merged => {}
                Access::Rejected => {
                    self.refused = true;
                    break;
                }
            }
            *looked_up += 1;
            self.queue.pop_front();
        }
        hit
    }

    /// A line arrived.
    pub fn fill(&mut self, now: TiCycle, line: u64) {
        let mut readers = self.l1.fill(line);
        self.outstanding = self.outstanding.saturating_sub(1);
        let at = self.clock.srp(now);
        while readers != 0 {
            let r = readers.trailing_zeros() as usize;
            readers &= readers - 1;
            self.missing[r] = self.missing[r].saturating_sub(1);
            self.ready[r] = self.ready[r].max(at);
        }
    }

    /// Whether nothing is under way.
    pub fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.outstanding == 0
    }

    /// What is under way, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        let missing: u64 = self.missing.iter().map(|&m| u64::from(m)).sum();
        format!("reads queued {}, lines out {}, reads missing {missing}", self.queue.len(), self.outstanding)
    }

    /// Whether memory refused the last request.
    pub fn refused(&self) -> bool {
        self.refused
    }
}

impl Component for Gather {
    /// What the L1 did.
    type Report = CacheCounters;

    fn next_event(&self, now: TiCycle) -> When {
        let busy = !self.queue.is_empty() && !self.refused && self.outstanding < self.mshrs;
        When::only_if(busy, now + 1)
    }

    fn finish(&mut self, _: TiCycle) -> CacheCounters {
        *self.l1.counters()
    }
}
