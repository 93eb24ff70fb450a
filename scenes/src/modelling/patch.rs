//! Bicubic Bezier patches.

use glam::DVec3;

use crate::modelling::part::Part;

/// Sixteen control points, row by row.
pub type Patch = [[DVec3; 4]; 4];

/// A point of a patch: `u` along a row, `v` across the rows.
#[must_use]
pub fn point(patch: &Patch, u: f64, v: f64) -> DVec3 {
    let across = bernstein(v);
    let along = bernstein(u);
    let mut sum = DVec3::ZERO;
    for (row, weight) in patch.iter().zip(across) {
        for (control, inner) in row.iter().zip(along) {
            sum += *control * (weight * inner);
        }
    }
    sum
}

/// Cuts a patch into `columns` x `rows` cells; the front is where `u` x `v` points.
#[must_use]
pub fn tessellate(patch: &Patch, columns: usize, rows: usize) -> Part {
    Part::grid(rows + 1, columns + 1, false, |row, column| {
        point(patch, column as f64 / columns as f64, row as f64 / rows as f64)
    })
}

fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}
