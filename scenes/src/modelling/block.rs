//! Flat things: rectangles, boxes, extruded outlines.

use glam::{DVec2, DVec3};

use crate::modelling::part::Part;

/// A rectangle from a corner along two sides; the front is where `along` x `up` points.
#[must_use]
pub fn rectangle(corner: DVec3, along: DVec3, up: DVec3) -> Part {
    Part {
        positions: vec![corner, corner + along, corner + along + up, corner + up],
        uvs: vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Part::default()
    }
}

/// A closed box between two corners, the texture repeated on each face.
#[must_use]
pub fn block(low: DVec3, high: DVec3) -> Part {
    let d = high - low;
    let (x, y, z) = (DVec3::new(d.x, 0.0, 0.0), DVec3::new(0.0, d.y, 0.0), DVec3::new(0.0, 0.0, d.z));
    // Corners are picked, not summed, so that faces share their corners bit by bit.
    let face = |corner, along, up| rectangle(corner, along, up).map(|p| snap(p, low, high));
    face(low + z, x, y)
        .with(face(low + x, -x, y))
        .with(face(low, z, y))
        .with(face(low + x + z, -z, y))
        .with(face(low + y + z, x, -z))
        .with(face(low, x, z))
}

/// Moves each coordinate to the nearer of two values.
fn snap(p: DVec3, low: DVec3, high: DVec3) -> DVec3 {
    let nearer = |v: f64, a: f64, b: f64| if (v - a).abs() < (v - b).abs() { a } else { b };
    DVec3::new(nearer(p.x, low.x, high.x), nearer(p.y, low.y, high.y), nearer(p.z, low.z, high.z))
}

/// A closed box with its four upright and its four upper edges cut by `bevel`.
#[must_use]
pub fn bevelled(low: DVec3, high: DVec3, bevel: f64) -> Part {
    let ring = |inset: f64, y: f64| {
        let (l, h) = (low + DVec3::splat(inset), high - DVec3::splat(inset));
        let b = bevel;
        [
            (l.x + b, h.z),
            (h.x - b, h.z),
            (h.x, h.z - b),
            (h.x, l.z + b),
            (h.x - b, l.z),
            (l.x + b, l.z),
            (l.x, l.z + b),
            (l.x, h.z - b),
        ]
        .map(|(x, z)| DVec3::new(x, y, z))
    };
    let middle = (low + high) / 2.0;
    let rows = [
        [DVec3::new(middle.x, low.y, middle.z); 8],
        ring(0.0, low.y),
        ring(0.0, high.y - bevel),
        ring(bevel, high.y),
        [DVec3::new(middle.x, high.y, middle.z); 8],
    ];
    Part::grid(rows.len(), 8, true, |row, column| rows[row][column]).crease(30.0)
}

/// A closed prism: an outline (counter-clockwise seen from +z, star-shaped about the origin) from
/// `-half` to `half` in z.
#[must_use]
pub fn prism(outline: &[DVec2], half: f64) -> Part {
    let at = |p: DVec2, z: f64| DVec3::new(p.x, p.y, z);
    Part::grid(4, outline.len(), true, |row, column| match row {
        0 => at(DVec2::ZERO, -half),
        1 => at(outline[column], -half),
        2 => at(outline[column], half),
        _ => at(DVec2::ZERO, half),
    })
}
