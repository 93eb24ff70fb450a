//! Rays a second, and what they ask of the memory.

use super::{FULL, SGRT};
use crate::anchors::anchor::{Anchor, Rows, SCENES, Value};
use crate::anchors::of::{count, dram_bytes, figure, tree_bytes};

pub const ANCHORS: &[Anchor] = &[
    Anchor {
        name: "throughput",
        source: "Lee et al. 2016: about 300 Mrays/s for ray-tracing hardware of 2016; a third of it as the least, at 500 MHz",
        unit: "Mrays/s",
        low: Some(100.0),
        high: Some(300.0),
        rows: Rows::Machines(SGRT),
        value: Value::Runs(&[FULL], |of| Some(figure(&of[0], "rays_machine")? / figure(&of[0], "time_ms")? * 1e-3)),
        why: &[],
    },
    Anchor {
        name: "throughput of RayCore",
        source: "RayCore (embedded.com report): up to 239 Mrays/s; at least 21 % of the peak, as RayCore Lite reaches in a Cornell \
                 box (semiiphub.com)",
        unit: "Mrays/s",
        low: Some(50.0),
        high: Some(239.0),
        rows: Rows::One(Some("raycore")),
        value: Value::Runs(&[FULL], |of| Some(figure(&of[0], "rays_machine")? / figure(&of[0], "time_ms")? * 1e-3)),
        why: &[],
    },
    Anchor {
        name: "DRAM lines a ray",
        source: "estimate: 0.1 to 0.3 lines of 64 B a ray for nodes and triangles, with 1.35 nJ a ray on chip",
        unit: "lines/ray",
        low: Some(0.1),
        high: Some(0.3),
        rows: Rows::Machines(SGRT),
        value: Value::Runs(&[FULL], |of| Some(tree_bytes(&of[0])? / 64.0 / figure(&of[0], "rays_machine")?)),
        why: &[],
    },
    Anchor {
        name: "DRAM traffic of RayCore",
        source: "RayCore (embedded.com report): below 1.1 GB/s",
        unit: "GB/s",
        low: None,
        high: Some(1.1),
        rows: Rows::One(Some("raycore")),
        value: Value::Runs(&[FULL], |of| Some(dram_bytes(&of[0])? / figure(&of[0], "time_ms")? * 1e-6)),
        why: &[],
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
        why: &[],
    },
];
