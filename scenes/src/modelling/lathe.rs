//! Solids of revolution, and variations round the axis.

use glam::{DVec2, DVec3};

use crate::modelling::part::{Part, sin_cos};

/// Turns a profile (radius, height; from the bottom up, outside to the right) about the y axis. A
/// profile that starts and ends on the axis gives a closed solid.
#[must_use]
pub fn lathe(profile: &[DVec2], segments: usize) -> Part {
    lathe_with(profile.len(), segments, |row, _, _| profile[row])
}

/// Like [`lathe`], but the point of each row may depend on the angle: `shape(row, angle, column)`.
pub fn lathe_with(rows: usize, segments: usize, shape: impl Fn(usize, f64, usize) -> DVec2) -> Part {
    Part::grid(rows, segments, true, |row, column| {
        let angle = std::f64::consts::TAU * column as f64 / segments as f64;
        let (sin, cos) = sin_cos(angle);
        let p = shape(row, angle, column);
        // With rows upwards, columns must run from z to x for the outside to be the front.
        DVec3::new(p.x * sin, p.y, p.x * cos)
    })
}

/// A sphere about a centre.
#[must_use]
pub fn sphere(centre: DVec3, radius: f64, segments: usize) -> Part {
    let rings = segments / 2;
    let profile: Vec<DVec2> = (0..=rings)
        .map(|i| {
            let (sin, cos) = sin_cos(std::f64::consts::PI * i as f64 / rings as f64);
            // The poles lie exactly on the axis, so that the solid closes.
            if i == 0 || i == rings { DVec2::new(0.0, -cos * radius) } else { DVec2::new(sin * radius, -cos * radius) }
        })
        .collect();
    lathe(&profile, segments).at(centre.x, centre.y, centre.z)
}
