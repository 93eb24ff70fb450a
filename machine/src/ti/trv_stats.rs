//! What a traversal unit counts.

use super::input_buffer::InputBufferCounters;
use crate::config::Pipeline;
use crate::counters::{Activity, counters};
use crate::memory::CacheCounters;

counters! {
    /// What a traversal unit did.
    pub struct TrvCounters {
        rays: "rays", "rays that finished";
        node_visits: "events", "inner nodes visited, visits on restarts included";
        restart_visits: "events", "inner nodes visited again because the short stack had lost a child";
        box_tests: "events", "boxes tested";
        leaves: "events", "leaves processed";
        triangle_tests: "events", "triangles tested here (pipeline = \"unified\")";
        stack_operations: "events", "operations of the stack pipeline";
        culled: "events", "popped children that lay behind the closest hit";
        pushes: "events", "children pushed onto the stack, on restarts again";
        restarts: "events", "pops that found the short stack empty while children were deferred";
        bypasses: "events", "operations that passed a pipeline without work";
        ray_cycles: "cycles", "cycles that rays spent here, summed over rays";
    }
}

/// What a unit reports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TrvStats {
    /// Each issue stage with what it did in every cycle.
    pub stages: Vec<(&'static str, Activity)>,
    /// Events.
    pub events: TrvCounters,
    /// Input buffer.
    pub buffer: InputBufferCounters,
    /// L1.
    pub l1: CacheCounters,
}

/// The issue stages of a traversal unit.
pub fn stage_names(pipeline: Pipeline) -> &'static [&'static str] {
    match pipeline {
        Pipeline::Parallel => &["inner", "leaf", "stack"],
        Pipeline::Single | Pipeline::Unified => &["pipeline"],
        Pipeline::Software => &["threads"],
        Pipeline::Gathering => &["boxes", "triangles"],
    }
}
