//! An adaptive policy prepared for the frames of a trace, and for one tile: where R-samples stand, and how a sample is traced.

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Meta, Rect};
use rayreel_machine::work::PolicyReads;

use crate::error::Result;
use crate::policy::audit::Audit;
use crate::policy::history::History;
use crate::policy::lattice::SampleLattice;
use crate::policy::rate::TileRate;
use crate::policy::reuse::{Eye, Look};
use crate::policy::shade::Shading;
use crate::policy::similarity::Tests;
use crate::policy::view::{SampleState, TileView};
use crate::policy::{Apron, HistoryRules, Policy, Refine, Sampling, Shade, Temporal};

/// A policy prepared for frames of one size.
#[derive(Clone, Debug)]
pub struct Rules {
    size: (u32, u32),
    /// There are I-samples: the blocks have more than one sample.
    blocks: bool,
    /// Who pays for the far border of a tile.
    pub apron: Apron,
    pub(super) sampling: Sampling,
    /// How interpolated samples are shaded, if they are.
    pub(super) shading: Option<Shading>,
    /// Which pixels are audited, if any.
    pub audit: Option<Audit>,
    /// What is kept from frame to frame, if anything.
    pub history: Option<HistoryRules>,
}

/// The rules for one tile.
#[derive(Clone, Copy, Debug)]
pub struct TileRules<'a> {
    pub(super) rules: &'a Rules,
    /// Where the R-samples stand.
    pub lattice: SampleLattice,
    /// Where the tile to the left has its R-rows.
    pub left: SampleLattice,
    pub(super) tests: Tests,
    /// Factor on the limits of correction.
    pub(super) correct: f64,
    /// Where the camera is, scene units.
    pub(super) eye: Vec3,
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
                audit = every.map(|every| Audit { every, samples: meta.samples, width: meta.width });
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
        TileRules {
            rules: self,
            lattice: lattice(rate.block),
            left: lattice(rate.left),
            tests,
            correct: rate.correct,
            eye,
            past,
        }
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
    pub(super) fn trace(&self, view: &mut TileView, (x, y): (u32, u32), state: SampleState, round: u8) {
        let look = self.look(x, y);
        if matches!(look, Look::Nowhere) {
            return view.trace(x, y, state, round);
        }
        let mut eye = Eye::new(look);
        view.build((x, y), round, state == SampleState::Reference, |tracer, _, out| {
            eye.sample(tracer, out);
            0
        });
        view.looked_back((x, y), round, &eye);
    }

    /// What sample (`x`, `y`) does with the history, if there is one.
    pub(super) fn look(&self, x: u32, y: u32) -> Look<'_> {
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

    /// How many rounds one step may take.
    pub(super) fn levels(&self) -> u8 {
        match self.rules.sampling.refine {
            Refine::Direct => 1,
            Refine::Hierarchical => self.lattice.block.next_power_of_two().trailing_zeros() as u8,
        }
    }
}
