//! Energy per event and leakage. Component names are those of the report.

use rayreel_settings::Rule::{Integer, Size};
use rayreel_settings::{Bytes, Picojoules, settings};

use super::rules::{EVENT, LEAKAGE, SMALL};

settings! {
    /// Energy per event, pJ, and leakage. Component names are those of the report.
    #[serde(deny_unknown_fields)]
    pub struct Energy {
        box_test_pj: Picojoules = EVENT, "test of one box (two boxes a two-AABB operation)", "pJ";
        triangle_test_pj: Picojoules = EVENT, "test of one triangle", "pJ";
        ray_setup_pj: Picojoules = EVENT, "ray setup", "pJ";
        bypass_stage_pj: Picojoules = EVENT, "a stage of a pipeline that an operation passes as a bypass", "pJ";
        trv_clock_pj: Picojoules = EVENT, "a cycle of a traversal unit whose clock runs: rays are in it", "pJ";
        ist_clock_pj: Picojoules = EVENT, "a cycle of an intersection unit whose clock runs: a task is in it", "pJ";
        trv_priced_boxes: u32 = Integer(1, 128), "boxes a cycle that the traversal unit tests that the energies of such units' clock and leakage are of";
        trv_priced_triangles: u32 = Integer(0, 64), "triangles a cycle that it tests";
        processor_clock_pj: Picojoules = EVENT, "a cycle of a processor whose clock runs: warps are in it", "pJ";
        instruction_pj: Picojoules = EVENT, "an instruction of a warp: fetch, decode, control", "pJ";
        lane_pj: Picojoules = EVENT, "an instruction in a lane: operands and result", "pJ";
        add_pj: Picojoules = EVENT, "a floating-point addition", "pJ";
        multiply_pj: Picojoules = EVENT, "a floating-point multiplication", "pJ";
        compare_pj: Picojoules = EVENT, "a minimum, maximum or comparison", "pJ";
        integer_pj: Picojoules = EVENT, "an integer operation", "pJ";
        special_pj: Picojoules = EVENT, "a reciprocal", "pJ";
        word_pj: Picojoules = EVENT, "a word read from or written to a processor's data memory", "pJ";
        srp_clock_pj: Picojoules = EVENT, "an SRP cycle of an array whose clock runs: it has tiles", "pJ";
        network_pj_per_byte: Picojoules = EVENT, "wires between cores and L2, requests and lines", "pJ per byte";
        ray_buffer_read_pj: Picojoules = EVENT, "read of a ray's record from a ray buffer", "pJ";
        ray_buffer_write_pj: Picojoules = EVENT, "write of a ray's record into a ray buffer", "pJ";
        stack_push_pj: Picojoules = EVENT, "push onto a traversal stack", "pJ";
        stack_pop_pj: Picojoules = EVENT, "pop from a traversal stack", "pJ";
        stack_priced_size: Bytes = Size(256, 4 << 20), "size of the stacks of a traversal unit that the energies of stacks are of", "bytes";
        crossbar_pj: Picojoules = EVENT, "transfer of a leaf task or its result through the crossbar", "pJ";
        trv_l1_read_pj: Picojoules = EVENT, "L1 of a TRV unit: read of a line that hits", "pJ";
        ist_l1_read_pj: Picojoules = EVENT, "L1 of an IST unit: read of a line that hits", "pJ";
        srp_l1_read_pj: Picojoules = EVENT, "L1 of the SRP: read of a line that hits", "pJ";
        l1_miss_pj: Picojoules = EVENT, "any L1: a lookup that misses (tags only)", "pJ";
        l1_fill_pj: Picojoules = EVENT, "any L1: fill of a line", "pJ";
        accumulate_pj: Picojoules = EVENT, "a lookup or update of an accumulation row", "pJ";
        reorder_pj: Picojoules = EVENT, "a state update of a reorder-buffer slot", "pJ";
        l2_read_pj: Picojoules = EVENT, "L2: read of a line that hits", "pJ";
        l2_miss_pj: Picojoules = EVENT, "L2: a lookup that misses", "pJ";
        l2_fill_pj: Picojoules = EVENT, "L2: fill of a line", "pJ";
        l1_priced_size: Bytes = SMALL, "size of the first-level cache that the energies of first-level caches are of", "bytes";
        l2_priced_size: Bytes = Size(4 << 10, 64 << 20), "size of the L2 that the energies of the L2 are of", "bytes";
        priced_line_bytes: u32 = Integer(16, 256), "line size of the caches that these energies are of", "bytes";
        raster_triangle_pj: Picojoules = EVENT, "a triangle in a tile: transformed, binned, set up", "pJ";
        raster_sample_pj: Picojoules = EVENT, "a sample of a triangle: coverage, depth, attributes", "pJ";
        interface_pj_per_byte: Picojoules = EVENT, "direct interface", "pJ per byte";
        srp_op_pj: Picojoules = EVENT, "SRP operation, operands and configuration included", "pJ";
        local_read_pj: Picojoules = EVENT, "SRP local memory: a word read", "pJ";
        local_write_pj: Picojoules = EVENT, "SRP local memory: a word written", "pJ";
        local_priced_size: Bytes = SMALL, "size of the local memory that the energies of local memories are of", "bytes";
        local_priced_word_bytes: u32 = Integer(1, 64), "word that these energies are of", "bytes";
        dram_row_pj: Picojoules = EVENT, "DRAM: activate and precharge of a row", "pJ";
        dram_read_pj: Picojoules = EVENT, "DRAM: read of a burst, IO included", "pJ";
        dram_write_pj: Picojoules = EVENT, "DRAM: write of a burst, IO included", "pJ";
        dram_priced_row_bytes: u32 = Integer(256, 65_536), "row of a bank that the energy of a row is of", "bytes";
        dram_priced_burst_bytes: u32 = Integer(8, 256), "burst that the energies of bursts are of", "bytes";
        dram_refresh_pj: Picojoules = EVENT, "DRAM: refresh of all banks of a channel", "pJ";
        dram_phy_pj_per_byte: Picojoules = EVENT, "PHY and controller", "pJ per byte";
        dram_background_uw: u64 = LEAKAGE, "DRAM background, per channel", "uW";
        dram_power_down_uw: u64 = LEAKAGE, "DRAM background in power-down, per channel", "uW";
        sram_leakage_uw_per_kib: u64 = Integer(0, 1_000_000), "SRAM leakage", "uW per KiB";
        trv_leakage_uw: u64 = LEAKAGE, "logic leakage of a TRV unit", "uW";
        ist_leakage_uw: u64 = LEAKAGE, "logic leakage of an IST unit", "uW";
        processor_leakage_uw: u64 = LEAKAGE, "logic leakage of a processor", "uW";
        raster_leakage_uw: u64 = LEAKAGE, "logic leakage of a rasteriser, on machines that have one", "uW";
        srp_leakage_uw: u64 = LEAKAGE, "logic leakage of an SRP", "uW";
        clock_tree_percent: u64 = Integer(0, 100), "clock tree: surcharge on the dynamic energy of on-chip components whose clock is gated access by access", "%";
    }
}
