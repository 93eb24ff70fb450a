//! The upper part of `car`: roof, pillars, windows with a thickness, and their frames.

use glam::{DVec2, DVec3};

use crate::{
    builtin::car_body as body,
    modelling::{
        Part,
        curve::{lerp, reach},
        part::sin_cos,
        slab, sweep,
    },
};

/// Plan of the cabin at the belt and at the roof: rear, front, half the width.
const BELT: [f64; 3] = [-1.58, 0.80, 0.665];
const EAVES: [f64; 3] = [-0.74, 0.13, 0.525];
/// Exponent of the plan's rounded rectangle.
const SQUARE: f64 = 3.1;
/// Where the side turns into the roof.
const TURN: f64 = 0.9;
/// Windows reach from here to [`TURN`].
const WINDOW_LOW: f64 = 0.115;
const WINDOW_HIGH: f64 = 0.865;
/// Pillars and windows round half the car, from the middle of the windscreen to the middle of the rear
/// window, as shares of the belt's length; windows stand at even places.
const SPLITS: [f64; 8] = [0.0, 0.218, 0.262, 0.575, 0.592, 0.715, 0.775, 1.0];
/// Columns of each of them.
const COLUMNS: [usize; 7] = [10, 3, 12, 1, 6, 3, 10];
/// Rows of a window, round the turn, and over the roof.
const ROWS: [usize; 3] = [7, 5, 7];
/// Thickness of the glass, and how far it stands back.
const GLASS: f64 = 0.006;
const SET_BACK: f64 = 0.005;

/// The plan at height share `h` and angle `t` from the front.
fn plan(t: f64, h: f64) -> DVec2 {
    let bulge = libm::sin(std::f64::consts::PI * h.min(1.0));
    let [rear, front, half]: [f64; 3] = std::array::from_fn(|i| lerp(BELT[i], EAVES[i], h));
    let (rear, front, half) = (rear - 0.035 * bulge, front + 0.03 * bulge, half + 0.022 * bulge);
    let (sin, cos) = sin_cos(t);
    let power = |v: f64| if v.abs() < 1e-12 { 0.0 } else { libm::copysign(libm::pow(v.abs(), 2.0 / SQUARE), v) };
    DVec2::new((front + rear) / 2.0 + (front - rear) / 2.0 * power(cos), half * power(sin))
}

/// Height of the eaves; the roof is highest over the driver.
fn eaves(x: f64) -> f64 {
    let d = (x + 0.12) / 0.6;
    1.225 - 0.075 * d * d
}

/// The shell at angle `t`: `r` runs from the belt (0) over the turn to the middle of the roof (2).
fn shell(t: f64, r: f64) -> DVec3 {
    let side = |h: f64| {
        let (p, low) = (plan(t, h), plan(t, 0.0));
        let base = body::top(low.x, low.y) - 0.02;
        DVec3::new(p.x, lerp(base, eaves(plan(t, 1.0).x), h), p.y)
    };
    let roof = |k: f64| {
        let (p, middle) = (plan(t, 1.0), (EAVES[0] + EAVES[1]) / 2.0);
        let x = lerp(middle, p.x, k);
        DVec3::new(x, eaves(x) + 0.055 * (1.0 - k * k), p.y * k)
    };
    let (start, end) = (TURN, 0.72);
    if r <= start {
        side(r)
    } else if r >= 2.0 - end {
        roof(2.0 - r)
    } else {
        // A curve from the side to the roof that leaves both in their own direction.
        let u = (r - start) / (2.0 - end - start);
        side(start) * ((1.0 - u) * (1.0 - u)) + side(1.0) * (2.0 * u * (1.0 - u)) + roof(end) * (u * u)
    }
}

/// A point `depth` inside the shell.
fn inside(t: f64, r: f64, depth: f64) -> DVec3 {
    let step = 1e-4;
    // At the middle of front and rear the plan is mirrored, so a step across it is fine.
    let around = shell(t + step, r) - shell(t - step, r);
    let up = shell(t, r + step) - shell(t, r - step);
    shell(t, r) + around.cross(up).normalize_or_zero() * depth
}

/// Angles of the columns of section `i`.
fn angles(i: usize) -> Vec<f64> {
    let (a, b) = (angle_at(SPLITS[i]), angle_at(SPLITS[i + 1]));
    let (pa, pb) = (SPLITS[i], SPLITS[i + 1]);
    let count = COLUMNS[i];
    (0..=count)
        .map(|k| {
            if k == 0 {
                a
            } else if k == count {
                b
            } else {
                angle_at(lerp(pa, pb, k as f64 / count as f64))
            }
        })
        .collect()
}

/// The angle at a share of the belt's half circumference, 0 in front.
fn angle_at(share: f64) -> f64 {
    const PIECES: usize = 720;
    let pi = std::f64::consts::PI;
    let points: Vec<DVec2> = (0..=PIECES).map(|i| plan(pi * i as f64 / PIECES as f64, 0.0)).collect();
    let mut lengths = vec![0.0];
    for pair in points.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + (pair[1] - pair[0]).length());
    }
    if share <= 0.0 || share >= 1.0 {
        return if share <= 0.0 { 0.0 } else { pi };
    }
    let wanted = share * lengths[PIECES];
    let i = lengths.partition_point(|l| *l < wanted).clamp(1, PIECES);
    let t = (wanted - lengths[i - 1]) / (lengths[i] - lengths[i - 1]);
    pi * (i as f64 - 1.0 + t) / PIECES as f64
}

/// Half the width of the opening in the body at `x`, a hand inside the belt.
pub fn opening(x: f64) -> f64 {
    let (rear, front) = (BELT[0] + 0.05, BELT[1] - 0.05);
    if x <= rear || x >= front {
        return 0.0;
    }
    let pi = std::f64::consts::PI;
    let t = reach(0.0, pi, -x, |t| -(plan(t, 0.0).x - (front + rear) / 2.0) * 0.958 - (front + rear) / 2.0);
    (plan(t, 0.0).y - 0.03).max(0.01)
}

/// The right half of the shell's cells: pillars, frames and roof, `depth` under the surface.
fn frame(depth: f64) -> Part {
    let mut columns: Vec<f64> = Vec::new();
    let mut glazed = Vec::new();
    for i in 0..COLUMNS.len() {
        columns.extend(angles(i).into_iter().skip(usize::from(i > 0)));
        glazed.extend(std::iter::repeat_n(i % 2 == 0, COLUMNS[i]));
    }
    let heights = heights();
    let keep = |row: usize, column: usize| !(glazed[column] && (2..2 + ROWS[0]).contains(&row));
    let point = |row: usize, column: usize| {
        let (t, r) = (columns[column], heights[row]);
        let mut p = if depth == 0.0 { shell(t, r) } else { inside(t, r, depth) };
        if column == 0 || column + 1 == columns.len() {
            p.z = 0.0;
        }
        p
    };
    // Columns run from front to rear, that is from right to left for someone who looks at the right side.
    slab::sheet(heights.len(), columns.len(), keep, point).flipped()
}

/// Parameters of the rows.
fn heights() -> Vec<f64> {
    let mut heights = vec![0.0, WINDOW_LOW / 2.0];
    heights.extend((0..=ROWS[0]).map(|i| lerp(WINDOW_LOW, WINDOW_HIGH, i as f64 / ROWS[0] as f64)));
    heights.push(TURN);
    heights.extend((1..=ROWS[1]).map(|i| lerp(TURN, 1.28, i as f64 / ROWS[1] as f64)));
    heights.extend((1..=ROWS[2]).map(|i| lerp(1.28, 2.0, i as f64 / ROWS[2] as f64)));
    heights
}

fn both(right: Part) -> Part {
    right.clone().mirrored_z().with(right)
}

/// Roof and pillars.
pub fn outside() -> Part {
    both(frame(0.0))
}

/// The lining of roof and pillars.
pub fn lining() -> Part {
    both(frame(0.022)).flipped()
}

/// Windscreen, two windows a side, rear window: names and closed panes.
pub fn windows() -> Vec<(&'static str, Part)> {
    let across = |i: usize| {
        let right = angles(i);
        let mut all: Vec<f64> = right.iter().rev().map(|t| -t).collect();
        all.extend(right.iter().skip(1));
        if i == 6 {
            // Round the rear: from the right over the middle to the left.
            all = right.clone();
            all.extend(right.iter().rev().skip(1).map(|t| 2.0 * std::f64::consts::PI - t));
        }
        all
    };
    let margin = 0.012;
    let make = |columns: Vec<f64>| {
        let rows = ROWS[0] + 1;
        let (low, high) = (WINDOW_LOW - margin, WINDOW_HIGH + margin);
        let at = |row: usize, column: usize, depth: f64| {
            let r = lerp(low, high, row as f64 / ROWS[0] as f64);
            // Rows run up; columns must run right for someone outside.
            let t = columns[columns.len() - 1 - column];
            inside(t, r, depth)
        };
        slab::pane(rows, columns.len(), |r, c| at(r, c, SET_BACK), |r, c| at(r, c, SET_BACK + GLASS))
    };
    let widened = |mut columns: Vec<f64>| {
        let last = columns.len() - 1;
        columns[0] -= 0.006;
        columns[last] += 0.006;
        columns
    };
    let (door, quarter) = (make(widened(angles(2))), make(widened(angles(4))));
    vec![
        ("windscreen", make(widened(across(0)))),
        ("right door window", door.clone()),
        ("left door window", door.mirrored_z()),
        ("right rear side window", quarter.clone()),
        ("left rear side window", quarter.mirrored_z()),
        ("rear window", make(widened(across(6)))),
    ]
}

/// Chrome strips round the windows of the right side, and round windscreen and rear window.
pub fn trim() -> Part {
    let radii = DVec2::new(0.0075, 0.006);
    let round = |columns: &[f64]| {
        let rows: Vec<f64> = (0..=ROWS[0]).map(|i| lerp(WINDOW_LOW, WINDOW_HIGH, i as f64 / ROWS[0] as f64)).collect();
        let (first, last) = (columns[0], columns[columns.len() - 1]);
        let mut path: Vec<DVec3> = columns.iter().map(|t| inside(*t, WINDOW_LOW, 0.002)).collect();
        path.extend(rows.iter().skip(1).map(|r| inside(last, *r, 0.002)));
        path.extend(columns.iter().rev().skip(1).map(|t| inside(*t, WINDOW_HIGH, 0.002)));
        path.extend(rows.iter().rev().skip(1).take(ROWS[0] - 1).map(|r| inside(first, *r, 0.002)));
        path
    };
    let middle =
        |columns: &[f64]| inside(columns[columns.len() / 2], 0.5, 1.0) - inside(columns[columns.len() / 2], 0.5, 0.0);
    let strip = |columns: Vec<f64>| {
        let up = middle(&columns);
        sweep::ring(&round(&columns), up, radii, 5)
    };
    let front: Vec<f64> = {
        let a = angles(0);
        a.iter().rev().map(|t| -t).chain(a.iter().skip(1).copied()).collect()
    };
    let rear: Vec<f64> = {
        let a = angles(6);
        a.iter().copied().chain(a.iter().rev().skip(1).map(|t| 2.0 * std::f64::consts::PI - t)).collect()
    };
    both(strip(angles(2)).with(strip(angles(4)))).with(strip(front)).with(strip(rear))
}

/// The ring of the cabin at the belt, shrunk by `inset` and lowered by `drop`, from the front over the right
/// round to the front again.
pub fn belt(points: usize, inset: f64, drop: f64) -> Vec<DVec3> {
    (0..points)
        .map(|i| {
            let share = 2.0 * i as f64 / points as f64;
            let (t, side) = if share <= 1.0 { (angle_at(share), 1.0) } else { (angle_at(2.0 - share), -1.0) };
            let p = plan(t, 0.0);
            let middle = (BELT[0] + BELT[1]) / 2.0;
            let half = (BELT[1] - BELT[0]) / 2.0;
            let scale = DVec2::new(1.0 - inset / half, 1.0 - inset / BELT[2]);
            let (x, z) = (middle + (p.x - middle) * scale.x, p.y * scale.y);
            DVec3::new(x, body::top(p.x, p.y) - drop, z * side)
        })
        .collect()
}
