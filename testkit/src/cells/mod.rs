//! A second implementation of the policies of cells: the whole frame at once, slow and obvious, written from POLICIES.md and not
//! from the code it checks.

mod attributes;
mod colours;

use rayreel_replay::TileSource;
use rayreel_replay::policy::{Apron, Policy, Refine};

use crate::policies::adaptive;
use crate::recorded::read;
use crate::reference::area::{Area, on};
use crate::reference::maker::{KnownSample, Maker};
use crate::reference::{Origin, Outcome};
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
struct Cell {
    xa: usize,
    xb: usize,
    ya: usize,
    yb: usize,
}

/// A frame in the making.
struct Making<'a> {
    maker: Maker<'a>,
    width: usize,
    rounds: Vec<Work>,
}

/// Replays one frame; what became of its samples, and what was done in each round.
///
/// # Panics
/// When the policy is none of cells.
pub fn replay<S: TileSource>(source: &S, policy: &Policy, frame: u32) -> (Outcome, Vec<Work>) {
    let (block, deep) = match policy {
        Policy::Whitted1980(values) => (values.block, false),
        Policy::Mitchell1987(values) => (values.block, false),
        Policy::Jin2009(values) => {
            let p = &values.priority;
            (values.block, p.soid + p.ssn + p.ssc + p.ste > 0)
        }
        other => panic!("{other:?} has no cells"),
    };
    let meta = source.meta();
    let recorded = read(source, frame, deep);
    let tiles: Vec<_> = (0..meta.tile_count()).map(|i| Area::new(meta.tile_rect(i), (block, 1.0))).collect();
    // The bill is the same as that of blocks which share their aprons.
    let shared = adaptive(block, Refine::Direct, Apron::Share);
    let (width, height, n) = (recorded.width, recorded.height, block as usize);
    let traced = recorded.rays.iter().map(|hits| vec![false; hits.len()]).collect();
    let known = vec![None; width * height];
    let maker = Maker { policy: &shared, frame: &recorded, known, traced, stand_ins: Vec::new() };
    let mut making = Making { maker, width, rounds: Vec::new() };
    let lines = |size: usize| (0..size).filter(|at| on(*at, n, size - 1)).collect::<Vec<_>>();
    let (columns, rows) = (lines(width), lines(height));
    for &y in &rows {
        columns.iter().for_each(|x| making.maker.whole(y * width + x, Origin::R, 0));
    }
    for (j, &ya) in rows.iter().enumerate() {
        for (i, &xa) in columns.iter().enumerate() {
            let (xb, yb) = (*columns.get(i + 1).unwrap_or(&xa), *rows.get(j + 1).unwrap_or(&ya));
            let cell = Cell { xa, xb, ya, yb };
            match policy {
                Policy::Whitted1980(values) => colours::whitted(&mut making, values, cell),
                Policy::Mitchell1987(values) => colours::mitchell(&mut making, values, cell),
                Policy::Jin2009(values) => attributes::jin(&mut making, values, cell),
                _ => unreachable!("checked above"),
            }
        }
    }
    let Making { maker, rounds, .. } = making;
    let before = maker.traced.clone();
    (maker.account(&tiles, &before), rounds)
}

impl Cell {
    /// All that it owns, row by row.
    fn owned(self) -> Vec<(usize, usize)> {
        let (right, bottom) = (self.xb.max(self.xa + 1), self.yb.max(self.ya + 1));
        (self.ya..bottom).flat_map(|y| (self.xa..right).map(move |x| (x, y))).collect()
    }

    /// The same without its R-sample.
    fn others(self) -> Vec<(usize, usize)> {
        self.owned()[1..].to_vec()
    }

    /// It has one column or one row of R-samples only.
    fn is_line(self) -> bool {
        self.xa == self.xb || self.ya == self.yb
    }
}

impl Making<'_> {
    fn hit(&self, x: usize, y: usize) -> &Hit {
        self.maker.tree(y * self.width + x)
    }

    fn colour(&self, x: usize, y: usize) -> [f32; 3] {
        self.hit(x, y).colour
    }

    fn trace(&mut self, (x, y): (usize, usize), round: u8) {
        self.maker.whole(y * self.width + x, Origin::Traced, round);
    }

    fn interpolate(&mut self, (x, y): (usize, usize), colour: [f32; 3], round: u8) {
        // Nothing but the colour of an interpolated sample is looked at.
        let mut tree = self.maker.frame.recorded[y * self.width + x].clone();
        (tree.colour, tree.below) = (colour, [None, None]);
        self.maker.known[y * self.width + x] = Some(KnownSample { tree, how: Origin::Interpolated, round });
        self.work(round).interpolated += 1;
    }

    fn work(&mut self, round: u8) -> &mut Work {
        let round = usize::from(round);
        if self.rounds.len() <= round {
            self.rounds.resize(round + 1, Work::default());
        }
        &mut self.rounds[round]
    }
}
