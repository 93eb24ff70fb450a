//! The SRP without cycles: items of kernels, what `shade` reads, and the lines of transfers.

use super::caches::CoreTags;
use super::features::Features;
use super::memory::TagMemory;
use crate::config::{Interface, MachineConfig, Pipeline, PrimaryVisibility, Raster};
use crate::memory::{Route, Tags};
use crate::srp::{
    Costs, FrameShape, KernelId, Queues, RasterCounters, RasterWork, Sends, ShadeReads, TileBuffer, border_offset,
    framebuffer_rows, list_offset, sent_ray, taker,
};
use crate::stats::CoreStats;
use crate::work::history::HistoryLayout;
use crate::work::layout::{Layout, Region};
use crate::work::{RayWork, Round, TileWork};
use rayreel_formats::tile::RayKind;

/// What the SRP does with a tile.
pub(super) struct Shader {
    layout: Layout,
    history: HistoryLayout,
    shape: FrameShape,
    costs: Costs,
    reads: ShadeReads,
    buffer: TileBuffer,
    /// Kernels run on processors.
    software: bool,
    rasters: bool,
    raster: Raster,
    gbuffer_bytes: u64,
    direct: bool,
    message_bytes: [u64; 2],
    message_cycles: [u64; 2],
    line_bytes: u64,
}

impl Shader {
    pub fn new(config: &MachineConfig, shape: FrameShape) -> Self {
        let (layout, gpu) = (Layout::new(config), &config.gpu);
        let message_bytes = [gpu.ray_message_bytes, gpu.hit_message_bytes].map(u64::from);
        let width = u64::from(gpu.interface_bytes_per_cycle.max(1));
        Self {
            layout,
            history: HistoryLayout::new(&config.srp.sample, shape.tile_samples),
            shape,
            costs: Costs::new(config, &shape.policy),
            reads: ShadeReads::new(config, layout),
            buffer: TileBuffer::new(config, &shape.policy),
            software: config.ti.pipeline == Pipeline::Software,
            rasters: gpu.primary_visibility == PrimaryVisibility::Raster,
            raster: config.raster.clone(),
            gbuffer_bytes: config.raster.gbuffer_bytes.into(),
            direct: gpu.interface == Interface::Direct,
            message_bytes,
            // An ideal link takes no time, as in `srp::Interface`.
            message_cycles: message_bytes.map(|bytes| if config.srp.ideal { 0 } else { bytes.div_ceil(width).max(1) }),
            line_bytes: config.l2.line_bytes.into(),
        }
    }

    /// What is read and tested before anything of the round is traced; the rays that it starts wait in the queues then. A
    /// rasteriser sees what the eye sees, so the items of these rays wait instead.
    pub fn begin_round(
        &self,
        work: &TileWork,
        (number, round): (usize, &Round),
        queues: &mut Queues,
        (counted, memory): (&mut CoreStats, &mut TagMemory),
        features: &mut Features,
    ) {
        self.transfer((Region::Sample, Route::Read), 0, self.buffer.round_read_bytes(round), counted, memory);
        if number == 0 {
            for (offset, bytes) in self.history.reads(work.frame, &work.history) {
                self.transfer((Region::History, Route::Read), offset, bytes, counted, memory);
            }
        }
        if number == 1 {
            let border = u64::from(work.border_samples) * self.buffer.sample_bytes();
            self.transfer((Region::Border, Route::Read), border_offset(work.tile), border, counted, memory);
        }
        self.items(KernelId::Similarity, round.tests.into(), counted, features);
        self.items(KernelId::Colour, round.colours.into(), counted, features);
        self.items(KernelId::Interpolate, round.interpolated.into(), counted, features);
        self.items(KernelId::Attributes, round.attributes.into(), counted, features);
        self.items(KernelId::Reshade, round.shaded.into(), counted, features);
        self.items(KernelId::LookBack, round.looked_back.into(), counted, features);
        let mut seen = 0;
        for &ray in &round.starts {
            if self.rasters && work.rays[ray as usize].kind == RayKind::Primary {
                seen += 1;
                self.queue(work, ray, queues);
            } else {
                queues.push_ray(KernelId::Raygen, ray);
            }
        }
        features.add_traversal(0, 0, seen);
        self.stream((seen, self.gbuffer_bytes), Region::GBuffer, counted, memory);
        if self.rasters {
            let RasterWork { triangles, samples, list_bytes } = RasterWork::of(&self.raster, work, &round.starts);
            counted.srp.raster += RasterCounters { triangles, samples };
            for route in [Route::Write, Route::Read] {
                self.transfer((Region::GBuffer, route), list_offset(work.tile), list_bytes, counted, memory);
            }
        }
    }

    /// The item of a ray waits.
    #[inline]
    pub fn queue(&self, work: &TileWork, number: u32, queues: &mut Queues) {
        let ray = &work.rays[number as usize];
        match taker(ray) {
            KernelId::Shade => queues.push_shade(if self.costs.sorts() { ray.material } else { 0 }, number),
            kernel => queues.push_ray(kernel, number),
        }
    }

    /// Writes what a round has brought behind the `before` bytes of the rounds before it; gives the bytes.
    pub fn end_round(&self, round: &Round, before: u64, counted: &mut CoreStats, memory: &mut TagMemory) -> u64 {
        let bytes = self.buffer.round_written_bytes(round);
        self.transfer((Region::Sample, Route::Write), before, bytes, counted, memory);
        bytes
    }

    /// SRP cycles of a batch beside those of its items.
    pub fn prologue(&self, kernel: KernelId) -> f64 {
        self.costs.prologue(kernel) as f64
    }

    /// Starts rays.
    pub fn generate(&self, rays: usize, counted: &mut CoreStats, features: &mut Features) {
        let items = rays as u64;
        let kernel = &mut counted.srp.kernels[KernelId::Raygen as usize];
        kernel.items += items;
        kernel.ops += items * self.costs.ops(KernelId::Raygen, Sends::default(), 1);
        features.add_srp_cycles(items * self.costs.interval(KernelId::Raygen, Sends::default()));
        features.add_srp_work(self.costs.work(KernelId::Raygen, items));
    }

    /// Sends rays to the T&I unit, which sends hits back.
    pub fn send(&self, rays: usize, counted: &mut CoreStats, memory: &mut TagMemory) {
        let sent = rays as u64;
        let interface = &mut counted.srp.interface;
        interface.rays += sent;
        interface.hits += sent;
        interface.ray_bytes += sent * self.message_bytes[0];
        interface.hit_bytes += sent * self.message_bytes[1];
        if self.direct {
            interface.ray_busy += sent * self.message_cycles[0];
            interface.hit_busy += sent * self.message_cycles[1];
        } else {
            let [rays, hits] = self.message_bytes;
            self.stream((sent, rays), Region::Ray, counted, memory);
            self.stream((sent, hits), Region::Ray, counted, memory);
        }
    }

    /// Runs a batch of items of hits or misses; the rays that they send go to `sent`.
    pub fn run(
        &self,
        (work, kernel, batch, sent): (&TileWork, KernelId, &[u32], &mut Vec<u32>),
        tags: &mut CoreTags,
        (counted, l2, memory): (&mut CoreStats, &mut Tags, &mut TagMemory),
        features: &mut Features,
    ) {
        let (mut cycles, mut lines) = (0, 0);
        for &number in batch {
            let ray = &work.rays[number as usize];
            let sends = Sends::of(kernel, ray);
            let items = &mut counted.srp.kernels[kernel as usize];
            items.items += 1;
            items.ops += self.costs.ops(kernel, sends, 1);
            cycles += self.costs.interval(kernel, sends) + self.costs.inspector(kernel, 1);
            self.buffer.count(kernel, ray.kind == RayKind::Primary, 1, &mut counted.srp.local);
            if kernel == KernelId::Shade {
                lines += self.read(number, ray, tags, (counted, l2, memory));
                sent.extend((0..).map_while(|k| sent_ray(kernel, work, number, k)));
            }
        }
        counted.srp_l1.looked_up(lines);
        features.add_srp_cycles(cycles);
        features.add_srp_work(self.costs.work(kernel, batch.len() as u64));
    }

    /// Looks up what a hit reads: in the L1 of the SRP, or of a processor that runs its kernels. Gives the lines of the former.
    fn read(
        &self,
        number: u32,
        ray: &RayWork,
        tags: &mut CoreTags,
        (counted, l2, memory): (&mut CoreStats, &mut Tags, &mut TagMemory),
    ) -> u64 {
        let lines = self.reads.lines(ray);
        if !self.software {
            return lines
                .map(|(line, region)| memory.look_up((&mut tags.srp, l2), line, region, &mut counted.srp_l1))
                .count() as u64;
        }
        // Items are dealt to the processors in turn.
        let unit = number as usize % tags.trv.len();
        let (tags, counted) = (&mut tags.trv[unit], &mut counted.ti.trv[unit].l1);
        let looked_up = lines.map(|(line, region)| memory.look_up((&mut *tags, l2), line, region, counted)).count();
        counted.looked_up(looked_up as u64);
        0
    }

    /// The end of a tile: borders, what did not fit, resolve and pixels.
    pub fn end_tile(&self, work: &TileWork, counted: &mut CoreStats, memory: &mut TagMemory, features: &mut Features) {
        let sample = self.buffer.sample_bytes();
        let spilled = self.buffer.spilled_samples(work);
        counted.srp.local.spilled_samples += spilled;
        for route in [Route::Write, Route::Read] {
            self.transfer((Region::Sample, route), 0, spilled * sample, counted, memory);
        }
        let kept = u64::from(work.kept_samples) * sample;
        self.transfer((Region::Border, Route::Write), border_offset(work.tile), kept, counted, memory);
        for (offset, bytes) in self.history.writes(work.frame, work.tile, &work.history) {
            self.transfer((Region::History, Route::Write), offset, bytes, counted, memory);
        }
        self.items(KernelId::Colour, work.audited_samples.into(), counted, features);
        self.items(KernelId::Control, self.shape.policy.control.into(), counted, features);
        self.items(KernelId::Resolve, work.rect.len() as u64, counted, features);
        for (address, bytes) in framebuffer_rows(self.shape, work) {
            let at = (Region::Framebuffer, Route::Write);
            self.transfer(at, address - Region::Framebuffer.base(), bytes, counted, memory);
        }
        counted.srp.local.tiles += 1;
    }

    /// Items that are no rays.
    fn items(&self, kernel: KernelId, items: u64, counted: &mut CoreStats, features: &mut Features) {
        let counters = &mut counted.srp.kernels[kernel as usize];
        counters.items += items;
        counters.ops += items * self.costs.ops(kernel, Sends::default(), 1);
        self.buffer.count(kernel, false, items, &mut counted.srp.local);
        features.add_srp_cycles(
            items * self.costs.interval(kernel, Sends::default()) + self.costs.inspector(kernel, items),
        );
        features.add_srp_work(self.costs.work(kernel, items));
    }

    /// Moves `bytes` from `offset` of a region on.
    fn transfer(
        &self,
        (region, route): (Region, Route),
        offset: u64,
        bytes: u64,
        counted: &mut CoreStats,
        memory: &mut TagMemory,
    ) {
        if bytes == 0 {
            return;
        }
        let lines = self.layout.lines(region.base() + offset, bytes);
        memory.transfer_all(lines, region, route);
        *counted.srp.dma.of(region, route == Route::Read) += lines.count() * self.line_bytes;
    }

    /// Messages of so many bytes that go through memory, as densely as they can be packed.
    fn stream(&self, (messages, bytes): (u64, u64), region: Region, counted: &mut CoreStats, memory: &mut TagMemory) {
        let per_line = (self.line_bytes / bytes.max(1)).max(1);
        let lines = messages.div_ceil(per_line) * bytes.div_ceil(self.line_bytes);
        memory.stream(lines, region);
        for read in [false, true] {
            *counted.srp.dma.of(region, read) += lines * self.line_bytes;
        }
    }
}
