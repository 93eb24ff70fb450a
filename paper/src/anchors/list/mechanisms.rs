//! What one change of the hardware brings.

use super::replays::{FULL, full};
use crate::anchors::anchor::{Anchor, On, Rows, Value, Why};
use crate::anchors::of::{dram_bytes, hit_rate, largest, ratio};
use crate::anchors::run::Run;

/// Retry with more threads, the multithreaded units that the Reorder Buffer is compared with.
const RETRY: On = On::Preset("sgrt-ti2-retry");
/// Ray accumulation.
const ACCUMULATE: On = On::Preset("sgrt-ti2-accumulate");

const ROB: Rows = Rows::One(Some("sgrt-ti2-rob"));

const ROB_SOURCE: &str = "Lee et al. 2015 (Reorder Buffer, HPG), abstract: up to 11.7 % better cache utilisation, up to 4.7 \
                          times the energy efficiency; the largest of the five scenes";

const ROB_TALK: &str = "Lee et al. 2014 (SIGGRAPH Asia MGIA), abstract: performance and energy efficiency up to 5.5 times that \
                        of earlier architectures; the largest of the five scenes, time x energy of the T&I units";

pub const ANCHORS: &[Anchor] = &[
    Anchor {
        name: "two boxes a cycle over one",
        source: "Lee et al. 2014 (two-AABB traversal, SIGGRAPH Asia MGIA), abstract: up to 2.9 times as fast as the single \
                 pipeline; at least 1.5, since a node takes one pass and not two",
        unit: "x",
        low: Some(1.5),
        high: Some(2.9),
        rows: Rows::One(Some("sgrt-ti2")),
        value: Value::Runs(&[FULL, full(On::Preset("sgrt-ti1"))], |of| ratio("time_ms", &of[1], &of[0])),
        why: &[Why {
            of: &[],
            below: "Box tests are not the bottleneck of sgrt-ti2. At 128x64 pixels the factor is 1.4 in teapot and in car, \
                    where 91 and 76 % of the lookups of the traversal units hit, and 0.95 to 1.07 in the other scenes, where \
                    42 to 51 % do. In all scenes the leaf stages wait for the one triangle unit of a core in 68 to 91 % of \
                    the cycles: it tests in 82 (teapot), 60 (lab) and 58 % (car) of them, and waits for memory in 45 (chess) \
                    and 53 % (provence). The published factor is of a traversal unit whose triangle units keep up.",
            above: "",
        }],
    },
    Anchor {
        name: "Reorder Buffer, hit rate over retry",
        source: ROB_SOURCE,
        unit: "%",
        low: Some(0.0),
        high: Some(11.7),
        rows: ROB,
        value: Value::Runs(&[FULL, full(RETRY)], |of| largest(&of[0], &of[1], more_hits)),
        why: &[Why {
            of: &[],
            below: "",
            above: "Where misses retry, an operation looks its line up again after every bypass, and each such lookup counts \
                    as one that is no hit. In provence they are two fifths of all lookups even on sgrt-ti2, which holds half \
                    as many rays. The abstract does not say how it counts.",
        }],
    },
    Anchor {
        name: "Reorder Buffer, hit rate over accumulation",
        source: ROB_SOURCE,
        unit: "%",
        low: Some(0.0),
        high: Some(11.7),
        rows: ROB,
        value: Value::Runs(&[FULL, full(ACCUMULATE)], |of| largest(&of[0], &of[1], more_hits)),
        why: &[Why {
            of: &[],
            below: "Both look up once an operation. Rays issue in another order, so other lines are evicted, by a part of a \
                    percent either way.",
            above: "",
        }],
    },
    Anchor {
        name: "Reorder Buffer, energy efficiency over retry",
        source: ROB_SOURCE,
        unit: "x",
        low: Some(1.0),
        high: Some(4.7),
        rows: ROB,
        value: Value::Runs(&[FULL, full(RETRY)], |of| largest(&of[0], &of[1], less_energy)),
        why: &[],
    },
    Anchor {
        name: "Reorder Buffer, energy efficiency over accumulation",
        source: ROB_SOURCE,
        unit: "x",
        low: Some(1.0),
        high: Some(4.7),
        rows: ROB,
        value: Value::Runs(&[FULL, full(ACCUMULATE)], |of| largest(&of[0], &of[1], less_energy)),
        why: &[],
    },
    Anchor {
        name: "Reorder Buffer, performance x efficiency over retry",
        source: ROB_TALK,
        unit: "x",
        low: Some(1.0),
        high: Some(5.5),
        rows: ROB,
        value: Value::Runs(&[FULL, full(RETRY)], |of| {
            largest(&of[0], &of[1], |new, old| Some(less_energy(new, old)? * ratio("time_ms", old, new)?))
        }),
        why: &[],
    },
    Anchor {
        name: "hybrid numbers, smaller nodes",
        source: "Hwang et al. 2015 (hybrid numbers, SIGGRAPH Asia MGIA), abstract: boxes in 40 % less space; a node of 64 B \
                 becomes one of 40 to 45 B",
        unit: "%",
        low: Some(30.0),
        high: Some(40.0),
        rows: Rows::One(Some("sgrt-hybrid-number")),
        value: Value::Config(|hybrid, base| {
            Some(100.0 * (1.0 - f64::from(hybrid.layout.node_bytes) / f64::from(base.layout.node_bytes)))
        }),
        why: &[],
    },
    Anchor {
        name: "hybrid rasteriser, frames a joule",
        source: "Lee et al. 2015 (hybrid rendering for tile-based mobile GPUs, SIGGRAPH Asia MGIA), abstract: performance per \
                 energy up to 2.18 times that of ray tracing alone; the largest of the five scenes, whole GPU",
        unit: "x",
        low: Some(1.0),
        high: Some(2.18),
        rows: Rows::One(Some("hybrid-raster")),
        value: Value::Runs(&[FULL, full(On::Preset("sgrt-ti2"))], |of| {
            largest(&of[0], &of[1], |new, old| ratio("gpu_energy_mj", old, new))
        }),
        why: &[],
    },
    Anchor {
        name: "direct interface, less DRAM traffic",
        source: "Shin et al. 2013 (SIGGRAPH Asia MGIA), abstract: 48 % less memory traffic in the mean, on an FPGA prototype; \
                 ten points either way",
        unit: "%",
        low: Some(38.0),
        high: Some(58.0),
        rows: Rows::One(Some("sgrt-ti2")),
        value: Value::Runs(&[FULL, full(On::Preset("no-direct-interface"))], |of| {
            Some(100.0 * (1.0 - dram_bytes(&of[0])? / dram_bytes(&of[1])?))
        }),
        why: &[Why {
            of: &[],
            below: "Rays and hits cost 104 bytes of traffic a ray; in small pictures misses of the tree, which both machines \
                    have, are several times that.",
            above: "Rays and hits cost 104 bytes of traffic a ray. Misses of the tree, which both machines have, fall as \
                    pictures grow, so the share of messages rises; the prototype also had other scenes and no L2 that we know \
                    of.",
        }],
    },
];

/// How much higher a hit rate is, in percent of the lower one.
fn more_hits(new: &[Run<'_>], old: &[Run<'_>]) -> Option<f64> {
    Some(100.0 * (hit_rate(new)? / hit_rate(old)? - 1.0))
}

fn less_energy(new: &[Run<'_>], old: &[Run<'_>]) -> Option<f64> {
    ratio("energy_mj", old, new)
}
