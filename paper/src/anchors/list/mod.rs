//! The anchors, by what they are about. Bounds and sources only: nothing here is measured.

mod area;
mod energy;
mod mechanisms;
mod sampling;
mod speed;

use super::anchor::{Anchor, Of, On};

/// All anchors, in the order of the table.
pub fn all() -> impl Iterator<Item = &'static Anchor> {
    [speed::ANCHORS, energy::ANCHORS, mechanisms::ANCHORS, area::ANCHORS, sampling::ANCHORS].into_iter().flatten()
}

/// The presets after SGRT.
const SGRT: &[&str] = &[
    "sgrt-ti2",
    "sgrt-ti1",
    "sgrt-ti2-retry",
    "sgrt-ti2-accumulate",
    "sgrt-ti2-rob",
    "sgrt-hybrid-number",
    "hybrid-raster",
    "external-buffers",
    "no-direct-interface",
];

/// Every sample on the row's machine.
const FULL: Of = full(On::Row);

/// Every sample on a machine.
const fn full(on: On) -> Of {
    Of { policy: "full", samples: 2, on }
}

/// The paper's supersampling on a machine.
const fn supersampling(on: On) -> Of {
    Of { policy: "paper-ss", samples: 2, on }
}

#[cfg(test)]
mod tests;
