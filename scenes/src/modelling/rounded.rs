//! Rounded bodies between a box and an ellipsoid.

use glam::DVec3;

use crate::modelling::part::{Part, sin_cos};

/// A superellipsoid about the origin: `half` sizes; `roundness` 1 is an ellipsoid, small values come near
/// a box. Closed.
#[must_use]
pub fn rounded(half: DVec3, roundness: f64, segments: usize) -> Part {
    let rows = segments / 2;
    let power = |v: f64| libm::copysign(libm::pow(v.abs(), roundness), v);
    Part::grid(rows + 1, segments, true, |row, column| {
        if row == 0 || row == rows {
            return DVec3::new(0.0, if row == 0 { -half.y } else { half.y }, 0.0);
        }
        let (sin, cos) = sin_cos(std::f64::consts::PI * (row as f64 / rows as f64 - 0.5));
        let (sin_c, cos_c) = sin_cos(std::f64::consts::TAU * (column as f64 + 0.5) / segments as f64);
        let flat = power(cos);
        DVec3::new(half.x * flat * power(sin_c), half.y * power(sin), half.z * flat * power(cos_c))
    })
    .crease(60.0)
}

/// Turns a part about the z axis (pitch): counter-clockwise seen from +z, the front upwards.
#[must_use]
pub fn pitched(part: Part, degrees: f64) -> Part {
    let (sin, cos) = sin_cos(degrees.to_radians());
    part.map(|p| DVec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z))
}

/// Lays a part that stands on y down so that its axis points along +z.
#[must_use]
pub fn axis_to_z(part: Part) -> Part {
    part.map(|p| DVec3::new(p.x, -p.z, p.y))
}

/// Lays a part that stands on y down so that its axis points along +x.
#[must_use]
pub fn axis_to_x(part: Part) -> Part {
    part.map(|p| DVec3::new(p.y, -p.x, p.z))
}
