//! The rules that look at colours: Whitted 1980 and Mitchell 1987.

use rayreel_replay::policy::{Mitchell1987, Whitted1980};

use super::making::{Cell, Making};
use crate::rules::{difference, mix};

type Rgb = [f32; 3];

/// Between the corners (own, right, below, across), at a sample of the cell.
fn between(corners: [Rgb; 4], cell: Cell, (x, y): (usize, usize)) -> Rgb {
    let part = |at: usize, a: usize, b: usize| if a == b { 0.0 } else { (at - a) as f32 / (b - a) as f32 };
    let (u, v) = (part(x, cell.xa, cell.xb), part(y, cell.ya, cell.yb));
    mix(mix(corners[0], corners[1], u), mix(corners[2], corners[3], u), v)
}

fn corners(making: &Making<'_>, cell: Cell) -> [Rgb; 4] {
    let Cell { xa, xb, ya, yb } = cell;
    [(xa, ya), (xb, ya), (xa, yb), (xb, yb)].map(|(x, y)| making.colour(x, y))
}

pub fn mitchell(making: &mut Making<'_>, values: &Mitchell1987, cell: Cell) {
    if cell.others().is_empty() {
        return;
    }
    let colours = corners(making, cell);
    making.work(1).tests += 1;
    making.work(1).colours += if cell.is_line() { 1 } else { 3 };
    let mut busy = false;
    for (channel, limit) in [values.red, values.green, values.blue].into_iter().enumerate() {
        let of: Vec<f64> = colours.iter().map(|colour| f64::from(colour[channel])).collect();
        let max = of.iter().copied().reduce(f64::max).unwrap();
        let min = of.iter().copied().reduce(f64::min).unwrap();
        let contrast = if max == 0.0 && min == 0.0 { 0.0 } else { (max - min) / (max + min) };
        busy |= contrast.is_nan() || of.iter().any(|v| v.is_nan()) || contrast > limit;
    }
    for at in cell.others() {
        if busy {
            making.trace(at, 1);
        } else {
            making.interpolate(at, between(colours, cell, at), 1);
        }
    }
}

pub fn whitted(making: &mut Making<'_>, values: &Whitted1980, cell: Cell) {
    let mut squares = vec![(cell, corners(making, cell), 1u8)];
    while let Some((cell, known, depth)) = squares.pop() {
        let Cell { xa, xb, ya, yb } = cell;
        if cell.others().is_empty() {
            continue;
        }
        let least = values.least as usize;
        let (wide, high) = (xb - xa > least, yb - ya > least);
        let mut differ = false;
        if wide || high {
            making.work(depth).tests += 1;
            making.work(depth).colours += if cell.is_line() { 1 } else { 6 };
            for a in 0..4 {
                for b in a + 1..4 {
                    let both = (known[a], known[b]);
                    let found = difference(both, both);
                    differ |= found.is_nan() || found > values.colour;
                }
            }
        }
        if !differ {
            cell.others().into_iter().for_each(|at| making.interpolate(at, between(known, cell, at), depth));
            continue;
        }
        // The columns and rows at which the parts begin and end.
        let xs = if wide { vec![xa, (xa + xb) / 2, xb] } else { vec![xa, xb] };
        let ys = if high { vec![ya, (ya + yb) / 2, yb] } else { vec![ya, yb] };
        // The colours at these places: corners, traced ones, and estimates on the far edges.
        let mut grid = vec![vec![[0.0f32; 3]; xs.len()]; ys.len()];
        for (j, &y) in ys.iter().enumerate() {
            for (i, &x) in xs.iter().enumerate() {
                let end = (i == 0 || i + 1 == xs.len(), j == 0 || j + 1 == ys.len());
                // Where first and far line are one, the far one is the first.
                let (right, bottom) = (i > 0 && xb > xa && x == xb, j > 0 && yb > ya && y == yb);
                let inner = (!end.0 || !end.1) && !right && !bottom;
                grid[j][i] = if end.0 && end.1 {
                    known[2 * usize::from(j > 0) + usize::from(i > 0)]
                } else if inner {
                    // In a line both edges are the same samples, traced once.
                    if !(xa == xb && i > 0 || ya == yb && j > 0) {
                        making.trace((x, y), depth);
                    }
                    making.colour(x, y)
                } else if bottom {
                    mix(known[2], known[3], (x - xa) as f32 / (xb - xa) as f32)
                } else {
                    mix(known[1], known[3], (y - ya) as f32 / (yb - ya) as f32)
                };
            }
        }
        for (j, y) in ys.windows(2).enumerate() {
            for (i, x) in xs.windows(2).enumerate() {
                let part = Cell { xa: x[0], xb: x[1], ya: y[0], yb: y[1] };
                let colours = [grid[j][i], grid[j][i + 1], grid[j + 1][i], grid[j + 1][i + 1]];
                squares.push((part, colours, depth + 1));
            }
        }
    }
}
