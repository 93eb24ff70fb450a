//! The steps of the adaptive policies on one tile; `full` is the same with blocks of one sample.
//!
//! What a tile needs of its neighbours: for the X step the R-samples on its closing column (the first of the tile to the
//! right), for the Y step its closing row (the first of the tile below) after that tile's X step. Where the tile to the left has smaller blocks, a tile traces the samples of its first column that
//! close its neighbour's R-rows too.

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Meta, Rect};

use super::audit::Audit;
use super::correct::correct;
use super::history::History;
use super::interpolate::{interpolate_tree, mix, nearer};
use super::lattice::SampleLattice;
use super::rate::TileRate;
use super::reuse::{Eye, Rebuild};
use super::shade::Shading;
use super::similarity::{Compared, Tests};
use super::tree::{Forest, Node};
use super::view::{KnownTrees, SampleState, TileView};
use super::{Apron, Attributes, HistoryRules, Policy, Refine, Sampling, Shade, Temporal};
use crate::error::Result;
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
    past: Option<(u32, &'a History)>,
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
    pub fn tile<'a>(&'a self, rate: TileRate, eye: Vec3, past: Option<(u32, &'a History)>) -> TileRules<'a> {
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
        let Some(history) = self.looks_at(x, y) else { return view.trace(x, y, state, round) };
        let mut eye = Eye::new(Some(history));
        view.build((x, y), round, state == SampleState::Reference, |tracer, _, out| {
            eye.subtree(tracer, 0, 1, out);
            0
        });
        view.looked_back((x, y), round, eye.place, eye.hits);
    }

    /// The history that a sample looks at; nothing if there is none, or it looks for its lights in any case.
    fn looks_at(&self, x: u32, y: u32) -> Option<&History> {
        let (frame, history) = self.past?;
        (!history.refreshes(frame, x, y)).then_some(history)
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

/// The direction of a line of samples and its fixed coordinate.
#[derive(Clone, Copy)]
enum Axis {
    X(u32),
    Y(u32),
}

/// A row or column of a tile between known samples.
struct Line<'a> {
    rules: &'a TileRules<'a>,
    view: &'a mut TileView,
    axis: Axis,
    /// The round of the first test.
    round: u8,
    /// The sample past the end of the tile.
    far: Option<&'a [Node]>,
    /// That sample was interpolated.
    is_far_interpolated: bool,
}

impl<'a> Line<'a> {
    /// Decides the samples between two known ones. One of the two may have been traced just now, as the middle of a wider gap:
    /// `foreseen` is how far its colour was off the one that interpolation would have given it, else infinite.
    fn decide(&mut self, a: u32, b: u32, foreseen: f64) {
        if b - a < 2 {
            return;
        }
        let mut compared = Compared::default();
        let similar = self.rules.tests.similar(self.tree(a), self.tree(b), b - a, foreseen, &mut compared);
        self.view.compared(self.at(a + 1), self.round, compared);
        // Trees are compared hit by hit, and as far as they are alike.
        [a, b].into_iter().for_each(|end| self.read(end, self.at(a + 1), compared.pairs));
        match self.rules.rules.sampling.refine {
            _ if similar => (a + 1..b).for_each(|i| self.interpolate(a, b, i)),
            Refine::Direct => (a + 1..b).for_each(|i| self.trace(a, b, i)),
            Refine::Hierarchical => {
                let middle = a.midpoint(b);
                let expected = self.rules.tests.predict.then(|| self.expected_colour(a, b, middle));
                self.trace(a, b, middle);
                let predicted = u32::from(expected.is_some());
                self.view.compared(self.at(middle), self.round, Compared { pairs: 0, colours: predicted });
                let foreseen = expected.map_or(f64::INFINITY, |colour| self.miss(middle, colour));
                self.round += 1;
                self.decide(a, middle, foreseen);
                self.decide(middle, b, foreseen);
                self.round -= 1;
            }
        }
    }

    /// Interpolates sample `i` between `a` and `b`.
    fn interpolate(&mut self, a: u32, b: u32, i: u32) {
        let (swap, s) = nearer(i - a, b - a);
        let (near, far) = if swap { (b, a) } else { (a, b) };
        let ends = self.ends();
        let (shading, eye) = (&self.rules.rules.shading, self.rules.eye);
        let (x, y) = self.at(i);
        // Hits that the history keeps of it.
        let kept = self.rules.rules.history.as_ref().map_or(0, |history| history.hits_kept((x, y)));
        if kept > 0 {
            [near, far].into_iter().for_each(|end| self.read(end, (x, y), kept));
        }
        let at_once = self.made_at_once().max(kept);
        let mut is_shaded = false;
        self.view.interpolate_from((x, y), self.round, at_once, |known, out| {
            let (near, far) = (ends.tree(known, near), ends.tree(known, far));
            match ends.axis {
                Axis::X(_) => interpolate_tree(near, far, s, out),
                Axis::Y(_) if kept > 1 => interpolate_tree(near, far, s, out),
                // No further sample is interpolated from this one, so its primary hit is enough.
                Axis::Y(_) => {
                    let alone = |tree: &[Node]| Node { reflect: None, refract: None, len: 1, ..tree[0] };
                    interpolate_tree(&[alone(near)], &[alone(far)], s, out);
                }
            }
            if let (Some(shading), Some(node)) = (shading, out.first_mut()) {
                is_shaded = shading.shade(&near[0], &far[0], s, eye, node);
            }
        });
        if is_shaded {
            self.view.shaded(self.at(i), self.round);
        }
    }

    /// How many hits of an interpolated sample have attributes at once: all that steps to come may read.
    fn made_at_once(&self) -> u32 {
        let is_lazy = self.rules.rules.sampling.attributes == Attributes::Lazy;
        match self.axis {
            // The last of its R-rows is kept for the tile below.
            Axis::X(y) if is_lazy && self.view.is_last_row(y) => 1,
            Axis::X(_) if !is_lazy => u32::MAX,
            // Of what the Y step interpolates corrections read some, and note it.
            _ => u32::from(self.rules.rules.shading.is_some()),
        }
    }

    /// The first `hits` hits of sample `i` of the line are read to decide sample `at`.
    fn read(&mut self, i: u32, at: (u32, u32), hits: u32) {
        let ends = self.ends();
        match (ends.far, self.at(i)) {
            (Some(_), (x, _)) if i == ends.end => {
                let hits = hits.min(self.tree(i).len() as u32);
                if self.is_far_interpolated {
                    self.view.read_hits_below(at, self.round, x, hits);
                }
            }
            (_, read) => {
                let hits = hits.min(self.tree(i).len() as u32);
                self.view.read_hits(at, self.round, read, hits);
            }
        }
    }

    /// Traces sample `i` between `a` and `b`: whole, or what of it cannot be interpolated.
    fn trace(&mut self, a: u32, b: u32, i: u32) {
        let (x, y) = self.at(i);
        if !self.rules.rules.sampling.secondary {
            return self.rules.trace(self.view, (x, y), SampleState::Traced, self.round);
        }
        let (swap, s) = nearer(i - a, b - a);
        let (near, far) = if swap { (b, a) } else { (a, b) };
        // What is below both hits may be read anywhere.
        [near, far].into_iter().for_each(|end| self.read(end, (x, y), u32::MAX));
        let (eye, mut looked) = (Eye::new(self.rules.looks_at(x, y)), (None, 0));
        let (tests, gap, mut made) = (&self.rules.tests, b - a, Compared::default());
        let (stand_in, ends) = (self.rules.rules.sampling.stand_in, self.ends());
        self.view.rebuild(x, y, self.round, |tracer, known, out| {
            let (near, far) = (ends.tree(known, near), ends.tree(known, far));
            let (totals, compared) = ((near[0].colour, far[0].colour), Compared::default());
            let mut rebuild = Rebuild { tests, stand_in, tracer, out, gap, s, totals, compared, interpolated: 0, eye };
            rebuild.build(near, far);
            made = rebuild.compared;
            looked = (rebuild.eye.place, rebuild.eye.hits);
            rebuild.interpolated
        });
        self.view.compared((x, y), self.round, made);
        self.view.looked_back((x, y), self.round, looked.0, looked.1);
    }

    /// The colour that sample `i` would have by interpolation.
    fn expected_colour(&self, a: u32, b: u32, i: u32) -> Vec3 {
        let (swap, s) = nearer(i - a, b - a);
        let (near, far) = if swap { (b, a) } else { (a, b) };
        mix(self.tree(near)[0].colour, self.tree(far)[0].colour, s)
    }

    /// How far `colour` is off the colour of sample `i`; infinite if that was not traced whole.
    fn miss(&self, i: u32, colour: Vec3) -> f64 {
        let (x, y) = self.at(i);
        if !self.view.is_seen(x, y) {
            return f64::INFINITY;
        }
        let both = (colour, self.tree(i)[0].colour);
        super::similarity::difference(both, both)
    }

    /// The tree of sample `i` of the line.
    fn tree(&self, i: u32) -> &[Node] {
        let ends = self.ends();
        match ends.far {
            Some(far) if i == ends.end => far,
            _ => {
                let (x, y) = self.at(i);
                self.view.tree(x, y)
            }
        }
    }

    fn at(&self, i: u32) -> (u32, u32) {
        self.axis.at(i)
    }

    fn ends(&self) -> Ends<'a> {
        let rect = self.view.rect();
        let end = match self.axis {
            Axis::X(_) => rect.x + rect.width,
            Axis::Y(_) => rect.y + rect.height,
        };
        Ends { axis: self.axis, far: self.far, end }
    }
}

/// Where the samples of a line stand.
#[derive(Clone, Copy)]
struct Ends<'a> {
    axis: Axis,
    /// The sample past the end of the tile, and its place in the line.
    far: Option<&'a [Node]>,
    end: u32,
}

impl<'a> Ends<'a> {
    /// The tree of sample `i` of the line, if that is known.
    fn tree<'b>(&self, known: KnownTrees<'b>, i: u32) -> &'b [Node]
    where
        'a: 'b,
    {
        match self.far {
            Some(far) if i == self.end => far,
            _ => {
                let (x, y) = self.axis.at(i);
                known.tree(x, y)
            }
        }
    }
}

impl Axis {
    /// Column and row of sample `i` of the line.
    fn at(self, i: u32) -> (u32, u32) {
        match self {
            Self::X(y) => (i, y),
            Self::Y(x) => (x, i),
        }
    }
}
