//! What a policy may see: the hits it has traced, and what was interpolated from them.
//!
//! The recorded samples of a tile are private to this module. The only ways to one are [`TileView::trace`] and [`HitTracer`],
//! which mark the hits as traced and count their rays, so a policy cannot use a value that hardware would not have had.

mod attributes;
mod known;
mod notes;
mod recorded;
mod strips;
mod tracer;

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Camera, Rect};
use rayreel_formats::tile::Tile;

use super::history::LightChecks;
use super::tree::Node;
use crate::counts::RayCounts;
use crate::error::{ReplayError, Result};
use crate::image::psnr::SquaredError;
use crate::source::TileSource;
use attributes::MadeAttributes;
use known::Known;
pub use known::KnownTrees;
use recorded::Recorded;
pub use strips::{CLOSERS, Closer, RoundCounts};
use strips::{RoundsByCloser, Strips};
pub use tracer::HitTracer;
pub(crate) use tracer::Traced;

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleState {
    /// An R-sample: traced before any test.
    Reference,
    /// An I-sample that was traced.
    Traced,
    /// An I-sample of which some rays were traced and some hits interpolated.
    Partial,
    /// An I-sample that was interpolated.
    Interpolated,
}

/// A tile in the hands of a policy. Coordinates are those of the frame's sample grid.
pub struct TileView {
    index: u32,
    rect: Rect,
    /// Trees have all their hits; else each sample is one.
    deep: bool,
    recorded: Recorded,
    /// Per recorded hit which of its rays were traced.
    traced: Vec<Traced>,
    known: Known,
    /// Memory for the tree that is being made.
    made: Vec<Node>,
    /// What there is of interpolated samples beside their colours.
    attributes: MadeAttributes,
    /// State and round of the samples that are known.
    states: Vec<Option<(SampleState, u8)>>,
    /// Which samples wait for neighbours.
    strips: Strips,
    /// Per round what was done beside tracing, by the tile that does it.
    rounds: RoundsByCloser,
    /// The last round of the X step.
    last_x_round: u8,
    /// The part of `rounds` on the first row: the tile above does it again if it does not share (`Apron::Retrace`).
    first_row: Vec<RoundCounts>,
    /// What audits of the tile found.
    audited: SquaredError,
    light_checks: LightChecks,
}

impl TileView {
    /// A view of a recorded tile in which nothing is traced yet. Policies cannot make one: who holds a tile has seen it. With `deep` it shows whole ray trees, else primary hits
    /// with the colour of all.
    ///
    /// # Errors
    /// When the tile's columns do not fit its rectangle.
    pub(crate) fn new<S: TileSource + ?Sized>(
        source: &S,
        camera: &Camera,
        (frame, index): (u32, u32),
        tile: &Tile,
        deep: bool,
    ) -> Result<Self> {
        let rect = source.meta().tile_rect(index);
        let recorded = Recorded::new(source, camera, tile, rect, deep).map_err(|detail| ReplayError::Corrupt {
            ray: None,
            frame,
            tile: index,
            detail,
        })?;
        let (traced, states) = (vec![Traced::No; recorded.nodes.len()], vec![None; rect.len()]);
        let (known, made) = (Known::new(rect.len()), Vec::new());
        Ok(Self {
            index,
            rect,
            deep,
            recorded,
            traced,
            known,
            made,
            attributes: MadeAttributes::default(),
            states,
            strips: Strips::default(),
            rounds: RoundsByCloser::default(),
            last_x_round: 0,
            first_row: Vec::new(),
            audited: SquaredError::default(),
            light_checks: LightChecks::default(),
        })
    }

    /// Tile number in the frame.
    pub fn index(&self) -> u32 {
        self.index
    }

    /// The samples of the tile.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Column and row of all samples of the tile, row by row.
    pub fn samples(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let Rect { x, y, width, height } = self.rect;
        (y..y + height).flat_map(move |v| (x..x + width).map(move |u| (u, v)))
    }

    /// Traces sample (`x`, `y`) whole in round `round`: as an R-sample, or as an I-sample that is traced.
    ///
    /// # Panics
    /// When the sample is outside the tile, or known already: a policy never pays twice. When `state` is neither of the two.
    pub fn trace(&mut self, x: u32, y: u32, state: SampleState, round: u8) {
        assert!(matches!(state, SampleState::Reference | SampleState::Traced), "a traced sample cannot be {state:?}");
        let i = self.decide(x, y, state, round);
        let range = self.recorded.range(i);
        self.traced[range.clone()].fill(Traced::WHOLE);
        self.known.trace(i, range);
    }

    /// Traces a sample that was interpolated after all.
    ///
    /// # Panics
    /// When the sample is outside the tile, or not interpolated.
    pub fn correct(&mut self, x: u32, y: u32, round: u8) {
        let i = self.offset(x, y);
        assert!(
            matches!(self.states[i], Some((SampleState::Interpolated, _))),
            "only interpolated samples are corrected"
        );
        self.states[i] = None;
        self.trace(x, y, SampleState::Traced, round);
    }

    /// Gives sample (`x`, `y`) an interpolated tree.
    ///
    /// # Panics
    /// As [`TileView::trace`]; when the tree is empty: it has its primary hit, or a miss, at least.
    pub fn interpolate(&mut self, x: u32, y: u32, tree: &[Node], round: u8) {
        self.interpolate_made((x, y), tree, round, tree.len() as u32);
    }

    /// As [`TileView::interpolate`]; so many of its hits have attributes at once.
    fn interpolate_made(&mut self, (x, y): (u32, u32), tree: &[Node], round: u8, made: u32) {
        let i = self.decide(x, y, SampleState::Interpolated, round);
        self.make_known(i, (x, y), tree);
        self.count((x, y), round, |counts| {
            counts.interpolated += 1;
            counts.attributes += made;
        });
        self.attributes.make(i, made);
    }

    /// Keeps the tree of the `i`-th sample, (`x`, `y`).
    fn make_known(&mut self, i: usize, (x, y): (u32, u32), tree: &[Node]) {
        assert!(!tree.is_empty(), "a policy gave sample ({x}, {y}) an empty tree, without even a primary hit");
        self.known.make(i, tree);
    }

    /// As [`TileView::interpolate`] with a tree that `build` appends, from what is known of the tile; `at_once` of its hits have
    /// attributes at once.
    pub(crate) fn interpolate_from(
        &mut self,
        (x, y): (u32, u32),
        round: u8,
        at_once: u32,
        build: impl FnOnce(KnownTrees<'_>, &mut Vec<Node>),
    ) {
        let mut tree = std::mem::take(&mut self.made);
        tree.clear();
        build(self.trees(), &mut tree);
        self.interpolate_made((x, y), &tree, round, at_once.min(tree.len() as u32));
        self.made = tree;
    }

    /// Builds sample (`x`, `y`) from hits that are traced and hits that are interpolated: `build` appends its tree, hit by
    /// hit, and gives the number of interpolated hits. It may read what is known of the tile.
    ///
    /// # Panics
    /// As [`TileView::interpolate`].
    pub fn rebuild(
        &mut self,
        x: u32,
        y: u32,
        round: u8,
        build: impl FnOnce(&mut HitTracer<'_>, KnownTrees<'_>, &mut Vec<Node>) -> u32,
    ) {
        self.build((x, y), round, false, build);
    }

    /// As [`TileView::rebuild`]; an R-sample stays one.
    pub(crate) fn build(
        &mut self,
        (x, y): (u32, u32),
        round: u8,
        is_reference: bool,
        build: impl FnOnce(&mut HitTracer<'_>, KnownTrees<'_>, &mut Vec<Node>) -> u32,
    ) {
        let i = self.offset(x, y);
        let range = self.recorded.range(i);
        let mut tree = std::mem::take(&mut self.made);
        tree.clear();
        let known = KnownTrees { rect: self.rect, known: &self.known, recorded: &self.recorded };
        let (nodes, traced) = (&self.recorded.nodes[range.clone()], &mut self.traced[range.clone()]);
        let interpolated = build(&mut HitTracer { nodes, traced }, known, &mut tree);
        let of_sample = &self.traced[range.clone()];
        let traced = of_sample.iter().filter(|traced| **traced != Traced::No).count();
        let state = match (traced, interpolated) {
            _ if is_reference => SampleState::Reference,
            (0, _) => SampleState::Interpolated,
            (_, 0) if of_sample.iter().all(|traced| *traced == Traced::WHOLE) => SampleState::Traced,
            _ => SampleState::Partial,
        };
        let i = self.decide(x, y, state, round);
        self.make_known(i, (x, y), &tree);
        let made = tree.len().saturating_sub(traced) as u32;
        self.attributes.make(i, tree.len() as u32);
        self.made = tree;
        self.count((x, y), round, |counts| {
            counts.interpolated += interpolated;
            counts.attributes += made;
        });
    }

    /// Whether an I-sample was traced, all its hits by rays: no part of it is interpolated.
    pub(crate) fn is_seen(&self, x: u32, y: u32) -> bool {
        let i = self.offset(x, y);
        let is_traced = matches!(self.states[i], Some((SampleState::Traced | SampleState::Partial, _)));
        is_traced && self.traced[self.recorded.range(i)].iter().all(|traced| *traced != Traced::No)
    }

    /// Whether all rays of a sample were traced.
    pub(crate) fn is_whole(&self, x: u32, y: u32) -> bool {
        self.traced[self.recorded.range(self.offset(x, y))].iter().all(|traced| *traced == Traced::WHOLE)
    }

    /// Traces whole what was not, of a sample that is decided: it keeps its round, and an R-sample stays one.
    pub(crate) fn complete(&mut self, x: u32, y: u32) {
        let i = self.offset(x, y);
        let Some((state, round)) = self.states[i] else { return };
        let state = if state == SampleState::Reference { state } else { SampleState::Traced };
        self.states[i] = None;
        self.trace(x, y, state, round);
    }

    /// The tile that decides sample (`x`, `y`).
    pub fn closer(&self, x: u32, y: u32) -> Closer {
        if self.strips.cells && matches!(self.state(x, y), Some((SampleState::Reference, _))) {
            return Closer::Itself;
        }
        self.strips.closer(x, y)
    }

    /// Columns and rows from these on wait for the tile to the right, and for the one below; with `cells` all but the R-samples
    /// among them. To be said before anything is tested.
    pub(crate) fn wait_from(&mut self, (column, row): (u32, u32), cells: bool) {
        self.strips = Strips { column, row, cells };
    }

    /// Whether row `y` is the last before those that wait for the tile below.
    pub(crate) fn is_last_row(&self, y: u32) -> bool {
        self.strips.row.checked_sub(1) == Some(y)
    }

    /// The X step is made.
    pub(crate) fn end_step_x(&mut self) {
        self.last_x_round = self.states.iter().flatten().map(|(_, round)| *round).max().unwrap_or(0);
    }

    /// The last round of the X step.
    pub(crate) fn last_x_round(&self) -> u8 {
        self.last_x_round
    }

    /// The part of all rounds on the tile's first row.
    pub fn first_row_rounds(&self) -> &[RoundCounts] {
        &self.first_row
    }

    /// The tree of a sample that was traced or interpolated.
    ///
    /// # Panics
    /// When the sample is outside the tile, or not known yet.
    pub fn tree(&self, x: u32, y: u32) -> &[Node] {
        self.trees().tree(x, y)
    }

    /// What is known of the tile.
    fn trees(&self) -> KnownTrees<'_> {
        KnownTrees { rect: self.rect, known: &self.known, recorded: &self.recorded }
    }

    /// State of a sample and the round that brought it; `None` while it is not known.
    ///
    /// # Panics
    /// When the sample is outside the tile.
    pub fn state(&self, x: u32, y: u32) -> Option<(SampleState, u8)> {
        self.states[self.offset(x, y)]
    }

    /// The rays that were traced for a sample; `None` if none was.
    ///
    /// # Panics
    /// When the sample is outside the tile.
    pub fn traced_rays(&self, x: u32, y: u32) -> Option<RayCounts> {
        let range = self.recorded.range(self.offset(x, y));
        let rays = range.filter_map(|node| match (self.traced[node], self.recorded.rays[node]) {
            (Traced::No, _) => None,
            (Traced::But(known), all) => Some(RayCounts { shadow: all.shadow - u64::from(known.count_ones()), ..all }),
        });
        rays.fold(None, |sum, rays| Some(sum.unwrap_or_default() + rays))
    }

    /// Which rays of the `node`-th recorded hit of a sample were traced.
    pub(crate) fn traces_hit(&self, sample: usize, node: usize) -> Traced {
        self.traced[self.recorded.range(sample).start + if self.deep { node } else { 0 }]
    }

    /// Hits of the known trees beyond one a sample: what a tile buffer has to hold besides.
    pub(crate) fn secondary_hits(&self) -> u32 {
        let is_made = |i: usize| matches!(self.states[i], Some((SampleState::Interpolated, _)));
        self.known.secondary_hits(|i, hits| {
            if is_made(i) { self.attributes.of(i).map_or(hits, |made| made.min(hits)) } else { hits }
        })
    }

    /// The rays of all recorded samples. Not for policies: it is what tracing everything costs.
    pub(crate) fn recorded_rays(&self) -> RayCounts {
        self.recorded.rays.iter().copied().sum()
    }

    /// The recorded colours of row `y`. Not for policies: it is the picture that they are compared with.
    pub(crate) fn recorded_row(&self, y: u32) -> impl Iterator<Item = Vec3> {
        let start = self.offset(self.rect.x, y);
        let first = &self.recorded.first[start..start + self.rect.width as usize];
        first.iter().map(|&node| self.recorded.nodes[node as usize].colour)
    }

    /// Tree and state of the samples of row `y`, left to right; all must be known.
    #[inline]
    pub(crate) fn row(&self, y: u32, mut each: impl FnMut(&[Node], Option<(SampleState, u8)>)) {
        let (start, trees) = (self.offset(self.rect.x, y), self.trees());
        (start..start + self.rect.width as usize).for_each(|i| each(trees.of(i), self.states[i]));
    }

    fn count(&mut self, (x, y): (u32, u32), round: u8, add: impl Fn(&mut RoundCounts)) {
        let closer = self.closer(x, y);
        add(self.rounds.round_mut(closer, round));
        if y == self.rect.y {
            add(strips::round_mut(&mut self.first_row, round));
        }
    }

    /// Gives a sample its state, which it has once. Its number in the tile.
    fn decide(&mut self, x: u32, y: u32, state: SampleState, round: u8) -> usize {
        let i = self.offset(x, y);
        assert!(self.states[i].is_none(), "a policy decided sample ({x}, {y}) twice");
        self.states[i] = Some((state, round));
        i
    }

    fn offset(&self, x: u32, y: u32) -> usize {
        known::offset(self.rect, x, y)
    }
}
