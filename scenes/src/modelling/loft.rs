//! Skins over a row of cross-sections, for shapes that no lathe can turn.

use glam::{DVec2, DVec3};

use crate::modelling::part::{Part, sin_cos};

/// A cross-section across the plane z = 0: it spans from `back` to `front` in that plane and
/// `half_width` to either side of it.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Rear end in x and y.
    pub back: DVec2,
    /// Front end in x and y.
    pub front: DVec2,
    /// Half the width in z.
    pub half_width: f64,
    /// 0 = ellipse; up to 1 the rear narrows to a crest.
    pub crest: f64,
}

impl Section {
    fn mix(points: [&Self; 4], t: f64) -> Self {
        let [a, b, c, d] = points;
        let (t2, t3) = (t * t, t * t * t);
        let (wa, wb) = (-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1.0);
        let (wc, wd) = (-1.5 * t3 + 2.0 * t2 + 0.5 * t, 0.5 * t3 - 0.5 * t2);
        let number = |get: fn(&Self) -> f64| get(a) * wa + get(b) * wb + get(c) * wc + get(d) * wd;
        Self {
            back: a.back * wa + b.back * wb + c.back * wc + d.back * wd,
            front: a.front * wa + b.front * wb + c.front * wc + d.front * wd,
            half_width: number(|s| s.half_width).max(0.0),
            crest: number(|s| s.crest).clamp(0.0, 1.0),
        }
    }

    /// The point at an angle: 0 is the front, half a turn the back.
    #[must_use]
    pub fn point(&self, angle: f64) -> DVec3 {
        let (sin, cos) = sin_cos(angle);
        let along = self.back + (self.front - self.back) * ((1.0 + cos) / 2.0);
        let narrow = 1.0 - self.crest * 0.6 * ((1.0 - cos) / 2.0) * ((1.0 - cos) / 2.0);
        DVec3::new(along.x, along.y, self.half_width * sin * narrow)
    }
}

/// Sections between the given ones: `pieces` per gap, along smooth curves.
#[must_use]
pub fn refine(sections: &[Section], pieces: usize) -> Vec<Section> {
    let mut out = Vec::new();
    for i in 1..sections.len() {
        let at = |k: usize| &sections[k.min(sections.len() - 1)];
        let around = [at(i.saturating_sub(2)), at(i - 1), at(i), at(i + 1)];
        out.extend((0..pieces).map(|p| Section::mix(around, p as f64 / pieces as f64)));
    }
    out.extend(sections.last().copied());
    out
}

/// A closed skin over the sections from the bottom up: flat caps at both ends, `shape` moves each
/// point of the skin (section, angle, point).
pub fn loft(sections: &[Section], segments: usize, shape: impl Fn(usize, f64, DVec3) -> DVec3) -> Part {
    let count = sections.len();
    let cap = |s: &Section| ((s.back + s.front) / 2.0).extend(0.0);
    Part::grid(count + 2, segments, true, |row, column| {
        // Columns run clockwise seen from above, so that the front of the grid is the outside, as in `lathe`.
        let angle = -std::f64::consts::TAU * column as f64 / segments as f64;
        match row {
            0 => cap(&sections[0]),
            r if r > count => cap(&sections[count - 1]),
            r => shape(r - 1, angle, sections[r - 1].point(if column == 0 { 0.0 } else { angle })),
        }
    })
}
