//! The traversal and intersection unit of a core.

use rayreel_settings::Rule::Integer;
use rayreel_settings::{settings, words};

use super::cache::L1;
use super::rules::{CLOCK, DEPTH};

words! {
    /// How the three kinds of traversal work share hardware.
    pub enum Pipeline {
        /// Inner-node, leaf and stack work each have their own pipeline (SA'12 poster).
        Parallel = "parallel",
        /// One pipeline: one operation of any of the three a cycle, each passing all stages.
        Single = "single",
        /// As `Single`, and triangle tests pass it too (RayCore): there is no separate intersection unit.
        Unified = "unified",
        /// Rays that need the same node or triangle are gathered and tested together (PowerVR's Wizard); triangles too.
        Gathering = "gathering",
        /// No pipeline: threads of processors walk the tree by instructions, and run the kernels too.
        Software = "software",
    }

    /// What happens to an operation whose data miss the L1.
    pub enum MissHandling {
        /// It passes the pipeline as a bypass and tries again.
        Retry = "retry",
        /// It is parked in a row of the ray accumulation buffer until the line arrives.
        Accumulate = "accumulate",
        /// It stays in its slot of the input buffer; slots issue in the order in which they are ready (Reorder Buffer).
        Reorder = "reorder",
    }
}

settings! {
    /// The T&I unit.
    #[serde(deny_unknown_fields)]
    pub struct Ti {
        clock_mhz: u32 = CLOCK, "clock of T&I units, their L1s and the L2", "MHz";
        trv: u32 = Integer(1, 16), "traversal units of a core";
        ist: u32 = Integer(0, 16), "intersection units of a core";
        pipeline: Pipeline = Pipeline::RULE, "pipeline arrangement";
        aabbs_per_cycle: u32 = Integer(1, 2), "boxes tested per cycle: 2 tests a node's children together, 1 takes two passes";
        ray_fifo_entries: u32 = Integer(1, 1024), "entries of the dispatcher's ray buffer";
        // 128 but for `gathering`: slot masks have 128 bits.
        rays_per_trv: u32 = Integer(1, 4096), "rays that a traversal unit holds; at most 128 unless they are gathered";
        gather_boxes: u32 = Integer(1, 64), "rays of a queue that are tested against a node's boxes a cycle (gathering)";
        gather_triangles: u32 = Integer(1, 64), "rays of a queue that are tested against a triangle a cycle (gathering)";
        gather_queues: u32 = Integer(1, 128), "nodes and triangles that rays are gathered for at a time (gathering)";
        gather_wait_cycles: u32 = Integer(0, 10_000), "a ray waits so long for others that need the same (gathering)", "cycles";
        ray_record_bytes: u32 = Integer(1, 1024), "a ray's record in a ray buffer", "bytes";
        ist_entries: u32 = Integer(1, 128), "entries of the input buffer of an intersection unit", "leaf tasks";
        miss_handling: MissHandling = MissHandling::RULE, "miss handling of traversal units";
        ist_miss_handling: MissHandling = MissHandling::RULE, "miss handling of intersection units";
        accumulate_rows: u32 = Integer(1, 128),
            "rows of a ray accumulation buffer: lines waited for at a time (accumulate)";
        accumulate_rays_per_row: u32 = Integer(1, 128), "rays that a row can hold (accumulate)";
        setup_cycles: u32 = DEPTH, "ray setup (reciprocal direction)", "cycles";
        inner_cycles: u32 = DEPTH, "depth of the inner-node pipeline", "cycles";
        leaf_cycles: u32 = DEPTH, "depth of the leaf pipeline", "cycles";
        stack_cycles: u32 = DEPTH, "depth of the stack pipeline", "cycles";
        ist_cycles: u32 = DEPTH, "depth of the triangle pipeline", "cycles";
        crossbar_cycles: u32 = DEPTH, "crossbar between TRV and IST units, per direction", "cycles";
        stack_entries: u32 = Integer(0, 64), "entries of the short stack; 0 is a full stack, never restarted";
        full_stack_entries: u32 = Integer(1, 256), "entries of a full stack, for leakage and area";
        stack_entry_bytes: u32 = Integer(1, 64), "an entry of a stack", "bytes";
        /// Banks by line: with one, a node that straddles two lines takes two cycles.
        trv_lines_per_cycle: u32 = Integer(1, 4), "neighbouring lines that a traversal unit reads from its L1 in a cycle";
        ist_lines_per_cycle: u32 = Integer(1, 4), "the same for the triangles of an intersection unit";
        trv_l1: L1, "L1 of each traversal unit";
        ist_l1: L1, "L1 of each intersection unit";
    }
}
