//! Profiles of turned pieces: knots joined by smooth curves, sharp where asked.

use glam::DVec2;

/// A point of a profile: radius and height, and whether the curve has a corner there.
#[derive(Clone, Copy, Debug)]
pub struct Knot {
    /// Radius and height.
    pub point: DVec2,
    /// A corner, not a smooth passage.
    pub sharp: bool,
}

/// A smooth knot.
#[must_use]
pub const fn s(r: f64, y: f64) -> Knot {
    Knot { point: DVec2::new(r, y), sharp: false }
}

/// A corner.
#[must_use]
pub const fn c(r: f64, y: f64) -> Knot {
    Knot { point: DVec2::new(r, y), sharp: true }
}

/// Points along the profile, at most `step` apart measured along straight knots. Runs of smooth
/// knots become Catmull-Rom curves; between two corners the line is straight and stays one piece.
#[must_use]
pub fn sample(knots: &[Knot], step: f64) -> Vec<DVec2> {
    let Some(first) = knots.first() else {
        return Vec::new();
    };
    let mut points = vec![first.point];
    for i in 1..knots.len() {
        let (a, b) = (knots[i - 1], knots[i]);
        let straight = a.sharp && b.sharp;
        let pieces = if straight { 1 } else { libm::ceil((b.point - a.point).length() / step).max(1.0) as usize };
        // The neighbour beyond a corner must not bend the curve: the other end, mirrored at the corner, replaces it.
        let before = if a.sharp || i < 2 { a.point * 2.0 - b.point } else { knots[i - 2].point };
        let after = if b.sharp || i + 1 >= knots.len() { b.point * 2.0 - a.point } else { knots[i + 1].point };
        for piece in 1..pieces {
            let p = catmull_rom(before, a.point, b.point, after, piece as f64 / pieces as f64);
            points.push(DVec2::new(p.x.max(0.0), p.y));
        }
        points.push(b.point);
    }
    points
}

/// The Catmull-Rom curve from `b` to `c` at `t`.
fn catmull_rom(a: DVec2, b: DVec2, c: DVec2, d: DVec2, t: f64) -> DVec2 {
    // Limited tangents: between knots of very different spacing the plain ones overshoot.
    let reach = (c - b).length();
    let tangent = |v: DVec2| v.normalize_or_zero() * (v.length() / 2.0).min(reach);
    let (m0, m1) = (tangent(c - a), tangent(d - b));
    let (t2, t3) = (t * t, t * t * t);
    b * (2.0 * t3 - 3.0 * t2 + 1.0) + m0 * (t3 - 2.0 * t2 + t) + c * (3.0 * t2 - 2.0 * t3) + m1 * (t3 - t2)
}
