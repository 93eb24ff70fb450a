//! What several anchors replay.

use crate::anchors::anchor::{Of, On};

/// The presets after SGRT.
pub const SGRT: &[&str] = &[
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
pub const FULL: Of = full(On::Row);

/// Every sample on a machine.
pub const fn full(on: On) -> Of {
    Of { policy: "full", samples: 2, on }
}

/// The paper's supersampling on a machine.
pub const fn supersampling(on: On) -> Of {
    Of { policy: "paper-ss", samples: 2, on }
}
