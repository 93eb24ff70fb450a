//! The steps of the adaptive policies on one tile; `full` is the same with blocks of one sample.
//!
//! What a tile needs of its neighbours: for the X step the R-samples on its closing column (the first of the tile to the
//! right), for the Y step its closing row (the first of the tile below) after that tile's X step. Where the tile to the left has smaller blocks, a tile traces the samples of its first column that
//! close its neighbour's R-rows too.

mod line;

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Meta, Rect};

use super::audit::Audit;
use super::correct::correct;
use super::history::History;
use super::lattice::SampleLattice;
use super::rate::TileRate;
use super::reuse::{Eye, Look};
use super::shade::Shading;
use super::similarity::Tests;
use super::tree::Forest;
use super::view::{SampleState, TileView};
use super::{Apron, Attributes, HistoryRules, Policy, Refine, Sampling, Shade, Temporal};
use crate::error::Result;
use line::{Axis, Line};
use rayreel_machine::work::PolicyReads;

/// A policy prepared for frames of one size.
#[derive(Clone, Debug)]
pub struct Rules {
    size: (u32, u32),
    /// There are I-samples: the blocks have more than one sample.
    blocks: bool,
    /// Who pays for the far border of a tile.
    pub apron: Apron,
    sampling: Sampling,
    /// How interpolated samples are shaded, if they are.
    shading: Option<Shading>,
    /// Which pixels are audited, if any.
    pub audit: Option<Audit>,
    /// What is kept from frame to frame, if anything.
    pub history: Option<HistoryRules>,
}

/// The rules for one tile.
#[derive(Clone, Copy, Debug)]
pub struct TileRules<'a> {
    rules: &'a Rules,
    /// Where the R-samples stand.
    pub lattice: SampleLattice,
    /// Where the tile to the left has its R-rows.
    pub left: SampleLattice,
    tests: Tests,
    /// Where the camera is, scene units.
    eye: Vec3,
    /// The frame, and what is known of the one before.
    past: Option<KnownPast<'a>>,
}

/// What a tile knows of the frame before.
#[derive(Clone, Copy, Debug)]
pub struct KnownPast<'a> {
    /// The frame at work.
    pub frame: u32,
    /// What was kept of the one before.
    pub history: &'a History,
    /// It was right of late.
    pub is_trusted: bool,
}

impl Rules {
    /// Prepares `policy` for the frames of a trace.
    ///
    /// # Errors
    /// When a value of the policy is out of range.
    pub fn new(policy: &Policy, meta: &Meta) -> Result<Self> {
        policy.check()?;
        let (size, mut audit) = (meta.grid(), None);
        let history = match policy {
            Policy::Temporal(temporal) => Some(temporal.history.clone()),
            _ => None,
        };
        let (apron, sampling) = match policy {
            // Blocks of one sample leave nothing to test, and nothing to correct.
            // Cells have rules of their own.
            Policy::Full | Policy::Whitted1980(_) | Policy::Mitchell1987(_) | Policy::Jin2009(_) => {
                (Apron::Share, Sampling::NONE)
            }
            Policy::Adaptive(adaptive) => (adaptive.apron, adaptive.sampling.clone()),
            Policy::Multirate(multirate) | Policy::Temporal(Temporal { multirate, .. }) => {
                let every = multirate.target.psnr_db.value().map(|_| multirate.target.audit);
                let partial = history.is_some();
                audit = every.map(|every| Audit { every, samples: meta.samples, width: meta.width, partial });
                (Apron::Share, multirate.sampling.clone())
            }
            Policy::Foveated(foveated) => (Apron::Share, foveated.sampling.clone()),
        };
        let is_shaded = sampling.shade == Shade::Attributes;
        let shading =
            is_shaded.then(|| Shading { ambient: sampling.shade_ambient as f32, lights: meta.lights.clone() });
        Ok(Self { shading, size, blocks: *policy != Policy::Full, apron, sampling, audit, history })
    }

    /// True when the policy looks at more than primary hits.
    pub fn deep(&self) -> bool {
        self.sampling.secondary || self.sampling.similarity.secondary || self.history.is_some()
    }

    /// What the SRP reads of hits to decide; `control` says whether tiles have rates or limits of their own.
    pub fn reads(&self, control: bool) -> PolicyReads {
        let Sampling { secondary, stand_in, similarity, .. } = &self.sampling;
        // A lean is the product of a normal and an offset, as a distance from a plane is, measured by a distance. Light falls by
        // normal and position.
        let (bends, is_shaded) = (similarity.convexity.value().is_some(), self.shading.is_some());
        PolicyReads {
            object: similarity.object_id || *secondary,
            normal: similarity.normal_deg.value().is_some() || bends || is_shaded,
            shadow: similarity.shadow || is_shaded,
            position: similarity.position.value().is_some() || bends || is_shaded,
            plane: similarity.plane.value().is_some() || bends,
            local: similarity.texture.value().is_some() || *stand_in || is_shaded,
            weights: *secondary,
            control,
            history: self.history.is_some(),
        }
    }

    /// Whether neighbouring tiles read each other's samples: where each sample is an R-sample nothing is tested.
    pub fn reads_neighbours(&self) -> bool {
        self.blocks
    }

    /// The rules for a tile of rate `rate`, seen from `eye`.
    pub fn tile<'a>(&'a self, rate: TileRate, eye: Vec3, past: Option<KnownPast<'a>>) -> TileRules<'a> {
        let lattice = |block| SampleLattice { width: self.size.0, height: self.size.1, block };
        let tests = Tests::new(&self.sampling.similarity, rate.relax);
        TileRules { rules: self, lattice: lattice(rate.block), left: lattice(rate.left), tests, eye, past }
    }
}

impl TileRules<'_> {
    /// Traces the R-samples of the tile: round 0.
    pub fn trace_references(&self, view: &mut TileView) {
        let rect = view.rect();
        for y in rect.y..rect.y + rect.height {
            if self.lattice.is_row(y) {
                for x in self.lattice.columns(rect.x, rect.x + rect.width) {
                    self.trace(view, (x, y), SampleState::Reference, 0);
                }
            } else if rect.x > 0 && self.left.is_row(y) {
                self.trace(view, (rect.x, y), SampleState::Reference, 0);
            }
        }
    }

    /// Traces a sample whole, but for rays to lights that are known.
    fn trace(&self, view: &mut TileView, (x, y): (u32, u32), state: SampleState, round: u8) {
        let look = self.look(x, y);
        if matches!(look, Look::Nowhere) {
            return view.trace(x, y, state, round);
        }
        let mut eye = Eye::new(look);
        view.build((x, y), round, state == SampleState::Reference, |tracer, _, out| {
            eye.subtree(tracer, 0, 1, out);
            0
        });
        view.looked_back((x, y), round, &eye);
    }

    /// What sample (`x`, `y`) does with the history, if there is one.
    fn look(&self, x: u32, y: u32) -> Look<'_> {
        match self.past {
            Some(KnownPast { frame, history, .. }) if history.refreshes(frame, x, y) => Look::Check(history),
            Some(KnownPast { history, is_trusted: true, .. }) => Look::Back(history),
            _ => Look::Nowhere,
        }
    }

    /// The rows on which a sample of the tile's first column closes an R-row of the tile to its left, top to bottom.
    pub fn shared_rows(&self, rect: Rect) -> Vec<u32> {
        if self.rules.reads_neighbours() { self.left.rows(rect.y, rect.y + rect.height).collect() } else { Vec::new() }
    }

    /// First column and row behind the last R-samples of the tile.
    pub fn waiting_from(&self, rect: Rect) -> (u32, u32) {
        let column = self.lattice.columns(rect.x, rect.x + rect.width).last();
        let row = self.lattice.rows(rect.y, rect.y + rect.height).last();
        let behind = |last: Option<u32>| last.map_or(u32::MAX, |last| last + 1);
        (behind(column), behind(row))
    }

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
        correct(view, &self.rules.sampling, &self.tests, 1 + 2 * self.levels());
    }

    /// How many rounds one step may take.
    fn levels(&self) -> u8 {
        match self.rules.sampling.refine {
            Refine::Direct => 1,
            Refine::Hierarchical => self.lattice.block.next_power_of_two().trailing_zeros() as u8,
        }
    }
}
