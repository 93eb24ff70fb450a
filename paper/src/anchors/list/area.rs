//! Square millimetres.

use rayreel_machine::AreaReport;

use crate::anchors::anchor::{Anchor, Rows, Value};

pub const ANCHORS: &[Anchor] = &[
    Anchor {
        name: "area of SGRT",
        source: "Lee et al. 2013 (SGRT, HPG), recalled, about 50 %: 25 mm2 at 65 nm for four cores x 0.115 to 14 nm = 2.9 mm2; a \
                 factor of two either way",
        unit: "mm2",
        low: Some(1.45),
        high: Some(5.8),
        rows: Rows::One(Some("sgrt-ti2")),
        value: Value::Config(|config, _| Some(AreaReport::new(config).gpu_mm2())),
        why: &[],
    },
    Anchor {
        name: "hybrid numbers, smaller box unit",
        source: "Hwang et al. 2015 (hybrid numbers, SIGGRAPH Asia MGIA), abstract: 35 % less area",
        unit: "%",
        low: Some(34.5),
        high: Some(35.5),
        rows: Rows::One(Some("sgrt-hybrid-number")),
        value: Value::Config(|hybrid, base| Some(less(hybrid.area.box_um2, base.area.box_um2))),
        why: &[],
    },
    Anchor {
        name: "hybrid numbers, smaller triangle unit",
        source: "Hwang et al. 2015 (hybrid numbers, SIGGRAPH Asia MGIA), abstract: 16 % less area",
        unit: "%",
        low: Some(15.5),
        high: Some(16.5),
        rows: Rows::One(Some("sgrt-hybrid-number")),
        value: Value::Config(|hybrid, base| Some(less(hybrid.area.triangle_um2, base.area.triangle_um2))),
        why: &[],
    },
];

/// By how many percent an area is smaller than another.
fn less(new: u64, old: u64) -> f64 {
    100.0 * (1.0 - new as f64 / old as f64)
}
