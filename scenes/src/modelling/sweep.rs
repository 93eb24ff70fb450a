//! Bars and strips along a path.

use glam::{DVec2, DVec3};

use crate::modelling::part::{Part, sin_cos};

/// An elliptic bar along a path, closed by flat caps; `radii` are half the width to the side and half the
/// height along `up`, which must not run along the path.
#[must_use]
pub fn bar(path: &[DVec3], up: DVec3, radii: DVec2, sides: usize) -> Part {
    let count = path.len();
    Part::grid(count + 2, sides, true, |row, column| match row {
        0 => path[0],
        r if r > count => path[count - 1],
        r => {
            let tangent = path[r.min(count - 1)] - path[r.saturating_sub(2)];
            path[r - 1] + around(tangent, up, radii, column, sides)
        }
    })
}

/// An elliptic bar along a closed path, like [`bar`].
#[must_use]
pub fn ring(path: &[DVec3], up: DVec3, radii: DVec2, sides: usize) -> Part {
    let count = path.len();
    Part::grid(count + 1, sides, true, |row, column| {
        let tangent = path[(row + 1) % count] - path[(row + count - 1) % count];
        path[row % count] + around(tangent, up, radii, column, sides)
    })
}

/// A bar's surface relative to its path.
fn around(tangent: DVec3, up: DVec3, radii: DVec2, column: usize, sides: usize) -> DVec3 {
    let side = tangent.cross(up).normalize_or_zero();
    let up = side.cross(tangent).normalize_or_zero();
    // Turning from `up` to `side` is right-handed about the path: so the front of the grid is the outside.
    let (sin, cos) = sin_cos(std::f64::consts::TAU * (column as f64 + 0.5) / sides as f64);
    up * (cos * radii.y) + side * (sin * radii.x)
}

/// A circle about `centre`, `axis` a unit vector, as a closed path.
#[must_use]
pub fn circle(centre: DVec3, axis: DVec3, radius: f64, points: usize) -> Vec<DVec3> {
    let first = axis.any_orthonormal_vector();
    let second = axis.cross(first);
    (0..points)
        .map(|i| {
            let (sin, cos) = sin_cos(std::f64::consts::TAU * i as f64 / points as f64);
            centre + (first * cos + second * sin) * radius
        })
        .collect()
}
