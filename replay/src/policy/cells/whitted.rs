//! Whitted 1980: a square whose corners differ in their colours is cut into four, and so on.
//!
//! He samples the corners of each pixel, averages them if they are nearly equal, and else subdivides, until the squares are small
//! enough. A recorded grid has no samples between its own, so here cells end at single samples.

use rayreel_formats::math::Vec3;

use super::cell::{Cell, bilinear, owned, share};
use super::rule::{COLOURS, CellRule};
use crate::policy::interpolate::mix;
use crate::policy::kinds::Whitted1980;
use crate::policy::similarity::{Compared, difference};
use rayreel_machine::work::PolicyReads;

/// The rule.
#[derive(Clone, Debug)]
pub struct Whitted {
    colour: f64,
    least: u32,
}

/// A square of a cell: columns, rows, and the colours of its corners.
#[derive(Clone, Copy)]
struct Square {
    x: (u32, u32),
    y: (u32, u32),
    /// Own, right, below, across.
    corners: [Vec3; 4],
}

impl Whitted {
    /// The rule with these values.
    pub fn new(values: &Whitted1980) -> Self {
        Self { colour: values.colour, least: values.least }
    }

    fn decide(&self, cell: &mut Cell<'_>, square: Square, round: u8) {
        let Square { x, y, corners } = square;
        let first = (x.0, y.0);
        if owned(x, y).all(|at| at == first) {
            return;
        }
        let halves = |(a, b): (u32, u32)| b - a > self.least;
        let (wide, high) = (halves(x), halves(y));
        if !(wide || high) || self.alike(cell, square, round) {
            for at in owned(x, y).filter(|at| *at != first) {
                cell.interpolate(at, bilinear(corners, share(x, at.0), share(y, at.1)), round);
            }
            return;
        }
        // Where a direction is not halved, its middle is its far end: the samples there are the corners.
        let middle = |(a, b): (u32, u32), is_halved: bool| if is_halved { a.midpoint(b) } else { b };
        let (u, v) = (middle(x, wide), middle(y, high));
        let (s, t) = (share(x, u), share(y, v));
        let [corner, right, below, across] = corners;
        let mut traced = |at, is_new: bool| {
            is_new.then(|| {
                cell.trace(at, round);
                cell.colour(at)
            })
        };
        // A degenerate square has one edge for two.
        let flat = (x.0 == x.1, y.0 == y.1);
        let top = traced((u, y.0), wide).unwrap_or(right);
        let left = traced((x.0, v), high).unwrap_or(below);
        let centre = traced((u, v), wide && high);
        let lower = if flat.1 {
            top
        } else if wide {
            mix(below, across, s)
        } else {
            across
        };
        let beside = if flat.0 {
            left
        } else if high {
            mix(right, across, t)
        } else {
            across
        };
        let centre = centre.unwrap_or(if wide { lower } else { beside });
        let (west, east) = ((x.0, u), (u, x.1));
        let (north, south) = ((y.0, v), (v, y.1));
        self.decide(cell, Square { x: west, y: north, corners: [corner, top, left, centre] }, round + 1);
        if wide {
            self.decide(cell, Square { x: east, y: north, corners: [top, right, centre, beside] }, round + 1);
        }
        if high {
            self.decide(cell, Square { x: west, y: south, corners: [left, centre, below, lower] }, round + 1);
        }
        if wide && high {
            self.decide(cell, Square { x: east, y: south, corners: [centre, beside, lower, across] }, round + 1);
        }
    }

    /// No two corners differ by more than the limit.
    fn alike(&self, cell: &mut Cell<'_>, Square { x, y, corners }: Square, round: u8) -> bool {
        let pairs: &[(usize, usize)] = match (x.0 == x.1, y.0 == y.1) {
            (false, false) => &[(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)],
            // Two corners are all there are.
            _ => &[(0, 3)],
        };
        cell.compared(round, Compared { pairs: 1, colours: pairs.len() as u32 });
        pairs.iter().all(|&(a, b)| {
            let both = (corners[a], corners[b]);
            difference(both, both) <= self.colour
        })
    }
}

impl CellRule for Whitted {
    fn reads(&self) -> PolicyReads {
        COLOURS
    }

    fn decide(&self, cell: &mut Cell<'_>) {
        let square = Square { x: cell.x, y: cell.y, corners: cell.colours() };
        self.decide(cell, square, 1);
    }
}
