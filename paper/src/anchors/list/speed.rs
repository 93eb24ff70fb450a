//! Rays a second, and what they ask of the memory.

use super::replays::{FULL, SGRT};
use crate::anchors::anchor::{Anchor, Rows, SCENES, Value, Why};
use crate::anchors::of::{count, dram_bytes, figure, tree_bytes};

/// Of all the machines that wait for memory.
const WAITS: &str = "Small pictures begin with cold caches and end with idle cores, and speed rises with their size. On \
                     sgrt-ti2 at 128x64 pixels teapot and car are above the bound and the others below: there the triangle \
                     units wait for memory in 23 to 53 % of the cycles, and the DRAM gives about 70 % of its peak.";

pub const ANCHORS: &[Anchor] = &[
    Anchor {
        name: "throughput",
        source: "Lee et al. 2016: about 300 Mrays/s for ray-tracing hardware of 2016; a third of it as the least, at 500 MHz",
        unit: "Mrays/s",
        low: Some(100.0),
        high: Some(300.0),
        rows: Rows::Machines(SGRT),
        value: Value::Runs(&[FULL], |of| Some(figure(&of[0], "rays_machine")? / figure(&of[0], "time_ms")? * 1e-3)),
        why: &[
            Why {
                of: &["no-direct-interface"],
                below: "Rays and hits are written to memory and read again, 104 bytes a ray, on a DRAM that already gives \
                        about 70 % of its peak in three of the five scenes: the baseline that the direct interface replaced.",
                above: "",
            },
            Why { of: &[], below: WAITS, above: "" },
        ],
    },
    Anchor {
        name: "throughput of RayCore",
        source: "RayCore (embedded.com report): up to 239 Mrays/s; at least 21 % of the peak, as RayCore Lite reaches in a \
                 Cornell box (semiiphub.com)",
        unit: "Mrays/s",
        low: Some(50.0),
        high: Some(239.0),
        rows: Rows::One(Some("raycore")),
        value: Value::Runs(&[FULL], |of| Some(figure(&of[0], "rays_machine")? / figure(&of[0], "time_ms")? * 1e-3)),
        why: &[Why {
            of: &[],
            below: "A ray takes 30 to 63 node visits and triangle tests in these scenes, one a cycle in each of six pipelines: \
                    48 to 101 Mrays/s at most at 500 MHz. At 128x64 pixels teapot and car (55) lie inside, and the others \
                    below. One pipeline a unit is an assumption, for the report gives no count. With it the stated peak leaves \
                    12.6 a ray, so it is one of short rays, or units have more pipelines. Ours issue in nearly every cycle in \
                    which they have rays, a part of them bypasses.",
            above: "",
        }],
    },
    Anchor {
        name: "DRAM lines a ray",
        source: "our estimate: 0.1 to 0.3 lines of 64 B a ray for nodes and triangles, with 1.35 nJ a ray on chip",
        unit: "lines/ray",
        low: Some(0.1),
        high: Some(0.3),
        rows: Rows::Machines(SGRT),
        value: Value::Runs(&[FULL], |of| Some(tree_bytes(&of[0])? / 64.0 / figure(&of[0], "rays_machine")?)),
        why: &[Why {
            of: &[],
            below: "",
            above: "The estimate is of coherent rays and warm caches. Here 60 to 93 % of the rays are shadow and secondary \
                    rays, triangles alone take 0.7 to 29 MB against an L2 of 256 KiB, whose size is a guess, and every line is \
                    first touched in this one frame: the figure falls as pictures grow. At 128x64 pixels teapot alone lies \
                    inside on sgrt-ti2, with 0.29, and provence takes 6.5.",
        }],
    },
    Anchor {
        name: "DRAM traffic of RayCore",
        source: "RayCore (embedded.com report): below 1.1 GB/s",
        unit: "GB/s",
        low: None,
        high: Some(1.1),
        rows: Rows::One(Some("raycore")),
        value: Value::Runs(&[FULL], |of| Some(dram_bytes(&of[0])? / figure(&of[0], "time_ms")? * 1e-6)),
        why: &[Why {
            of: &[],
            below: "",
            above: "Most of it are nodes and triangles that missed: most rays are shadow and secondary rays, in trees larger \
                    than the caches, and the caches are cold. At 128x64 pixels teapot takes 1.5 GB/s, car 5, and the others 8 \
                    to 9. RayCore walks a kd-tree, in caches whose sizes we do not know.",
        }],
    },
    Anchor {
        name: "box tests a triangle test",
        source: "seven scenes of AQB8's evaluation (lashhw/paper-figures), trees of two children",
        unit: "1",
        low: Some(2.8),
        high: Some(8.4),
        rows: Rows::Scenes("sgrt-ti2", SCENES),
        value: Value::Runs(&[FULL], |of| {
            Some(count(&of[0], "ti/trv/box_tests")? / count(&of[0], "ti/ist/triangle_tests")?)
        }),
        why: &[Why {
            of: &["provence"],
            below: "",
            above: "Its rays visit 53 nodes each, through foliage and grass, against 21 to 32 in the other scenes, and test no \
                    more triangles: 10 against 7 to 16.",
        }],
    },
];
