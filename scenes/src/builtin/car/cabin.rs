//! The upper part of `car`: roof, pillars, windows with a thickness, and their frames.

use glam::{DVec2, DVec3};

use crate::{
    builtin::car::shell::{ROOF, Shell, TURN},
    modelling::{Part, curve::lerp, slab, sweep},
};

/// Windows reach from here to there, as parameters of [`Shell::point`].
const WINDOW: [f64; 2] = [0.115, 0.865];
/// Pillars and windows round half the car, from the middle of the windscreen to the middle of the rear
/// window, as shares of the belt's length; windows stand at even places.
const SPLITS: [f64; 8] = [0.0, 0.218, 0.262, 0.575, 0.592, 0.715, 0.775, 1.0];
/// Columns of each of them.
const COLUMNS: [usize; 7] = [10, 3, 12, 1, 6, 3, 10];
/// Windscreen, door window, rear side window, rear window among them.
const WINDSCREEN: usize = 0;
const DOOR: usize = 2;
const QUARTER: usize = 4;
const REAR: usize = 6;
/// Rows of a window, round the turn, and over the roof.
const ROWS: [usize; 3] = [7, 5, 7];
/// Thickness of the glass in metres, how far it stands back, and how far it reaches under the frame.
const GLASS: f64 = 0.006;
const SET_BACK: f64 = 0.005;
const UNDER_FRAME: f64 = 0.012;

/// The angles of the columns of pillar or window `i` on the right side.
fn angles(shell: &Shell, i: usize) -> Vec<f64> {
    let count = COLUMNS[i];
    (0..=count).map(|k| shell.angle_at(lerp(SPLITS[i], SPLITS[i + 1], k as f64 / count as f64))).collect()
}

/// The angles of a whole window: that in front and that in the rear go round to the left side.
fn window_angles(shell: &Shell, i: usize) -> Vec<f64> {
    let right = angles(shell, i);
    match i {
        WINDSCREEN => right.iter().rev().map(|t| -t).chain(right.iter().skip(1).copied()).collect(),
        REAR => {
            let turn = 2.0 * std::f64::consts::PI;
            right.iter().copied().chain(right.iter().rev().skip(1).map(|t| turn - t)).collect()
        }
        _ => right,
    }
}

/// The heights of the rows of the shell.
fn rows() -> Vec<f64> {
    let even = |from: f64, to: f64, count: usize| (0..=count).map(move |i| lerp(from, to, i as f64 / count as f64));
    let mut rows = vec![0.0, WINDOW[0] / 2.0];
    rows.extend(even(WINDOW[0], WINDOW[1], ROWS[0]));
    rows.extend(even(TURN, ROOF, ROWS[1]));
    rows.extend(even(ROOF, 2.0, ROWS[2]).skip(1));
    rows
}

fn both(right: Part) -> Part {
    right.clone().mirrored_z().with(right)
}

/// The right half of pillars and roof, `depth` under the surface.
fn frame(shell: &Shell, depth: f64) -> Part {
    let mut columns: Vec<f64> = Vec::new();
    let mut glazed = Vec::new();
    for (i, count) in COLUMNS.into_iter().enumerate() {
        columns.extend(angles(shell, i).into_iter().skip(usize::from(i > 0)));
        glazed.extend(std::iter::repeat_n(i % 2 == 0, count));
    }
    let rows = rows();
    let keep = |row: usize, column: usize| !(glazed[column] && (2..2 + ROWS[0]).contains(&row));
    let point = |row: usize, column: usize| {
        let mut p = shell.inside(columns[column], rows[row], depth);
        if column == 0 || column + 1 == columns.len() {
            // Both halves must meet bit by bit.
            p.z = 0.0;
        }
        p
    };
    // Columns run from front to rear: from right to left for someone who looks at the right side.
    slab::sheet(rows.len(), columns.len(), keep, point).flipped()
}

/// Roof and pillars.
pub fn outside(shell: &Shell) -> Part {
    both(frame(shell, 0.0))
}

/// The lining of roof and pillars.
pub fn lining(shell: &Shell) -> Part {
    both(frame(shell, 0.022)).flipped()
}

/// The six windows with their names: closed panes.
pub fn windows(shell: &Shell) -> Vec<(&'static str, Part)> {
    let make = |i: usize| {
        let mut columns = window_angles(shell, i);
        // Rows run up; columns must run right for someone outside.
        columns.reverse();
        let last = columns.len() - 1;
        columns[0] += UNDER_FRAME / 2.0;
        columns[last] -= UNDER_FRAME / 2.0;
        let (low, high) = (WINDOW[0] - UNDER_FRAME, WINDOW[1] + UNDER_FRAME);
        let at = |row: usize, column: usize, depth: f64| {
            shell.inside(columns[column], lerp(low, high, row as f64 / ROWS[0] as f64), depth)
        };
        slab::pane(ROWS[0] + 1, columns.len(), |r, c| at(r, c, SET_BACK), |r, c| at(r, c, SET_BACK + GLASS))
    };
    let (door, quarter) = (make(DOOR), make(QUARTER));
    vec![
        ("windscreen", make(WINDSCREEN)),
        ("left door window", door.clone().mirrored_z()),
        ("right door window", door),
        ("left rear side window", quarter.clone().mirrored_z()),
        ("right rear side window", quarter),
        ("rear window", make(REAR)),
    ]
}

/// Strips round the windows.
pub fn trim(shell: &Shell) -> Part {
    let strip = |i: usize| {
        let columns = window_angles(shell, i);
        let at = |t: f64, r: f64| shell.inside(t, r, 0.002);
        let (first, last) = (columns[0], columns[columns.len() - 1]);
        let rows: Vec<f64> = (1..ROWS[0]).map(|i| lerp(WINDOW[0], WINDOW[1], i as f64 / ROWS[0] as f64)).collect();
        let mut path: Vec<DVec3> = columns.iter().map(|t| at(*t, WINDOW[0])).collect();
        path.extend(rows.iter().map(|r| at(last, *r)));
        path.extend(columns.iter().rev().map(|t| at(*t, WINDOW[1])));
        path.extend(rows.iter().rev().map(|r| at(first, *r)));
        let middle = columns[columns.len() / 2];
        let inwards = shell.inside(middle, 0.5, 1.0) - shell.inside(middle, 0.5, 0.0);
        sweep::ring(&path, inwards, DVec2::new(0.0075, 0.006), 5)
    };
    both(strip(DOOR).with(strip(QUARTER))).with(strip(WINDSCREEN)).with(strip(REAR))
}
