//! Areas of units and of bits, for the area of the chip.

use rayreel_settings::Rule::Integer;
use rayreel_settings::{Rule, settings};

/// Logic of a unit, square micrometres.
const LOGIC: Rule = Integer(0, 100_000_000);
/// A bit cell, square nanometres.
const BIT: Rule = Integer(0, 10_000_000);

settings! {
    /// Areas at one process, in whole square micrometres and nanometres so that sums are exact.
    #[derive(Eq)]
    #[serde(deny_unknown_fields)]
    pub struct Area {
        box_um2: u64 = LOGIC, "logic that tests a box a cycle", "um2";
        triangle_um2: u64 = LOGIC, "logic that tests a triangle a cycle", "um2";
        trv_control_um2: u64 = LOGIC, "logic of a traversal unit beside its tests", "um2";
        processor_um2: u64 = LOGIC, "logic of a processor, registers included", "um2";
        raster_um2: u64 = LOGIC, "logic of a rasteriser, on machines that have one", "um2";
        srp_um2: u64 = LOGIC, "logic of an SRP", "um2";
        sram_bit_nm2: u64 = BIT, "bit cell of caches and local memories", "nm2";
        buffer_bit_nm2: u64 = BIT, "bit cell of ray buffers and stacks, read and written in one cycle", "nm2";
        tag_bits: u64 = Integer(0, 256), "tag and state of a cache line", "bits";
        array_percent: u64 = Integer(1, 100), "share of a memory's area that is bit cells", "%";
    }
}
