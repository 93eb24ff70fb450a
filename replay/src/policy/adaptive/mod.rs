//! The steps of the adaptive policies on one tile; `full` is the same with blocks of one sample.
//!
//! What a tile needs of its neighbours: for the X step the R-samples on its closing column (the first of the tile to the
//! right), for the Y step its closing row (the first of the tile below) after that tile's X step. Where the tile to the left has smaller blocks, a tile traces the samples of its first column that
//! close its neighbour's R-rows too.

mod line;
mod rules;

use super::Attributes;
use super::correct::correct;
use super::tree::Forest;
use super::view::TileView;
use line::{Axis, Line};
pub use rules::{KnownPast, Rules, TileRules};

impl TileRules<'_> {
    /// The X step: decides all samples on the R-rows of the tile. `closing` holds the samples of the closing column on these
    /// rows, if there is a tile to the right.
    pub fn step_x(&self, view: &mut TileView, closing: Option<&Forest>) {
        let rect = view.rect();
        if self.rules.sampling.attributes == Attributes::Lazy {
            view.make_attributes_lazily();
        }
        for (i, y) in self.lattice.rows(rect.y, rect.y + rect.height).enumerate() {
            let mut ends: Vec<_> = self.lattice.columns(rect.x, rect.x + rect.width).collect();
            ends.extend(closing.map(|_| rect.x + rect.width));
            let far = closing.map(|column| column.tree(i));
            let mut line = Line { rules: self, view, axis: Axis::X(y), round: 1, far, is_far_interpolated: false };
            ends.windows(2).for_each(|pair| line.decide(pair[0], pair[1], f64::INFINITY));
        }
    }

    /// The Y step: decides the rest of the tile. `closing` holds the closing row, if there is a tile below.
    pub fn step_y(&self, view: &mut TileView, closing: Option<&Forest>) {
        let rect = view.rect();
        let bottom = rect.y + rect.height;
        for x in rect.x..rect.x + rect.width {
            // In the first column that is more than the R-rows: what the tile to the left needed is traced too.
            let mut ends: Vec<_> = (rect.y..bottom).filter(|&y| view.state(x, y).is_some()).collect();
            ends.extend(closing.map(|_| bottom));
            let column = (x - rect.x) as usize;
            let far = closing.map(|row| row.tree(column));
            let is_far_interpolated = closing.is_some_and(|row| row.is_interpolated(column));
            let mut line =
                Line { rules: self, view, axis: Axis::Y(x), round: 1 + self.levels(), far, is_far_interpolated };
            ends.windows(2).for_each(|pair| line.decide(pair[0], pair[1], f64::INFINITY));
        }
        correct(view, &self.rules.sampling, (&self.tests, self.correct), 1 + 2 * self.levels());
    }
}
