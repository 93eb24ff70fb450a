//! The steps of the adaptive policy on one tile; `full` is the same with blocks of one sample.
//!
//! A tile needs of its neighbours: for the X step the R-samples on its closing column, for the Y step its closing row after
//! that row's own X step.

use super::interpolate::interpolate;
use super::lattice::Lattice;
use super::similarity::Tests;
use super::view::{Point, SampleState, TileView};
use super::{Apron, Limit, Policy, Refine, Similarity};
use crate::error::Result;

/// A policy prepared for frames of one size.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Where the R-samples stand.
    pub lattice: Lattice,
    /// Who pays for the far border of a tile.
    pub apron: Apron,
    refine: Refine,
    tests: Tests,
}

impl Rules {
    /// Prepares `policy` for a sample grid.
    ///
    /// # Errors
    /// When a value of the policy is out of range.
    pub fn new(policy: &Policy, (width, height): (u32, u32)) -> Result<Self> {
        policy.check()?;
        let lattice = |block| Lattice { width, height, block };
        Ok(match policy {
            Policy::Full => {
                // Blocks of one sample leave nothing to test.
                let off = Limit::Off;
                let none = Similarity { object_id: true, normal_deg: off, shadow: true, position: off, plane: off };
                Self { lattice: lattice(1), apron: Apron::Share, refine: Refine::Direct, tests: Tests::new(&none) }
            }
            Policy::Adaptive(own) => Self {
                lattice: lattice(own.block),
                apron: own.apron,
                refine: own.refine,
                tests: Tests::new(&own.similarity),
            },
        })
    }

    /// Traces the R-samples of the tile: wave 0.
    pub fn trace_references(&self, view: &mut TileView) {
        let rect = view.rect();
        for y in self.lattice.rows(rect.y, rect.y + rect.height) {
            for x in self.lattice.columns(rect.x, rect.x + rect.width) {
                view.trace(x, y, SampleState::Reference, 0);
            }
        }
    }

    /// The R-samples of the tile's first column, top to bottom: the closing column of the tile to its left.
    pub fn first_column(&self, view: &TileView) -> Vec<Point> {
        let rect = view.rect();
        self.lattice.rows(rect.y, rect.y + rect.height).map(|y| view.point(rect.x, y)).collect()
    }

    /// The X step: decides all samples on the R-rows of the tile. `closing` holds the R-samples of the closing column, if
    /// there is a tile to the right.
    pub fn step_x(&self, view: &mut TileView, closing: Option<&[Point]>) {
        let rect = view.rect();
        for (i, y) in self.lattice.rows(rect.y, rect.y + rect.height).enumerate() {
            let own = self.lattice.columns(rect.x, rect.x + rect.width).map(|x| (x, view.point(x, y)));
            let mut ends: Vec<_> = own.collect();
            ends.extend(closing.map(|points| (rect.x + rect.width, points[i])));
            let mut line = Line { rules: self, view, axis: Axis::X(y), wave: 1 };
            ends.windows(2).for_each(|pair| line.decide(pair[0], pair[1]));
        }
    }

    /// The Y step: decides the rest of the tile. `closing` holds the closing row, if there is a tile below.
    pub fn step_y(&self, view: &mut TileView, closing: Option<&[Point]>) {
        let rect = view.rect();
        for x in rect.x..rect.x + rect.width {
            let own = self.lattice.rows(rect.y, rect.y + rect.height).map(|y| (y, view.point(x, y)));
            let mut ends: Vec<_> = own.collect();
            ends.extend(closing.map(|points| (rect.y + rect.height, points[(x - rect.x) as usize])));
            let mut line = Line { rules: self, view, axis: Axis::Y(x), wave: 1 + self.levels() };
            ends.windows(2).for_each(|pair| line.decide(pair[0], pair[1]));
        }
    }

    /// Waves that one step may take.
    fn levels(&self) -> u8 {
        match self.refine {
            Refine::Direct => 1,
            Refine::Hierarchical => self.lattice.block.next_power_of_two().trailing_zeros() as u8,
        }
    }
}

/// The direction of a line of samples and its fixed coordinate.
#[derive(Clone, Copy)]
enum Axis {
    X(u32),
    Y(u32),
}

/// A row or column of a tile between known samples.
struct Line<'a> {
    rules: &'a Rules,
    view: &'a mut TileView,
    axis: Axis,
    /// The wave of the first test.
    wave: u8,
}

impl Line<'_> {
    /// Decides the samples between two known ones.
    fn decide(&mut self, (a, from): (u32, Point), (b, to): (u32, Point)) {
        if b - a < 2 {
            return;
        }
        self.view.tested(self.at(a + 1), self.wave);
        if self.rules.tests.similar(&from, &to) {
            for i in a + 1..b {
                let (x, y) = self.at(i);
                self.view.interpolate(x, y, interpolate(&from, &to, i - a, b - a), self.wave);
            }
            return;
        }
        match self.rules.refine {
            Refine::Direct => {
                for i in a + 1..b {
                    self.trace(i);
                }
            }
            Refine::Hierarchical => {
                let middle = a.midpoint(b);
                let point = self.trace(middle);
                self.wave += 1;
                self.decide((a, from), (middle, point));
                self.decide((middle, point), (b, to));
                self.wave -= 1;
            }
        }
    }

    fn trace(&mut self, i: u32) -> Point {
        let (x, y) = self.at(i);
        self.view.trace(x, y, SampleState::Traced, self.wave)
    }

    fn at(&self, i: u32) -> (u32, u32) {
        match self.axis {
            Axis::X(y) => (i, y),
            Axis::Y(x) => (x, i),
        }
    }
}
