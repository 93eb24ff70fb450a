//! A row or column of a tile between known samples: decided from both ends, gap by gap.

use rayreel_formats::math::Vec3;

use super::rules::TileRules;
use crate::policy::interpolate::{interpolate_tree, mix, nearer};
use crate::policy::reuse::{Eye, Rebuild};
use crate::policy::similarity::{Compared, difference};
use crate::policy::tree::Node;
use crate::policy::view::{KnownTrees, SampleState, TileView};
use crate::policy::{Attributes, Refine};

/// The direction of a line of samples and its fixed coordinate.
#[derive(Clone, Copy)]
pub(super) enum Axis {
    X(u32),
    Y(u32),
}

/// A row or column of a tile between known samples.
pub(super) struct Line<'a> {
    pub rules: &'a TileRules<'a>,
    pub view: &'a mut TileView,
    pub axis: Axis,
    /// The round of the first test.
    pub round: u8,
    /// The sample past the end of the tile.
    pub far: Option<&'a [Node]>,
    /// That sample was interpolated.
    pub is_far_interpolated: bool,
}

impl<'a> Line<'a> {
    /// Decides the samples between two known ones. One of the two may have been traced just now, as the middle of a wider gap:
    /// `foreseen` is how far its colour was off the one that interpolation would have given it, else infinite.
    pub fn decide(&mut self, a: u32, b: u32, foreseen: f64) {
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
        let mut eye = Eye::new(self.rules.look(x, y));
        let (tests, gap, mut made) = (&self.rules.tests, b - a, Compared::default());
        let (stand_in, ends) = (self.rules.rules.sampling.stand_in, self.ends());
        self.view.rebuild(x, y, self.round, |tracer, known, out| {
            let (near, far) = (ends.tree(known, near), ends.tree(known, far));
            let (totals, compared) = ((near[0].colour, far[0].colour), Compared::default());
            let mut rebuild =
                Rebuild { tests, stand_in, tracer, out, gap, s, totals, compared, interpolated: 0, eye: &mut eye };
            rebuild.build(near, far);
            made = rebuild.compared;
            rebuild.interpolated
        });
        self.view.compared((x, y), self.round, made);
        self.view.looked_back((x, y), self.round, &eye);
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
        difference(both, both)
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
