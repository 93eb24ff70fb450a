//! Shading normals from geometry: smooth within a crease angle, weighted by corner angles.

use std::{collections::BTreeMap, path::Path};

use glam::{DVec3, Vec3};

use crate::warnings::Warnings;

/// Faces that meet at a sharper angle than 40 degrees keep an edge.
pub(crate) const CREASE_COS: f64 = 0.766_044_443_118_978;
/// A vertex with more corners than this is the hub of a huge fan. Comparing all pairs of its corners would take for
/// ever, so they keep the normals of their faces.
const MAX_CORNERS: usize = 1024;

/// A group and a position in it, bit by bit.
type GroupedPosition = (u32, [u32; 3]);
/// A triangle and which of its corners.
type Corner = (usize, usize);

/// Twice the area vector of a triangle, in `f64`.
pub(crate) fn area_vector(positions: &[Vec3], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|v| positions[v as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Whether a triangle is a point or a line as far as its coordinates can tell: its height is below the rounding of
/// its largest coordinate.
pub(crate) fn is_degenerate(positions: &[Vec3], triangle: [u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|v| positions[v as usize].as_dvec3());
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    let height_times_base = (b - a).cross(c - a).length();
    height_times_base <= f64::from(f32::EPSILON) * largest * longest.sqrt()
}

/// Whether a triangle of a file is dropped, for it is degenerate; counts why.
pub(crate) fn is_dropped(positions: &[Vec3], triangle: [u32; 3], file: &Path, warnings: &mut Warnings) -> bool {
    if !is_degenerate(positions, triangle) {
        return false;
    }
    if is_rounded_away(positions, triangle) {
        warnings.add("rounded away", || {
            format!(
                "{}: triangles that single precision cannot tell from lines, so small and so far from the origin, were dropped: move the \
                 model there",
                file.display()
            )
        });
    } else {
        warnings.add("degenerate", || format!("{}: triangles without area were dropped", file.display()));
    }
    true
}

/// Whether a triangle that is degenerate may be so by rounding alone: its edges are a few roundings of its largest coordinate long. Three corners
/// that are one say nothing.
pub(crate) fn is_rounded_away(positions: &[Vec3], triangle: [u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|v| positions[v as usize]);
    let longest = (b - a).abs().max((c - b).abs()).max((a - c).abs()).max_element();
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    longest > 0.0 && longest <= 64.0 * f32::EPSILON * largest
}

/// Per triangle the normal at each corner. Vertices at the same place in the same group are joined,
/// whatever their indices; no triangle may be degenerate.
pub(crate) fn corner_normals(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    groups: &[u32],
    crease_cos: f64,
) -> Vec<[Vec3; 3]> {
    let faces: Vec<DVec3> = triangles.iter().map(|t| area_vector(positions, *t).normalize_or(DVec3::Y)).collect();
    let mut meeting: BTreeMap<GroupedPosition, Vec<Corner>> = BTreeMap::new();
    for (face, triangle) in triangles.iter().enumerate() {
        for (corner, vertex) in triangle.iter().enumerate() {
            // Adding zero makes -0 and 0 the same position.
            let position = (positions[*vertex as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
            meeting.entry((groups[face], position)).or_default().push((face, corner));
        }
    }
    let mut normals: Vec<[Vec3; 3]> = faces.iter().map(|n| [n.as_vec3(); 3]).collect();
    for corners in meeting.values().filter(|c| c.len() <= MAX_CORNERS) {
        let angles: Vec<f64> =
            corners.iter().map(|&(face, corner)| corner_angle(positions, triangles[face], corner)).collect();
        for &(face, corner) in corners {
            let sum = corners
                .iter()
                .zip(&angles)
                .filter(|((other, _), _)| faces[face].dot(faces[*other]) >= crease_cos)
                .fold(DVec3::ZERO, |sum, ((other, _), angle)| sum + faces[*other] * *angle);
            normals[face][corner] = sum.normalize_or(faces[face]).as_vec3();
        }
    }
    normals
}

/// The angle of a triangle at one corner.
fn corner_angle(positions: &[Vec3], triangle: [u32; 3], corner: usize) -> f64 {
    let at = |k: usize| positions[triangle[(corner + k) % 3] as usize].as_dvec3();
    let (a, b) = ((at(1) - at(0)).normalize_or_zero(), (at(2) - at(0)).normalize_or_zero());
    libm::acos(a.dot(b).clamp(-1.0, 1.0))
}

/// Unit vector of `v`, computed in `f64`; `fallback` where it has none.
pub(crate) fn unit(v: Vec3, fallback: Vec3) -> Vec3 {
    let v = v.as_dvec3();
    if v.length_squared() > 1e-60 && v.is_finite() { v.normalize().as_vec3() } else { fallback }
}
