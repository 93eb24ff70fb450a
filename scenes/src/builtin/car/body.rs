//! The skin of `car` below the windows: one closed form, cut at sill, wheel arches and cabin.
//!
//! Metres; x runs forward, y up, z to the right; the ground is y = 0.

use glam::{DVec2, DVec3};

use crate::modelling::{
    Part,
    curve::{bell, curve, lerp, reach},
    part::sin_cos,
    slab,
};

/// Foremost point.
pub const NOSE: f64 = 2.12;
/// Rearmost point.
pub const TAIL: f64 = -2.12;
/// Where the axles are, rear first.
pub const AXLES: [f64; 2] = [-1.2, 1.3];
/// Height of the axles.
pub const AXLE_HEIGHT: f64 = 0.315;
/// Radius of the wheel arches.
pub const ARCH: f64 = 0.365;
/// Height of the sills.
pub const SILL: f64 = 0.19;
/// Columns over a wheel arch.
const ARCH_COLUMNS: usize = 16;
/// Rows from the sill to the axle, from there to the fold, and from the fold to the middle.
const ROWS: [usize; 3] = [3, 6, 15];
/// Where the rows above the arches begin, as the parameter `s` of [`point`].
const FOLD: f64 = 0.56;

/// The opening in the body under the cabin: half its width at `x`, 0 in front of it and behind. The plan of the cabin
/// says it.
pub type CabinOpening<'a> = &'a dyn Fn(f64) -> f64;

/// How far the ends are rounded off: 1 in the middle, 0 at the tips. `from` is where the rounding
/// starts, `power` how square it is.
fn end(x: f64, from: [f64; 2], power: f64) -> f64 {
    let q = if x > from[1] {
        (x - from[1]) / (NOSE - from[1])
    } else if x < from[0] {
        (x - from[0]) / (TAIL - from[0])
    } else {
        return 1.0;
    };
    libm::pow((1.0 - libm::pow(q.min(1.0), power)).max(0.0), 1.0 / power)
}

/// The cross-section at one `x`.
struct BodySection {
    half: f64,
    bottom: f64,
    waist: f64,
    top: f64,
    /// Exponent of the upper part: 2 an ellipse, more is squarer.
    square: f64,
    /// Height of the fenders over the bonnet.
    fender: f64,
    /// Height at which nose and tail come to their tip.
    tip: f64,
    /// How far the section has shrunk towards the tip: 1 not at all, 0 at nose and tail.
    closing: f64,
    /// The same for the part below the tip, which shrinks less.
    chin: f64,
}

fn section(x: f64) -> BodySection {
    let top = [
        (TAIL, 0.66),
        (-1.85, 0.755),
        (-1.5, 0.825),
        (-1.0, 0.875),
        (-0.3, 0.885),
        (0.5, 0.865),
        (0.95, 0.825),
        (1.4, 0.745),
        (1.8, 0.655),
        (NOSE, 0.57),
    ];
    let half = [(TAIL, 0.77), (-1.2, 0.835), (-0.4, 0.80), (0.4, 0.80), (1.3, 0.83), (NOSE, 0.74)];
    BodySection {
        half: curve(&half, x) * end(x, [-1.45, 1.4], 2.9),
        bottom: SILL - 0.02,
        waist: curve(&[(TAIL, 0.56), (0.0, 0.545), (NOSE, 0.50)], x),
        top: curve(&top, x),
        square: 2.6,
        fender: 0.105 * bell(x, 1.55, 0.52) + 0.045 * bell(x, -1.25, 0.5),
        tip: if x > 0.0 { 0.43 } else { 0.53 },
        closing: end(x, [-1.85, 1.78], 2.3),
        chin: 0.72 + 0.28 * end(x, [-1.5, 1.5], 2.5),
    }
}

/// The point of the skin at `x` and `s`: -1 is the lower edge, 0 the widest place, 1 the middle of the top.
pub fn point(x: f64, s: f64) -> DVec3 {
    let q = section(x);
    let (mut y, mut z) = if s < 0.0 {
        (lerp(q.waist, q.bottom, -s), q.half * (1.0 - 0.075 * s * s))
    } else if s >= 1.0 {
        // Both halves must meet bit by bit.
        (q.top, 0.0)
    } else {
        let (sin, cos) = sin_cos(s * std::f64::consts::FRAC_PI_2);
        let power = 2.0 / q.square;
        (lerp(q.waist, q.top, libm::pow(sin, power)), q.half * libm::pow(cos, power))
    };
    if s > 0.0 && q.half > 0.0 {
        y += q.fender * bell(z / q.half, 0.72, 0.20) * libm::sin(s.min(0.5) * std::f64::consts::PI);
    }
    for axle in AXLES {
        let from_arch = DVec2::new(x - axle, y - AXLE_HEIGHT).length() - ARCH;
        if s < 1.0 && z > 0.0 {
            z += 0.022 * bell(from_arch, 0.0, 0.055);
        }
    }
    // Below the tip the body shrinks less, so that the nose has a chin.
    let closing = if y > q.tip { q.closing } else { q.chin };
    DVec3::new(x, q.tip + (y - q.tip) * closing, z)
}

/// The height of the upper side at a place.
pub fn top(x: f64, z: f64) -> f64 {
    let s = reach(0.0, 1.0, -z.abs(), |s| -point(x, s).z);
    point(x, s).y
}

/// The parameter at which the side of the section at `x` is `y` high.
pub fn at_height(x: f64, y: f64) -> f64 {
    reach(-1.0, 0.95, y, |s| point(x, s).y)
}

/// How far forward (`front`) or back the skin reaches at height `y` and distance `z` from the middle.
pub fn reach_of_end(front: bool, y: f64, z: f64) -> f64 {
    let (inner, outer) = if front { (1.0, NOSE) } else { (-1.0, TAIL) };
    let width = |x: f64| {
        let inside = y <= point(x, 1.0).y.max(point(x, 0.6).y) && y >= point(x, -1.0).y;
        if inside { point(x, at_height(x, y)).z } else { 0.0 }
    };
    inner + (outer - inner) * reach(0.0, 1.0, -z.abs(), |t| -width(inner + (outer - inner) * t))
}

/// The places along the car where the skin has columns.
fn stations() -> Vec<f64> {
    let tip = |from: f64, to: f64, count: usize| {
        (0..=count).map(move |i| {
            let left = 1.0 - i as f64 / count as f64;
            to + (from - to) * libm::pow(left, 2.4)
        })
    };
    let even = |from: f64, to: f64, count: usize| (0..=count).map(move |i| lerp(from, to, i as f64 / count as f64));
    let arch = |axle: f64| {
        (0..=ARCH_COLUMNS).map(move |i| axle - ARCH * libm::cos(std::f64::consts::PI * i as f64 / ARCH_COLUMNS as f64))
    };
    let mut all: Vec<f64> = tip(AXLES[0] - ARCH, TAIL, 15).collect();
    all.reverse();
    all.extend(arch(AXLES[0]).skip(1));
    all.extend(even(AXLES[0] + ARCH, AXLES[1] - ARCH, 24).skip(1));
    all.extend(arch(AXLES[1]).skip(1));
    all.extend(tip(AXLES[1] + ARCH, NOSE, 15).skip(1));
    all
}

/// Whether `x` lies over a wheel, and the arch's height there.
fn arch_height(x: f64) -> Option<f64> {
    let d = AXLES.iter().map(|a| (x - a).abs()).fold(f64::MAX, f64::min);
    // The ends of the arch themselves count as beside it: both sides use the axle's height there.
    (d < ARCH - 1e-9).then(|| AXLE_HEIGHT + (ARCH * ARCH - d * d).max(0.0).sqrt())
}

/// A column of the skin: where it is, and where its rows start above the wheel arch and end at the middle or
/// the cabin.
struct Column {
    x: f64,
    lower: f64,
    end: f64,
}

fn columns(opening: CabinOpening<'_>) -> Vec<Column> {
    let column = |x: f64| {
        let (bottom, waist) = (point(x, -1.0).y, point(x, 0.0).y);
        // Beside the wheels the first rows end at the axle's height, so that they meet the arches.
        let axle = lerp(bottom, waist, 0.35).max(AXLE_HEIGHT.min(waist));
        let lower = at_height(x, arch_height(x).unwrap_or(axle));
        let wide = opening(x);
        let end = if wide > 0.0 { reach(0.0, 1.0, -wide, |s| -point(x, s).z) } else { 1.0 };
        Column { x, lower, end }
    };
    stations().into_iter().map(column).collect()
}

/// The right half of the skin, with the cabin left open.
fn right(opening: CabinOpening<'_>) -> Part {
    let columns = columns(opening);
    let rows = ROWS.iter().sum::<usize>() + 1;
    let surface = |row: usize, column: usize| {
        let Column { x, lower, end } = columns[column];
        let s = if row <= ROWS[0] {
            lerp(-1.0, lower, row as f64 / ROWS[0] as f64)
        } else if row <= ROWS[0] + ROWS[1] {
            lerp(lower, FOLD, (row - ROWS[0]) as f64 / ROWS[1] as f64)
        } else {
            lerp(FOLD, end, (row - ROWS[0] - ROWS[1]) as f64 / ROWS[2] as f64)
        };
        point(x, s)
    };
    let keep = |row: usize, column: usize| {
        row >= ROWS[0] || arch_height((columns[column].x + columns[column + 1].x) / 2.0).is_none()
    };
    slab::sheet(rows, columns.len(), keep, surface)
}

/// The whole skin.
pub fn skin(opening: CabinOpening<'_>) -> Part {
    let right = right(opening);
    right.clone().mirrored_z().with(right)
}

/// The edge of a wheel arch on the right side, from the rear to the front.
fn arch_edge(axle: f64) -> Vec<DVec3> {
    let drop = |x: f64| point(x, -1.0);
    let round = (0..=ARCH_COLUMNS).map(|i| {
        let (sin, cos) = sin_cos(std::f64::consts::PI * i as f64 / ARCH_COLUMNS as f64);
        let x = axle - ARCH * cos;
        point(x, at_height(x, AXLE_HEIGHT + ARCH * sin.max(0.0)))
    });
    std::iter::once(drop(axle - ARCH)).chain(round).chain(std::iter::once(drop(axle + ARCH))).collect()
}

/// The lips of the four wheel arches, folded inwards.
pub fn lips() -> Part {
    let lip = |axle: f64| {
        let edge = arch_edge(axle);
        let part = Part::grid(2, edge.len(), false, |row, column| edge[column] - DVec3::Z * (0.07 * row as f64));
        part.clone().mirrored_z().with(part)
    };
    AXLES.into_iter().map(lip).fold(Part::default(), Part::with)
}

/// The insides of the wheel arches and the floor between them.
pub fn underside() -> Part {
    let well = |axle: f64| {
        let edge = arch_edge(axle);
        let last = edge.len() - 1;
        let inner = 0.42;
        // From the lip inwards, then a wall down to the floor.
        let part = Part::grid(3, edge.len(), false, |row, column| {
            let lip = edge[column] - DVec3::Z * 0.05;
            let bottom = DVec3::new(lip.x, SILL, inner);
            let up = if column == 0 || column == last { 0.0 } else { 0.02 };
            [lip, DVec3::new(lip.x, lip.y + up, inner), bottom][row]
        });
        part.clone().mirrored_z().with(part)
    };
    let stations = stations();
    let floor = Part::grid(2, stations.len(), false, |row, column| {
        let x = stations[column];
        let edge = if arch_height(x).is_some() { 0.42 } else { point(x, -1.0).z };
        DVec3::new(x, point(x, -1.0).y, if row == 0 { -edge } else { edge })
    });
    AXLES.into_iter().map(well).fold(floor, Part::with)
}
