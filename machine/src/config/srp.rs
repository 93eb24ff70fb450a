//! The programmable shader of a core.

use rayreel_settings::Rule::{Flag, Integer};
use rayreel_settings::{Bytes, Entry, Rule, Settings, settings, words};

use super::cache::L1;
use super::rules::{CLOCK, SMALL};

/// Bytes of a field of a sample.
const FIELD: Rule = Integer(0, 64);

words! {
    /// What branches cost on the SRP.
    pub enum Divergence {
        /// Items are sorted by branch first (inspector), then each branch runs by itself (executor).
        Inspector = "inspector",
        /// Mixed batches: every item pays for every branch present in its batch.
        Naive = "naive",
    }
}

settings! {
    /// A kernel of the SRP.
    #[derive(Copy)]
    #[serde(deny_unknown_fields)]
    pub struct Kernel {
        ii_cycles: u32 = Integer(1, 10_000),
            "initiation interval, from one item to the next; 0 where a machine may lack the kernel and does", "cycles";
        prologue_cycles: u32 = Integer(0, 10_000), "prologue and epilogue of the software pipeline, each batch", "cycles";
        ops: u32 = Integer(0, 100_000), "operations an item, for energy";
    }
}

/// The keys of a kernel that a machine may lack.
struct OptionalKernel;

impl Settings for OptionalKernel {
    const ENTRIES: &'static [Entry] =
        &[Kernel::ENTRIES[0].with_rule(Integer(0, 10_000)), Kernel::ENTRIES[1], Kernel::ENTRIES[2]];
}

settings! {
    /// The kernels, in order of the report.
    #[serde(deny_unknown_fields)]
    pub struct Kernels {
        raygen: Kernel, "a primary ray";
        shade: Kernel, "a hit: material, texture, one light; spawns shadow and secondary rays";
        light: Kernel, "every shadow ray beyond the first of a hit";
        miss: Kernel, "a closest-hit ray that left the scene";
        update: Kernel, "the result of a shadow ray, added to its sample";
        similarity: Kernel as OptionalKernel, "a similarity test";
        interpolate: Kernel as OptionalKernel, "an interpolated sample";
        resolve: Kernel, "a sample averaged into its pixel";
    }

    /// The tile buffer, bytes a sample by field.
    #[derive(Eq)]
    #[serde(deny_unknown_fields)]
    pub struct SampleFields {
        object: u32 = FIELD, "object id", "bytes";
        normal: u32 = FIELD, "normal", "bytes";
        position: u32 = FIELD, "position", "bytes";
        shadow: u32 = FIELD, "shadow bits", "bytes";
        colour: u32 = FIELD, "colour", "bytes";
        flags: u32 = FIELD, "state of the sample", "bytes";
    }

    /// The programmable shader.
    #[serde(deny_unknown_fields)]
    pub struct Srp {
        clock_mhz: u32 = CLOCK, "clock", "MHz";
        ideal: bool = Flag, "kernels take no time: the T&I unit alone is measured; memory and interface traffic stay";
        divergence: Divergence = Divergence::RULE, "cost of branches";
        inspector_cycles: u32 = Integer(0, 1000), "inspector, each item", "cycles";
        batch_min: u32 = Integer(1, 65_536),
            "a batch waits for so many items while others can run or the T&I unit still works";
        batch_max: u32 = Integer(1, 65_536), "most items of a batch";
        kernels: Kernels, "kernels";
        local_memory: Bytes = SMALL, "local memory", "bytes";
        sample: SampleFields, "what a sample takes in the tile buffer, by field";
        l1: L1, "L1 data cache: vertex attributes and texels";
        attribute_bytes: u32 = Integer(0, 1024), "vertex attributes read per hit", "bytes";
        textures: bool = Flag, "hits read a texel each: the trace does not say which materials are textured";
        texel_bytes: u32 = Integer(1, 64), "size of a texel", "bytes";
    }
}

impl SampleFields {
    /// A whole sample.
    pub fn total(&self) -> u32 {
        self.object + self.normal + self.position + self.shadow + self.colour + self.flags
    }
}
