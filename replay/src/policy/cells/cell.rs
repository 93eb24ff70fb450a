//! A cell: the samples that it owns, and its corners, wherever they lie.

use rayreel_formats::math::Vec3;

use crate::policy::interpolate::mix;
use crate::policy::similarity::Compared;
use crate::policy::tree::Node;
use crate::policy::view::{SampleState, TileView};

/// Corners that lie in other tiles; those of the tile itself are left out.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outside<'a> {
    pub right: Option<&'a [Node]>,
    pub below: Option<&'a [Node]>,
    pub across: Option<&'a [Node]>,
}

/// A cell of a tile. It owns the samples from the first column and row up to the far ones, these left out; in the last column
/// or row of the frame both are the same, and it owns that one.
pub struct Cell<'a> {
    view: &'a mut TileView,
    /// First and far column.
    pub x: (u32, u32),
    /// First and far row.
    pub y: (u32, u32),
    outside: Outside<'a>,
}

impl<'a> Cell<'a> {
    /// The cell of `view` between these columns and rows.
    pub fn new(view: &'a mut TileView, x: (u32, u32), y: (u32, u32), outside: Outside<'a>) -> Self {
        Self { view, x, y, outside }
    }

    /// The R-sample that it owns.
    pub fn first(&self) -> &[Node] {
        self.view.tree(self.x.0, self.y.0)
    }

    /// The R-sample to its right: its own in a cell of the last column.
    pub fn right(&self) -> &[Node] {
        self.outside.right.unwrap_or_else(|| self.view.tree(self.x.1, self.y.0))
    }

    /// The R-sample below: its own in a cell of the last row.
    pub fn below(&self) -> &[Node] {
        self.outside.below.unwrap_or_else(|| self.view.tree(self.x.0, self.y.1))
    }

    /// The R-sample across: the one below in a cell of the last column, the one to the right in one of the last row.
    pub fn across(&self) -> &[Node] {
        self.outside.across.unwrap_or_else(|| self.view.tree(self.x.1, self.y.1))
    }

    /// The colours of its corners: its own, right, below, across.
    pub fn colours(&self) -> [Vec3; 4] {
        [self.first(), self.right(), self.below(), self.across()].map(|tree| tree[0].colour)
    }

    /// The samples that it owns beside its R-sample, row by row.
    pub fn samples(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let first = (self.x.0, self.y.0);
        owned(self.x, self.y).filter(move |at| *at != first)
    }

    /// Traces a sample.
    pub fn trace(&mut self, (x, y): (u32, u32), round: u8) {
        self.view.trace(x, y, SampleState::Traced, round);
    }

    /// The colour of a sample that is known.
    pub fn colour(&self, (x, y): (u32, u32)) -> Vec3 {
        self.view.tree(x, y)[0].colour
    }

    /// Gives a sample this colour, and the primary hit of the R-sample.
    pub fn interpolate(&mut self, at: (u32, u32), colour: Vec3, round: u8) {
        let node = Node { colour, reflect: None, refract: None, len: 1, ..self.first()[0] };
        // Nothing is made of it, so nobody reads its attributes.
        self.view.interpolate_from(at, round, 0, |_, out| out.push(node));
    }

    /// Notes what a test took. A cell that owns its R-sample only has nothing to test.
    pub fn compared(&mut self, round: u8, compared: Compared) {
        if let Some(at) = self.samples().next() {
            self.view.compared(at, round, compared);
        }
    }
}

/// The samples between these columns and rows, row by row.
pub fn owned(x: (u32, u32), y: (u32, u32)) -> impl Iterator<Item = (u32, u32)> {
    let (right, bottom) = (x.1.max(x.0 + 1), y.1.max(y.0 + 1));
    (y.0..bottom).flat_map(move |v| (x.0..right).map(move |u| (u, v)))
}

/// How far `at` is on the way from the first to the far one; 0 where they are the same.
pub fn share((first, far): (u32, u32), at: u32) -> f32 {
    if far > first { (at - first) as f32 / (far - first) as f32 } else { 0.0 }
}

/// The colour between four corners, `u` of the way to the right and `v` of the way down.
pub fn bilinear([first, right, below, across]: [Vec3; 4], u: f32, v: f32) -> Vec3 {
    mix(mix(first, right, u), mix(below, across, u), v)
}
