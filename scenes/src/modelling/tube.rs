//! Tubes along a path: hoses, wires, bent glass.

use glam::DVec3;

use crate::modelling::part::{Part, sin_cos};

/// A skin of rings round a path. Each row is a station of the path and a radius; rows that go along the path show
/// their outside, rows that come back show the inside of a bore.
#[must_use]
pub fn sweep(path: &[DVec3], rows: &[(usize, f64)], segments: usize) -> Part {
    let frames = frames(path);
    Part::grid(rows.len(), segments, true, |row, column| {
        let (station, radius) = rows[row];
        let (across, up) = frames[station];
        let (sin, cos) = sin_cos(std::f64::consts::TAU * column as f64 / segments as f64);
        path[station] + (across * cos + up * sin) * radius
    })
}

/// A solid round rod along a path, flat at both ends.
#[must_use]
pub fn rod(path: &[DVec3], radius: f64, segments: usize) -> Part {
    let last = path.len() - 1;
    let mut rows = vec![(0, 0.0)];
    rows.extend((0..path.len()).map(|station| (station, radius)));
    rows.push((last, 0.0));
    sweep(path, &rows, segments)
}

/// A pipe along a path, open at both ends: a closed ring-shaped solid with a bore.
#[must_use]
pub fn pipe(path: &[DVec3], radius: f64, bore: f64, segments: usize) -> Part {
    let mut rows: Vec<(usize, f64)> = (0..path.len()).map(|station| (station, radius)).collect();
    rows.extend((0..path.len()).rev().map(|station| (station, bore)));
    rows.push((0, radius));
    sweep(path, &rows, segments)
}

/// A path through the points with its corners rounded: each becomes `pieces` steps of a parabola that starts `reach`
/// before the corner, or half-way to the next point where that is nearer.
#[must_use]
pub fn rounded(points: &[DVec3], reach: f64, pieces: usize) -> Vec<DVec3> {
    let mut path = vec![points[0]];
    for corner in points.windows(3) {
        let towards = |end: DVec3| {
            let way = end - corner[1];
            corner[1] + way.normalize_or_zero() * reach.min(way.length() * 0.499)
        };
        let (from, to) = (towards(corner[0]), towards(corner[2]));
        path.extend((0..=pieces).map(|piece| {
            let t = piece as f64 / pieces as f64;
            from * ((1.0 - t) * (1.0 - t)) + corner[1] * (2.0 * t * (1.0 - t)) + to * (t * t)
        }));
    }
    path.extend(points.last().copied());
    path
}

/// Two directions across the path at each station, carried along without twist; the first cross the second is the
/// direction of the path.
fn frames(path: &[DVec3]) -> Vec<(DVec3, DVec3)> {
    let last = path.len() - 1;
    let mut across = DVec3::ZERO;
    (0..path.len())
        .map(|station| {
            let along = (path[(station + 1).min(last)] - path[station.saturating_sub(1)]).normalize_or_zero();
            if station == 0 {
                across = along.any_orthonormal_vector();
            }
            across = (across - along * across.dot(along)).normalize_or_zero();
            (across, along.cross(across))
        })
        .collect()
}
