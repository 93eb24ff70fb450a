//! Objects whose corners run the wrong way round.
//!
//! Mirrored exports turn the order of the corners and not the normals. A triangle's front is where its corners run counter-clockwise, so
//! such an object shows its back: its normals would point away from every ray that sees it, and glass would begin where it ends.

use std::path::Path;

use super::{text::ABSENT_NORMAL, triangles::RawMesh};
use crate::{mesh::normals::area_vector, warnings::Warnings};

/// Triangles of one object that have normals, and those of them that turn their backs to all three.
#[derive(Clone, Copy, Default)]
struct Sides {
    known: u32,
    backs: u32,
}

/// Turns the triangles that turn their backs to their normals, and those without, in objects of which more than half of those with normals
/// do. Single ones are left as they are: a normal of a thin triangle may point anywhere.
pub(super) fn turn(mesh: &mut RawMesh, (path, objects): (&Path, &[String]), warnings: &mut Warnings) {
    let backs: Vec<Option<bool>> = mesh.triangles.iter().map(|t| is_back(mesh, t.vertices)).collect();
    let mut sides = vec![Sides::default(); objects.len()];
    for (triangle, back) in mesh.triangles.iter().zip(&backs) {
        let of = &mut sides[triangle.object as usize];
        of.known += u32::from(back.is_some());
        of.backs += u32::from(*back == Some(true));
    }
    let is_turned = |object: u32| sides[object as usize].backs * 2 > sides[object as usize].known;
    for (triangle, back) in mesh.triangles.iter_mut().zip(backs) {
        if back != Some(false) && is_turned(triangle.object) {
            triangle.vertices.swap(1, 2);
        }
    }
    for (name, sides) in objects.iter().zip(&sides).filter(|(_, sides)| sides.backs * 2 > sides.known) {
        warnings.add("winding", || {
            format!(
                "{}: object `{name}`: the corners of {} of its {} triangles with normals run clockwise for who looks against their normals, and were \
                 turned round",
                path.display(),
                sides.backs,
                sides.known
            )
        });
    }
}

/// Whether a triangle turns its back to the normals of the file at its corners; none where it has not got all three.
fn is_back(mesh: &RawMesh, corners: [u32; 3]) -> Option<bool> {
    let normals = corners.map(|v| mesh.normals[v as usize]);
    let given = normals.iter().all(|n| n.to_array() != ABSENT_NORMAL && n.is_finite());
    let face = area_vector(&mesh.positions, corners);
    given.then(|| normals.iter().all(|n| n.as_dvec3().dot(face) < 0.0))
}
