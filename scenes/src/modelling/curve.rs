//! Curves through points: heights and widths along a body.

/// The value at `x` of the smooth curve through `knots` (rising `x`, value); constant beyond its
/// ends.
///
/// Cubic Hermite pieces with the slope of the parabola through three knots, so that unevenly
/// spaced knots give no bumps that a reflection would show.
#[must_use]
pub fn curve(knots: &[(f64, f64)], x: f64) -> f64 {
    let Some((first, last)) = knots.first().zip(knots.last()) else {
        return 0.0;
    };
    if x <= first.0 || x >= last.0 {
        return if x <= first.0 { first.1 } else { last.1 };
    }
    let i = knots.iter().rposition(|k| k.0 <= x).unwrap_or(0).min(knots.len() - 2);
    let (a, b) = (knots[i], knots[i + 1]);
    let span = b.0 - a.0;
    let (t, m0, m1) = ((x - a.0) / span, slope(knots, i) * span, slope(knots, i + 1) * span);
    let (t2, t3) = (t * t, t * t * t);
    a.1 * (2.0 * t3 - 3.0 * t2 + 1.0) + m0 * (t3 - 2.0 * t2 + t) + b.1 * (3.0 * t2 - 2.0 * t3) + m1 * (t3 - t2)
}

/// The slope at a knot: of the parabola through its neighbours, or of the only piece at an end.
fn slope(knots: &[(f64, f64)], i: usize) -> f64 {
    let piece = |i: usize| (knots[i + 1].1 - knots[i].1) / (knots[i + 1].0 - knots[i].0);
    if i == 0 {
        return piece(0);
    }
    if i + 1 == knots.len() {
        return piece(i - 1);
    }
    let (before, after) = (knots[i].0 - knots[i - 1].0, knots[i + 1].0 - knots[i].0);
    (piece(i - 1) * after + piece(i) * before) / (before + after)
}

/// From `a` to `b` at `t`.
#[must_use]
pub fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// A bump of height 1 about `middle` that falls off like a bell of half-width `width`.
#[must_use]
pub fn bell(x: f64, middle: f64, width: f64) -> f64 {
    let t = (x - middle) / width;
    libm::exp(-t * t)
}

/// Where the rising function `f` reaches `wanted` between `low` and `high`, by bisection down to what
/// single precision can tell.
pub fn reach(mut low: f64, mut high: f64, wanted: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..27 {
        let middle = (low + high) / 2.0;
        if f(middle) < wanted { low = middle } else { high = middle }
    }
    (low + high) / 2.0
}
