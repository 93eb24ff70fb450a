//! The programmable shader of a core.

use rayreel_settings::Rule::{Flag, Integer};
use rayreel_settings::{Bytes, Rule, settings, words};

use super::cache::L1;
use super::rules::{CLOCK, SMALL};

/// Bytes of a field of a sample.
const FIELD: Rule = Integer(0, 64);
/// Operations.
const OPS: Rule = Integer(0, 10_000);

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
            "initiation interval, from one item to the next", "cycles";
        prologue_cycles: u32 = Integer(0, 10_000), "prologue and epilogue of the software pipeline, each batch", "cycles";
        ops: u32 = Integer(0, 100_000), "operations an item, for energy";
    }
}

settings! {
    /// A kernel whose work depends on the policy. Its interval is its operations over `srp.ops_per_cycle`, rounded up; its prologue
    /// is its stages times its interval.
    #[derive(Copy)]
    #[serde(deny_unknown_fields)]
    pub struct PolicyKernel {
        ops: u32 = Integer(0, 100_000), "operations an item, beside those of what the policy reads";
        stages: u32 = Integer(0, 100), "stages of the software pipeline; 0 where a machine lacks the kernel";
    }

    /// Operations that a similarity test takes for each attribute that the policy tests.
    #[derive(Copy)]
    #[serde(deny_unknown_fields)]
    pub struct TestOps {
        object: u32 = OPS, "object ids";
        normal: u32 = OPS, "normals";
        shadow: u32 = OPS, "shadow bits";
        position: u32 = OPS, "distance of the hit points";
        plane: u32 = OPS, "distance from the tangent plane";
    }

    /// Operations that an interpolated hit takes for each attribute that later tests read, beside its colour.
    #[derive(Copy)]
    #[serde(deny_unknown_fields)]
    pub struct MixOps {
        identity: u32 = OPS, "object id and shadow bits";
        normal: u32 = OPS, "normal";
        position: u32 = OPS, "position";
        distance: u32 = OPS, "length of the ray";
        local: u32 = OPS, "local colour";
        weights: u32 = OPS, "weights of reflection and refraction";
    }
}

settings! {
    /// The kernels, in order of the report.
    #[serde(deny_unknown_fields)]
    pub struct Kernels {
        raygen: Kernel, "a primary ray";
        shade: Kernel, "a hit: material, texture, one light; spawns shadow and secondary rays";
        light: Kernel, "every shadow ray beyond the first of a hit";
        secondary: Kernel, "every reflection and refraction ray that a hit sends";
        miss: Kernel, "a closest-hit ray that left the scene";
        update: Kernel, "the result of a shadow ray, added to its sample";
        similarity: PolicyKernel, "a similarity test: the attributes of a pair of hits";
        colour: PolicyKernel, "a difference of two colours as displayed: of a test, a correction, an audited sample";
        interpolate: PolicyKernel, "an interpolated sample: its colour";
        attributes: PolicyKernel, "an interpolated hit that later tests read: its attributes";
        look_back: PolicyKernel, "a hit whose lights are looked for in the frame before";
        control: PolicyKernel, "a tile whose rate or limit the policy chooses";
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
        distance: u32 = FIELD, "length of the ray, where the policy reads it", "bytes";
        local: u32 = FIELD, "local colour of the hit, where the policy reads it", "bytes";
        weights: u32 = FIELD, "weights of reflection and refraction, where the policy reads them", "bytes";
    }

    /// The programmable shader.
    #[serde(deny_unknown_fields)]
    pub struct Srp {
        clock_mhz: u32 = CLOCK, "clock", "MHz";
        ideal: bool = Flag, "kernels take no time: the T&I unit alone is measured; memory and interface traffic stay";
        divergence: Divergence = Divergence::RULE, "cost of branches";
        ops_per_cycle: u32 = Integer(1, 1024), "operations that the array does in a cycle of a kernel, on average";
        inspector_ops: u32 = OPS, "operations of the inspector, each item, for energy";
        inspector_cycles: u32 = Integer(0, 1000), "inspector, each item", "cycles";
        batch_min: u32 = Integer(1, 65_536),
            "a batch waits for so many items while others can run or the T&I unit still works";
        batch_max: u32 = Integer(1, 65_536), "most items of a batch";
        // The L1 tells waiters apart by the bits of a mask of 128.
        gather_entries: u32 = Integer(1, 128), "items whose reads can be gathered at a time: most items of a batch of shade";
        output_rays: u32 = Integer(1, 65_536), "rays that the output queue holds";
        output_high_percent: u32 = Integer(0, 100), "share of the output queue above which no primary rays are begun", "%";
        rays_low_percent: u32 = Integer(0, 100),
            "share of the rays that a T&I unit holds, below which kernels that send rays go first", "%";
        dma_reads: u32 = Integer(1, 1024), "lines that the DMA engine can wait for at a time";
        kernels: Kernels, "kernels";
        test_ops: TestOps, "operations of a similarity test, by attribute";
        mix_ops: MixOps, "operations of an interpolated hit, by attribute";
        local_memory: Bytes = SMALL, "local memory", "bytes";
        local_word_bytes: u32 = Integer(1, 64), "word of the local memory: what an access reads or writes", "bytes";
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
        let always = self.object + self.normal + self.position + self.shadow + self.colour + self.flags;
        always + self.distance + self.local + self.weights
    }
}
