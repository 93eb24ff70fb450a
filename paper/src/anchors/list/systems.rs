//! Machines of other architects: software traversal, and ray units that gather rays.

use super::replays::FULL;
use crate::anchors::anchor::{Anchor, Rows, Value, Why};
use crate::anchors::of::{count, figure};

const SOFTWARE: &[&str] = &["mimd-trax", "simt-mimd", "simt-mimd-vector"];

const IMAGINATION: &str = "Imagination 2014 (blog.imgtec.com, PowerVR GR6500)";

pub const ANCHORS: &[Anchor] = &[
    Anchor {
        name: "throughput of software traversal",
        source: "Lee et al. 2016 on Spjut et al. 2012 and Kim et al. 2012: less than 30 Mrays/s",
        unit: "Mrays/s",
        low: None,
        high: Some(30.0),
        rows: Rows::Machines(SOFTWARE),
        value: Value::Runs(&[FULL], |of| Some(figure(&of[0], "rays_machine")? / figure(&of[0], "time_ms")? * 1e-3)),
        why: &[],
    },
    Anchor {
        name: "throughput of a multiprocessor",
        source: "Kim et al. 2010 (CICC), abstract: at most 0.673 Mrays/s with twelve stream processors; at least 21 % of the \
                 peak, as RayCore Lite reaches in a Cornell box (semiiphub.com). Kim et al. 2012 (MRTP, JSSC), abstract: the same \
                 rate, power and size for three times twelve; which abstract is right is not known",
        unit: "Mrays/s",
        low: Some(0.141),
        high: Some(0.673),
        rows: Rows::One(Some("simt-mimd")),
        value: Value::Runs(&[FULL], |of| {
            // Three multiprocessors at 100 MHz.
            Some(figure(&of[0], "rays_machine")? / figure(&of[0], "time_ms")? * 1e-3 / 3.0)
        }),
        why: &[Why {
            of: &[],
            below: "The stated rate is a peak, and leaves 1800 instructions a ray at 100 MHz; here a ray takes 21 to 53 node \
                    visits of 65 instructions and 7 to 16 triangles of 69, in warps of which fewer than half of the lanes are \
                    at work. At 128x64 pixels teapot, chess and car lie inside (0.19 to 0.20), lab and provence below (0.11 \
                    and 0.10), and all together just below. If the rate is that of three multiprocessors, the bounds of one \
                    are 0.047 to 0.224.",
            above: "",
        }],
    },
    Anchor {
        name: "throughput of GR6500",
        source: "Imagination 2014 (blog.imgtec.com, PowerVR GR6500): up to 300 Mrays/s; at least 21 % of the peak, as RayCore Lite \
                 reaches in a Cornell box (semiiphub.com)",
        unit: "Mrays/s",
        low: Some(63.0),
        high: Some(300.0),
        rows: Rows::One(Some("gr6500")),
        value: Value::Runs(&[FULL], |of| Some(figure(&of[0], "rays_machine")? / figure(&of[0], "time_ms")? * 1e-3)),
        why: &[Why {
            of: &[],
            below: "Small pictures begin with cold caches and end with idle units, and a tile has too few rays for 512 places in \
                    each of four units: speed rises with the size of the picture.",
            above: "",
        }],
    },
    Anchor {
        name: "box tests a second of GR6500",
        source: IMAGINATION,
        unit: "G/s",
        low: None,
        high: Some(24.0),
        rows: Rows::One(Some("gr6500")),
        value: Value::Runs(&[FULL], |of| Some(count(&of[0], "ti/trv/box_tests")? / figure(&of[0], "time_ms")? * 1e-6)),
        why: &[],
    },
    Anchor {
        name: "box tests a ray of GR6500",
        source: "Imagination 2014 (blog.imgtec.com, PowerVR GR6500): 24 billion node tests and 300 million rays a second, 80 a \
                 ray; a factor of two either way",
        unit: "1",
        low: Some(40.0),
        high: Some(160.0),
        rows: Rows::One(Some("gr6500")),
        value: Value::Runs(&[FULL], |of| Some(count(&of[0], "ti/trv/box_tests")? / figure(&of[0], "rays_machine")?)),
        why: &[],
    },
];
