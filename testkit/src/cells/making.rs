//! A frame of cells in the making.

use crate::reference::Origin;
use crate::reference::maker::{KnownSample, Maker};
use crate::rules::Hit;

/// What was done in a round beside tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Tests.
    pub tests: u64,
    /// Differences of colours.
    pub colours: u64,
    /// Samples that were interpolated.
    pub interpolated: u64,
}

/// A cell: its first and its far column and row.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    pub xa: usize,
    pub xb: usize,
    pub ya: usize,
    pub yb: usize,
}

/// A frame in the making.
pub struct Making<'a> {
    pub maker: Maker<'a>,
    pub width: usize,
    pub rounds: Vec<Work>,
}

impl Cell {
    /// All that it owns, row by row.
    pub fn owned(self) -> Vec<(usize, usize)> {
        let (right, bottom) = (self.xb.max(self.xa + 1), self.yb.max(self.ya + 1));
        (self.ya..bottom).flat_map(|y| (self.xa..right).map(move |x| (x, y))).collect()
    }

    /// The same without its R-sample.
    pub fn others(self) -> Vec<(usize, usize)> {
        self.owned()[1..].to_vec()
    }

    /// It has one column or one row of R-samples only.
    pub fn is_line(self) -> bool {
        self.xa == self.xb || self.ya == self.yb
    }
}

impl Making<'_> {
    pub fn hit(&self, x: usize, y: usize) -> &Hit {
        self.maker.tree(y * self.width + x)
    }

    pub fn colour(&self, x: usize, y: usize) -> [f32; 3] {
        self.hit(x, y).colour
    }

    pub fn trace(&mut self, (x, y): (usize, usize), round: u8) {
        self.maker.whole(y * self.width + x, Origin::Traced, round);
    }

    pub fn interpolate(&mut self, (x, y): (usize, usize), colour: [f32; 3], round: u8) {
        // Nothing but the colour of an interpolated sample is looked at.
        let mut tree = self.maker.frame.recorded[y * self.width + x].clone();
        (tree.colour, tree.below) = (colour, [None, None]);
        self.maker.known[y * self.width + x] = Some(KnownSample { tree, how: Origin::Interpolated, round, age: 0 });
        self.work(round).interpolated += 1;
    }

    pub fn work(&mut self, round: u8) -> &mut Work {
        let round = usize::from(round);
        if self.rounds.len() <= round {
            self.rounds.resize(round + 1, Work::default());
        }
        &mut self.rounds[round]
    }
}
