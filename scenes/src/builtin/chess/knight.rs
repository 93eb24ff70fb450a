//! The knight: a horse's head on a turned foot, lofted as one closed skin, with ears and eyes.

use glam::{DVec2, DVec3};

use crate::{
    builtin::chess::foot::foot,
    modelling::{
        Part,
        lathe::{lathe, sphere},
        loft::{self, Section},
        profile::{c, s, sample},
    },
};

/// Points round the skin.
const SEGMENTS: usize = 22;

/// The solids of the knight, looking along x.
pub fn parts() -> Vec<Part> {
    let mut knots = foot(0.345, 0.30);
    knots.truncate(8);
    knots.extend([s(0.24, 0.25), s(0.25, 0.275), s(0.22, 0.30), c(0.0, 0.30)]);
    let base = lathe(&sample(&knots, 0.12), 24);
    let mut parts = vec![base, skin()];
    for side in [1.0, -1.0] {
        parts.push(ear(side));
        parts.push(sphere(DVec3::new(0.135, 0.985, 0.083 * side), 0.026, 10));
    }
    parts
}

const fn section(back: (f64, f64), front: (f64, f64), half_width: f64, crest: f64) -> Section {
    Section { back: DVec2::new(back.0, back.1), front: DVec2::new(front.0, front.1), half_width, crest }
}

/// Cross-sections from the chest up the neck, over the poll and down to the lips. Back runs along
/// the mane, the forehead and the nose; front along the chest, the throat, the cheek and the chin.
const SECTIONS: [Section; 17] = [
    section((-0.215, 0.285), (0.215, 0.285), 0.205, 0.0),
    section((-0.235, 0.36), (0.225, 0.36), 0.185, 0.15),
    section((-0.262, 0.47), (0.205, 0.45), 0.160, 0.35),
    section((-0.275, 0.60), (0.150, 0.535), 0.138, 0.55),
    section((-0.262, 0.74), (0.085, 0.605), 0.122, 0.65),
    section((-0.222, 0.87), (0.045, 0.665), 0.114, 0.65),
    section((-0.155, 0.985), (0.035, 0.715), 0.112, 0.60),
    section((-0.065, 1.065), (0.060, 0.735), 0.118, 0.45),
    section((0.025, 1.095), (0.105, 0.715), 0.122, 0.25),
    section((0.105, 1.075), (0.150, 0.705), 0.112, 0.10),
    section((0.175, 1.020), (0.200, 0.712), 0.094, 0.05),
    section((0.240, 0.950), (0.250, 0.715), 0.078, 0.0),
    section((0.300, 0.880), (0.293, 0.700), 0.068, 0.0),
    section((0.352, 0.822), (0.325, 0.668), 0.070, 0.0),
    section((0.400, 0.775), (0.345, 0.640), 0.070, 0.0),
    section((0.432, 0.728), (0.368, 0.632), 0.056, 0.0),
    section((0.438, 0.690), (0.400, 0.640), 0.034, 0.0),
];

fn skin() -> Part {
    let sections = loft::refine(&SECTIONS, 2);
    let count = sections.len();
    loft::loft(&sections, SEGMENTS, |row, angle, mut p| {
        let along = row as f64 / (count - 1) as f64;
        let behind = -libm::cos(angle);
        // Mane: locks along the crest of the neck, every other ring stands out.
        if behind > 0.85 && (0.10..0.46).contains(&along) {
            let out = (sections[row].back - sections[row].front).normalize_or_zero();
            let lock = if row % 2 == 0 { 0.026 } else { -0.012 };
            p += (out * lock).extend(0.0);
        }
        // Mouth: a groove along the side of the muzzle, nearer the chin.
        let mouth = (0.80..0.98).contains(&along) && (libm::cos(angle) - 0.25).abs() < 0.14;
        if mouth {
            p.z *= 0.72;
        }
        p
    })
    .crease(48.0)
}

/// A pointed ear, hollowed in front, leaning back and out.
fn ear(side: f64) -> Part {
    let knots = [c(0.0, 0.0), s(0.034, 0.012), s(0.042, 0.05), s(0.028, 0.11), c(0.0, 0.165)];
    lathe(&sample(&knots, 0.06), 10).map(|p| {
        let lean = DVec3::new(p.x * 0.8 - p.y * 0.10, p.y, p.z + side * p.y * 0.22);
        lean + DVec3::new(0.0, 1.055, 0.052 * side)
    })
}
