//! What stands far behind a scene, all round it.

use glam::{DVec2, DVec3};

use crate::modelling::part::{Part, sin_cos};

/// A round wall that looks inwards, from height `span[0]` to `span[1]`; a texture repeats `repeats` times round
/// it and up it, without a seam where the first number is whole.
#[must_use]
pub fn ring(radius: f64, span: [f64; 2], segments: usize, repeats: DVec2) -> Part {
    let turn = |column: usize| sin_cos(std::f64::consts::TAU * (column % segments) as f64 / segments as f64);
    // One column more than segments: the last lies on the first, with the texture's other end.
    let mut part = Part::grid(2, segments + 1, false, |row, column| {
        let (sin, cos) = turn(column);
        DVec3::new(radius * cos, span[row], radius * sin)
    });
    for (i, uv) in part.uvs.iter_mut().enumerate() {
        let (row, column) = (i / (segments + 1), i % (segments + 1));
        *uv = DVec2::new(column as f64 / segments as f64, row as f64) * repeats;
    }
    part
}
