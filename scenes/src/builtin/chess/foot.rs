//! The turned foot of every chessman.

use crate::modelling::profile::{Knot, c, s};

/// The profile of the foot, up to the waist at `height`; radii scale with `r`.
pub fn foot(r: f64, height: f64) -> Vec<Knot> {
    vec![
        c(0.0, 0.0),
        c(r * 0.97, 0.0),
        s(r, 0.025),
        s(r, 0.085),
        c(r * 0.93, 0.12),
        s(r * 0.95, 0.15),
        s(r * 0.80, 0.20),
        c(r * 0.66, 0.235),
        s(r * 0.62, 0.26),
        s(r * 0.45, 0.26 + (height - 0.26) * 0.45),
        s(r * 0.36, height),
    ]
}
