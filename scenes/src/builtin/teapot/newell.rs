//! Martin Newell's teapot (1975): 32 bicubic Bezier patches, public domain.
//!
//! The data set has 306 control points. Its round parts are circles of control points whose
//! tangents are 0.56 of the radius (0.5625 at the lid's knob), so they stand here as profiles;
//! handle and spout stand as half rows, mirrored in the plane of symmetry. Z is up, as in the
//! original; [`patches`] turns it so that y is.

use glam::DVec3;

use crate::modelling::patch::Patch;

/// A circle of control points: radius, height.
type Ring = (f64, f64);
/// Half a row of a handle or spout patch, from the plane of symmetry outwards and back to it: x, y, z.
type Row = [[f64; 3]; 4];

/// Round parts from the top down, outside to the left of the way down: lid, rim, body. The bottom
/// follows on.
const ROUND: [[Ring; 4]; 6] = [
    [(0.0, 3.15), (0.8, 3.15), (0.0, 2.85), (0.2, 2.7)],
    [(0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)],
    [(1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4)],
    [(1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9)],
    [(2.0, 0.9), (2.0, 0.45), (1.5, 0.225), (1.5, 0.15)],
    [(1.5, 0.15), (1.5, 0.075), (1.425, 0.0), (0.0, 0.0)],
];

/// The knob's tangent; all other circles have [`TANGENT`].
const KNOB_TANGENT: f64 = 0.5625;
const TANGENT: f64 = 0.56;

/// Handle, from where it leaves the body at the top.
const HANDLE: [Row; 7] = [
    [[-1.6, 0.0, 2.025], [-1.6, -0.3, 2.025], [-1.5, -0.3, 2.25], [-1.5, 0.0, 2.25]],
    [[-2.3, 0.0, 2.025], [-2.3, -0.3, 2.025], [-2.5, -0.3, 2.25], [-2.5, 0.0, 2.25]],
    [[-2.7, 0.0, 2.025], [-2.7, -0.3, 2.025], [-3.0, -0.3, 2.25], [-3.0, 0.0, 2.25]],
    [[-2.7, 0.0, 1.8], [-2.7, -0.3, 1.8], [-3.0, -0.3, 1.8], [-3.0, 0.0, 1.8]],
    [[-2.7, 0.0, 1.575], [-2.7, -0.3, 1.575], [-3.0, -0.3, 1.35], [-3.0, 0.0, 1.35]],
    [[-2.5, 0.0, 1.125], [-2.5, -0.3, 1.125], [-2.65, -0.3, 0.9375], [-2.65, 0.0, 0.9375]],
    [[-2.0, 0.0, 0.9], [-2.0, -0.3, 0.9], [-1.9, -0.3, 0.6], [-1.9, 0.0, 0.6]],
];

/// Spout, from the body to the mouth and a little way in.
const SPOUT: [Row; 7] = [
    [[1.7, 0.0, 1.425], [1.7, -0.66, 1.425], [1.7, -0.66, 0.6], [1.7, 0.0, 0.6]],
    [[2.6, 0.0, 1.425], [2.6, -0.66, 1.425], [3.1, -0.66, 0.825], [3.1, 0.0, 0.825]],
    [[2.3, 0.0, 2.1], [2.3, -0.25, 2.1], [2.4, -0.25, 2.025], [2.4, 0.0, 2.025]],
    [[2.7, 0.0, 2.4], [2.7, -0.25, 2.4], [3.3, -0.25, 2.4], [3.3, 0.0, 2.4]],
    [[2.8, 0.0, 2.475], [2.8, -0.25, 2.475], [3.525, -0.25, 2.49375], [3.525, 0.0, 2.49375]],
    [[2.9, 0.0, 2.475], [2.9, -0.15, 2.475], [3.45, -0.15, 2.5125], [3.45, 0.0, 2.5125]],
    [[2.8, 0.0, 2.4], [2.8, -0.15, 2.4], [3.2, -0.15, 2.4], [3.2, 0.0, 2.4]],
];

/// The patches of the body with lid, rim and bottom (24), of the handle (4) and of the spout (4).
/// `u` x `v` points out of the pot.
pub fn patches() -> [Vec<Patch>; 3] {
    let round = ROUND.iter().flat_map(|rings| (0..4).map(|quarter| quarter_patch(rings, quarter))).collect();
    [round, halves(&HANDLE), halves(&SPOUT)]
}

/// The original has z up; here y is up and the spout still points along x.
fn upright([x, y, z]: [f64; 3]) -> DVec3 {
    DVec3::new(x, z, -y)
}

/// One quarter of a round part. Angles run so that the outside is the front while heights go down.
fn quarter_patch(rings: &[Ring; 4], quarter: usize) -> Patch {
    rings.map(|(r, z)| {
        let t = r * if r == 0.8 { KNOB_TANGENT } else { TANGENT };
        let [a, b, c, d] = [[r, 0.0], [r, t], [t, r], [0.0, r]].map(|mut p| {
            for _ in 0..quarter {
                // A quarter turn without rounding, so that neighbours meet exactly.
                p = [-p[1], p[0]];
            }
            upright([p[0], p[1], z])
        });
        [d, c, b, a]
    })
}

/// Both halves of a handle or spout: two patches along it, and the same mirrored.
fn halves(rows: &[Row; 7]) -> Vec<Patch> {
    let mut patches = Vec::new();
    for start in [0, 3] {
        let half = |side: f64| -> Patch {
            std::array::from_fn(|i| rows[start + i].map(|[x, y, z]| upright([x, y * side, z])))
        };
        for side in [1.0, -1.0] {
            let patch = half(side);
            // Mirroring turns the front to the back: read the rows the other way round.
            patches.push(if side < 0.0 { patch.map(|[a, b, c, d]| [d, c, b, a]) } else { patch });
        }
    }
    patches
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn there_are_32_patches_and_the_control_points_of_the_data_set() {
        let all: Vec<Patch> = patches().into_iter().flatten().collect();
        assert_eq!(all.len(), 32);
        let points: BTreeSet<[i64; 3]> =
            all.iter().flatten().flatten().map(|p| (*p * 1e6).to_array().map(|c| c.round() as i64)).collect();
        // The published list has 306 entries; it writes shared poles and seams of the bottom
        // several times.
        assert!((280..=306).contains(&points.len()), "{} distinct control points", points.len());
        for expected in [[0.8, 3.15, 0.45], [-1.425, 0.0, 0.798], [3.525, 2.49375, 0.25], [-3.0, 1.8, -0.3]] {
            assert!(
                points.contains(&DVec3::from(expected).to_array().map(|c| (c * 1e6).round() as i64)),
                "{expected:?}"
            );
        }
    }
}
