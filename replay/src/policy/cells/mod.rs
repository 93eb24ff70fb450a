//! Policies that decide cell by cell: a cell lies between four R-samples, and looks at nothing else.
//!
//! ```text
//!   o . r     o: the R-sample that the cell owns    r: the one to its right
//!   . .       .: the other samples that it owns
//!   b   a     b: the R-sample below                 a: the one across
//! ```
//!
//! The far corners may belong to the tiles to the right, below, and to the right of that. R-samples need nobody, so a picture
//! depends on the frame alone and not on its tiles. What the cells do is a [`rule::CellRule`]: one file each.

mod cell;
mod jin;
mod mitchell;
mod rule;
mod whitted;

use rayreel_formats::scene::{Meta, Rect};

use super::kinds::Policy;
use super::lattice::{SampleLattice, check_tile};
use super::sampler::Sampler;
use super::tree::Forest;
use super::view::{SampleState, TileView};
use crate::error::Result;
use cell::{Cell, Outside};
use jin::Jin;
use mitchell::Mitchell;
use rayreel_machine::work::PolicyReads;
use rule::CellRule;
use whitted::Whitted;

/// The sampler of a policy of cells; nothing for other policies.
///
/// # Errors
/// When a value of the policy is out of range, or its block does not suit the tiles of the trace.
pub fn sampler(policy: &Policy, meta: &Meta) -> Result<Option<Box<dyn Sampler>>> {
    let sampler = match policy {
        Policy::Whitted1980(values) => boxed(Whitted::new(values), values.block, meta),
        Policy::Mitchell1987(values) => boxed(Mitchell::new(values), values.block, meta),
        Policy::Jin2009(values) => boxed(Jin::new(values), values.block, meta),
        Policy::Full | Policy::Adaptive(_) | Policy::Multirate(_) | Policy::Temporal(_) | Policy::Foveated(_) => {
            return Ok(None);
        }
    };
    policy.check()?;
    check_tile(meta.tile, policy)?;
    Ok(Some(sampler))
}

fn boxed<R: CellRule>(rule: R, block: u32, meta: &Meta) -> Box<dyn Sampler> {
    let (width, height) = meta.grid();
    Box::new(CellSampler { rule, lattice: SampleLattice { width, height, block } })
}

/// A policy of cells at work.
#[derive(Clone)]
struct CellSampler<R> {
    rule: R,
    lattice: SampleLattice,
}

/// The far ends of the cells of a tile along one axis.
struct Ends {
    /// First samples of the cells.
    starts: Vec<u32>,
    /// Where the tile ends.
    end: u32,
    /// Samples of the frame.
    size: u32,
}

impl Ends {
    /// The cells by number: first sample and far end, which is the same in the frame's last column or row.
    fn cells(&self) -> impl Iterator<Item = (usize, (u32, u32))> + '_ {
        self.starts.iter().enumerate().map(|(i, &start)| {
            let next = self.starts.get(i + 1).copied().unwrap_or(self.end);
            (i, (start, if start + 1 == self.size { start } else { next }))
        })
    }
}

impl<R> CellSampler<R> {
    fn columns(&self, rect: Rect) -> Ends {
        let end = rect.x + rect.width;
        Ends { starts: self.lattice.columns(rect.x, end).collect(), end, size: self.lattice.width }
    }

    fn rows(&self, rect: Rect) -> Ends {
        let end = rect.y + rect.height;
        Ends { starts: self.lattice.rows(rect.y, end).collect(), end, size: self.lattice.height }
    }
}

impl<R: CellRule> Sampler for CellSampler<R> {
    fn deep(&self) -> bool {
        self.rule.deep()
    }

    fn reads(&self) -> PolicyReads {
        self.rule.reads()
    }

    fn begin_tile(&self, view: &mut TileView) {
        let (columns, rows) = (self.columns(view.rect()), self.rows(view.rect()));
        let all = rows.starts.iter().flat_map(|&y| columns.starts.iter().map(move |&x| (x, y)));
        all.for_each(|(x, y)| view.trace(x, y, SampleState::Reference, 0));
    }

    fn shared_rows(&self, view: &TileView) -> Vec<u32> {
        self.rows(view.rect()).starts
    }

    fn shares_first_row(&self) -> bool {
        true
    }

    fn shared_columns(&self, view: &TileView) -> Vec<u32> {
        self.columns(view.rect()).starts
    }

    fn shares_corner(&self) -> bool {
        true
    }

    fn waiting_from(&self, view: &TileView) -> (u32, u32) {
        let last = |ends: Ends| ends.starts.last().copied().unwrap_or(u32::MAX);
        (last(self.columns(view.rect())), last(self.rows(view.rect())))
    }

    /// All cells that need nothing of the tiles below.
    fn step_x(&self, view: &mut TileView, right: Option<&Forest>) {
        let (columns, rows) = (self.columns(view.rect()), self.rows(view.rect()));
        for (row, y) in rows.cells().filter(|(_, y)| y.1 != rows.end) {
            for (_, x) in columns.cells() {
                let closing = |row: usize| right.filter(|_| x.1 == columns.end).map(|right| right.tree(row));
                let next = if y.0 == y.1 { row } else { row + 1 };
                let outside = Outside { right: closing(row), below: None, across: closing(next) };
                self.rule.decide(&mut Cell::new(view, x, y, outside));
            }
        }
    }

    /// The cells of the last row, which end in the tiles below.
    fn step_y(&self, view: &mut TileView, below: Option<&Forest>) {
        let Some(below) = below else { return };
        let (columns, rows) = (self.columns(view.rect()), self.rows(view.rect()));
        let count = columns.starts.len();
        for (_, y) in rows.cells().filter(|(_, y)| y.1 == rows.end) {
            for (column, x) in columns.cells() {
                let beside = if x.0 == x.1 { column } else { column + 1 };
                let is_last = x.1 == columns.end;
                let across = if is_last { below.tree(count + 1) } else { below.tree(beside) };
                let right = is_last.then(|| below.tree(count));
                let outside = Outside { right, below: Some(below.tree(column)), across: Some(across) };
                self.rule.decide(&mut Cell::new(view, x, y, outside));
            }
        }
    }

    fn block(&self, _tile: u32) -> u32 {
        self.lattice.block
    }

    fn fork(&self) -> Option<Box<dyn Sampler>> {
        Some(Box::new(self.clone()))
    }
}
