//! What the SRP counts.

use super::kernels::{KERNELS, KernelId};
use crate::counters::counters;
use crate::memory::CacheCounters;
use crate::work::layout::Region;

counters! {
    /// Work of one kernel.
    pub struct KernelCounters {
        batches: "batches", "batches run";
        items: "items", "items run";
        cycles: "SRP cycles", "cycles of the array in this kernel, prologues included, stalls and inspector not";
        ops: "operations", "operations executed";
    }
}

counters! {
    /// What the array did in each SRP cycle. Every cycle is in exactly one class, so the classes add up to the run.
    pub struct SrpActivity {
        raygen: "SRP cycles", "in the raygen kernel";
        shade: "SRP cycles", "in the shade kernel";
        miss: "SRP cycles", "in the miss kernel";
        shadow_result as "update": "SRP cycles", "in the update kernel";
        similarity: "SRP cycles", "in the similarity kernel";
        colour: "SRP cycles", "in the colour kernel";
        interpolate: "SRP cycles", "in the interpolate kernel";
        attributes: "SRP cycles", "in the attributes kernel";
        reshade: "SRP cycles", "in the reshade kernel";
        look_back: "SRP cycles", "in the look_back kernel";
        control: "SRP cycles", "in the control kernel";
        resolve: "SRP cycles", "in the resolve kernel";
        inspector: "SRP cycles", "sorting items by branch";
        output: "SRP cycles", "a kernel has rays to send and the output queue is full";
        memory: "SRP cycles", "a kernel waits for attributes or texels";
        unit: "SRP cycles", "no batch is ready and rays are out";
        transfer: "SRP cycles", "no batch is ready, no ray is out, and a tile waits for its transfers";
        border: "SRP cycles", "no batch is ready, no ray is out, and all tiles wait for tiles beside them";
        idle: "SRP cycles", "there is no tile";
    }
}

impl SrpActivity {
    /// All cycles.
    pub fn total(&self) -> u64 {
        self.list().iter().map(|c| c.value).sum()
    }

    /// Cycles in kernels and inspector.
    pub fn busy_cycles(&self) -> u64 {
        KernelId::ALL.into_iter().map(|kernel| self.in_kernel(kernel)).sum::<u64>() + self.inspector
    }

    /// Cycles in one kernel.
    pub fn in_kernel(&self, kernel: KernelId) -> u64 {
        match kernel {
            KernelId::Raygen => self.raygen,
            KernelId::Shade => self.shade,
            KernelId::Miss => self.miss,
            KernelId::ShadowResult => self.shadow_result,
            KernelId::Similarity => self.similarity,
            KernelId::Colour => self.colour,
            KernelId::Interpolate => self.interpolate,
            KernelId::Attributes => self.attributes,
            KernelId::Reshade => self.reshade,
            KernelId::LookBack => self.look_back,
            KernelId::Control => self.control,
            KernelId::Resolve => self.resolve,
        }
    }

    pub(super) fn busy(&mut self, kernel: KernelId, cycles: u64) {
        *match kernel {
            KernelId::Raygen => &mut self.raygen,
            KernelId::Shade => &mut self.shade,
            KernelId::Miss => &mut self.miss,
            KernelId::ShadowResult => &mut self.shadow_result,
            KernelId::Similarity => &mut self.similarity,
            KernelId::Colour => &mut self.colour,
            KernelId::Interpolate => &mut self.interpolate,
            KernelId::Attributes => &mut self.attributes,
            KernelId::Reshade => &mut self.reshade,
            KernelId::LookBack => &mut self.look_back,
            KernelId::Control => &mut self.control,
            KernelId::Resolve => &mut self.resolve,
        } += cycles;
    }
}

counters! {
    /// Traffic between SRP and T&I unit.
    pub struct InterfaceCounters {
        rays: "rays", "rays sent to the T&I unit";
        hits: "hits", "hits received from the T&I unit";
        ray_bytes: "bytes", "bytes of ray messages";
        hit_bytes: "bytes", "bytes of hit messages";
        ray_busy: "cycles", "T&I cycles in which the direct link carries rays";
        hit_busy: "cycles", "T&I cycles in which the direct link carries hits";
    }
}

counters! {
    /// Traffic of the DMA and stream engines, whole lines.
    pub struct DmaCounters {
        framebuffer_written: "bytes", "pixels written to the framebuffer";
        sample_written: "bytes", "sample attributes written: external geometry buffer or spill";
        sample_read: "bytes", "sample attributes read";
        border_written: "bytes", "border samples written for neighbouring tiles";
        border_read: "bytes", "border samples of neighbouring tiles read";
        history_written: "bytes", "samples kept for the next frame";
        history_read: "bytes", "samples that the frame before kept read";
        gbuffer_written: "bytes", "G-buffer written by the rasteriser";
        gbuffer_read: "bytes", "G-buffer read by the SRP";
        ray_written: "bytes", "rays and hits written (interface through memory)";
        ray_read: "bytes", "rays and hits read (interface through memory)";
    }
}

counters! {
    /// Work of a rasteriser; what lies behind what is seen is in it.
    pub struct RasterCounters {
        triangles: "triangles", "triangles set up, of each tile and round again";
        samples: "samples", "samples rasterised";
    }
}

counters! {
    /// Local memory and tiles.
    pub struct LocalCounters {
        reads: "words", "reads of the tile buffer, a word each";
        writes: "words", "writes of the tile buffer, a word each";
        spilled_samples: "samples", "samples that did not fit into the tile buffer";
        tiles: "tiles", "tiles finished";
    }
}

impl DmaCounters {
    /// The counter of a region's traffic.
    pub(crate) fn of(&mut self, region: Region, read: bool) -> &mut u64 {
        match (region, read) {
            (Region::Framebuffer, _) => &mut self.framebuffer_written,
            (Region::Border, false) => &mut self.border_written,
            (Region::Border, true) => &mut self.border_read,
            (Region::History, false) => &mut self.history_written,
            (Region::History, true) => &mut self.history_read,
            (Region::GBuffer, false) => &mut self.gbuffer_written,
            (Region::GBuffer, true) => &mut self.gbuffer_read,
            (Region::Ray, false) => &mut self.ray_written,
            (Region::Ray, true) => &mut self.ray_read,
            (_, false) => &mut self.sample_written,
            (_, true) => &mut self.sample_read,
        }
    }
}

/// What the array counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ArrayCounters {
    /// Per kernel, in the order of [`KernelId::ALL`].
    pub kernels: [KernelCounters; KERNELS],
    /// What the array did.
    pub activity: SrpActivity,
}

/// Everything that an SRP counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SrpStats {
    /// Per kernel, in the order of [`KernelId::ALL`].
    pub kernels: [KernelCounters; KERNELS],
    /// What the array did.
    pub activity: SrpActivity,
    /// Interface.
    pub interface: InterfaceCounters,
    /// DMA and streams.
    pub dma: DmaCounters,
    /// Rasteriser, where there is one.
    pub raster: RasterCounters,
    /// Local memory and tiles.
    pub local: LocalCounters,
}

/// What an SRP reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SrpReport {
    /// All counters but those of the L1.
    pub stats: SrpStats,
    /// The L1.
    pub l1: CacheCounters,
    /// Length of the run in SRP cycles: the sum of all activities.
    pub cycles: u64,
}
