//! A whole machine.

use rayreel_settings::settings;

use super::area::Area;
use super::cache::L2;
use super::dram::Dram;
use super::energy::Energy;
use super::gpu::Gpu;
use super::layout::{LayoutSizes, Raster};
use super::processor::Processor;
use super::srp::Srp;
use super::ti::Ti;

settings! {
    /// A whole machine.
    #[serde(deny_unknown_fields)]
    pub struct MachineConfig {
        gpu: Gpu, "what the cores share and how they are coupled";
        ti: Ti, "the traversal and intersection unit of a core";
        processor: Processor, "the processors of a core without such units (ti.pipeline = software)";
        l2: L2, "the shared second-level cache";
        dram: Dram, "the memory";
        srp: Srp, "the programmable shader of a core";
        layout: LayoutSizes, "where things lie in memory, and how large they are";
        raster: Raster, "the rasteriser (gpu.primary_visibility = raster)";
        energy: Energy, "energy per event and leakage";
        area: Area, "area of units and of bits";
    }
}
