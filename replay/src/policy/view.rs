//! What a policy may see: the hits it has traced, and what was interpolated from them.
//!
//! The recorded samples of a tile are private to this module. The only ways to one are [`TileView::trace`] and [`Tracer`],
//! which mark the hits as traced and count their rays, so a policy cannot use a value that hardware would not have had.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays;
use rayreel_formats::scene::{Camera, Rect};
use rayreel_formats::tile::{Hit, RayNode, Shadows, Tile, composite};

use super::tree::{Forest, Node, finish};
use crate::error::{ReplayError, Result};
use crate::frame::counts::RayCounts;
use crate::source::TileSource;

/// Where a closest-hit ray met a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Object number.
    pub object: u32,
    /// What the shadow rays of the hit found.
    pub shadows: Shadows,
    /// Unit shading normal as stored, not turned towards the ray.
    pub normal: Vec3,
    /// Hit point of a primary ray, scene units; zero for other rays, whose positions no test looks at.
    pub position: Vec3,
    /// Length of the ray, scene units.
    pub t: f32,
}

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

/// What was done in one wave beside tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WaveCounts {
    /// Similarity tests: pairs of hits that were compared.
    pub tests: u32,
    /// Hits and whole subtrees that were interpolated; one for a sample of which nothing was traced.
    pub interpolated: u32,
}

/// What was recorded of a tile, as trees: sample `i` has the hits `first[i]..first[i + 1]`.
#[derive(Clone, Debug, Default)]
struct Recorded {
    first: Vec<u32>,
    nodes: Vec<Node>,
    /// Per hit the rays by kind.
    rays: Vec<RayCounts>,
}

impl Recorded {
    fn range(&self, sample: usize) -> std::ops::Range<usize> {
        self.first[sample] as usize..self.first[sample + 1] as usize
    }
}

/// A tile in the hands of a policy. Coordinates are those of the frame's sample grid.
#[derive(Clone, Debug)]
pub struct TileView {
    index: u32,
    rect: Rect,
    /// Trees have all their hits; else each sample is one.
    deep: bool,
    recorded: Recorded,
    /// Per recorded hit whether its rays were traced.
    traced: Vec<bool>,
    known: Forest,
    /// State and wave of the samples that are known.
    states: Vec<Option<(SampleState, u8)>>,
    /// Per wave what was done beside tracing.
    waves: Vec<WaveCounts>,
    /// The part of `waves` on the first row: the tile above does it again if it does not share (`Apron::Retrace`).
    first_row: Vec<WaveCounts>,
}

/// The recorded ray tree of one sample, of which hits may be traced one by one.
#[derive(Debug)]
pub struct Tracer<'a> {
    nodes: &'a [Node],
    traced: &'a mut [bool],
}

impl Tracer<'_> {
    /// Traces hit `node` and its shadow rays.
    pub fn hit(&mut self, node: usize) -> Node {
        self.traced[node] = true;
        self.nodes[node]
    }

    /// Traces hit `node` and everything below it.
    pub fn subtree(&mut self, node: usize) -> &[Node] {
        let range = node..node + self.nodes[node].len as usize;
        self.traced[range.clone()].fill(true);
        &self.nodes[range]
    }

    /// Whether recorded rays stand for the children of `like` below hit `node`: the recorded sample branches in the same
    /// way. This looks at the shape of the record only: without a stand-in a policy has to trace more.
    pub fn stands_in(&self, node: usize, like: &Node) -> bool {
        self.nodes[node].branches_as(like)
    }

    /// Hits of the subtree at `node`.
    pub fn len(&self, node: usize) -> usize {
        self.nodes[node].len as usize
    }
}

impl TileView {
    /// A view of a recorded tile in which nothing is traced yet. With `deep` it shows whole ray trees, else primary hits
    /// with the colour of all.
    ///
    /// # Errors
    /// When the tile's columns do not fit its rectangle.
    pub fn new<S: TileSource + ?Sized>(
        source: &S,
        camera: &Camera,
        (frame, index): (u32, u32),
        tile: &Tile,
        deep: bool,
    ) -> Result<Self> {
        let rect = source.meta().tile_rect(index);
        check(tile, rect).map_err(|detail| ReplayError::BadTile { frame, tile: index, detail })?;
        let recorded = if deep { record_trees(source, camera, tile, rect) } else { record(source, camera, tile, rect) };
        let (traced, states) = (vec![false; recorded.nodes.len()], vec![None; rect.len()]);
        let (waves, first_row) = (Vec::new(), Vec::new());
        Ok(Self { index, rect, deep, recorded, traced, known: Forest::new(rect.len()), states, waves, first_row })
    }

    /// Tile number in the frame.
    pub fn index(&self) -> u32 {
        self.index
    }

    /// The samples of the tile.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Traces sample (`x`, `y`) whole in wave `wave`.
    ///
    /// # Panics
    /// When the sample is outside the tile, or known already: a policy never pays twice.
    pub fn trace(&mut self, x: u32, y: u32, state: SampleState, wave: u8) {
        let i = self.decide(x, y, state, wave);
        let range = self.recorded.range(i);
        self.traced[range.clone()].fill(true);
        self.known.set(i, &self.recorded.nodes[range]);
    }

    /// Traces a sample that was interpolated after all.
    ///
    /// # Panics
    /// When the sample is outside the tile, or not interpolated.
    pub fn correct(&mut self, x: u32, y: u32, wave: u8) {
        let i = self.offset(x, y);
        assert!(
            matches!(self.states[i], Some((SampleState::Interpolated, _))),
            "only interpolated samples are corrected"
        );
        self.states[i] = None;
        self.trace(x, y, SampleState::Traced, wave);
    }

    /// Gives sample (`x`, `y`) an interpolated tree.
    ///
    /// # Panics
    /// As [`TileView::trace`].
    pub fn interpolate(&mut self, x: u32, y: u32, tree: &[Node], wave: u8) {
        let i = self.decide(x, y, SampleState::Interpolated, wave);
        self.known.set(i, tree);
        self.count(y, wave, |counts| counts.interpolated += 1);
    }

    /// Builds sample (`x`, `y`) from hits that are traced and hits that are interpolated: `build` appends its tree, hit by
    /// hit, and gives the number of interpolated hits.
    ///
    /// # Panics
    /// As [`TileView::trace`].
    pub fn rebuild(&mut self, x: u32, y: u32, wave: u8, build: impl FnOnce(&mut Tracer<'_>, &mut Vec<Node>) -> u32) {
        let i = self.offset(x, y);
        let range = self.recorded.range(i);
        let mut tree = Vec::with_capacity(range.len());
        let (nodes, traced) = (&self.recorded.nodes[range.clone()], &mut self.traced[range.clone()]);
        let interpolated = build(&mut Tracer { nodes, traced }, &mut tree);
        let traced = self.traced[range.clone()].iter().filter(|t| **t).count();
        let state = match (traced, interpolated) {
            (0, _) => SampleState::Interpolated,
            (_, 0) => SampleState::Traced,
            _ => SampleState::Partial,
        };
        let i = self.decide(x, y, state, wave);
        self.known.set(i, &tree);
        self.count(y, wave, |counts| counts.interpolated += interpolated);
    }

    /// Notes `tests` similarity tests in wave `wave` that decide about sample (`x`, `y`) and others.
    pub fn tested(&mut self, (_, y): (u32, u32), wave: u8, tests: u32) {
        self.count(y, wave, |counts| counts.tests += tests);
    }

    /// Per wave what was done beside tracing; waves that are not there did nothing.
    pub fn waves(&self) -> &[WaveCounts] {
        &self.waves
    }

    /// The part of [`TileView::waves`] on the tile's first row.
    pub fn first_row_waves(&self) -> &[WaveCounts] {
        &self.first_row
    }

    /// The tree of a sample that was traced or interpolated.
    ///
    /// # Panics
    /// When the sample is outside the tile, or not known yet.
    pub fn tree(&self, x: u32, y: u32) -> &[Node] {
        let i = self.offset(x, y);
        assert!(self.states[i].is_some(), "a policy read sample ({x}, {y}) before it was known");
        self.known.tree(i)
    }

    /// State of a sample and the wave that brought it; `None` while it is not known.
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
        let rays = range.filter(|&node| self.traced[node]).map(|node| self.recorded.rays[node]);
        rays.fold(None, |sum, rays| Some(sum.unwrap_or_default() + rays))
    }

    /// Whether the rays of the `node`-th recorded hit of a sample were traced.
    pub(crate) fn traces_hit(&self, sample: usize, node: usize) -> bool {
        self.traced[self.recorded.range(sample).start + if self.deep { node } else { 0 }]
    }

    /// Hits that a tile buffer holds beyond one a sample.
    pub(crate) fn secondary_hits(&self) -> u32 {
        self.known.secondary_hits()
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

    fn count(&mut self, y: u32, wave: u8, add: impl Fn(&mut WaveCounts)) {
        let wave = usize::from(wave);
        let add_to = |waves: &mut Vec<WaveCounts>| {
            if waves.len() <= wave {
                waves.resize(wave + 1, WaveCounts::default());
            }
            add(&mut waves[wave]);
        };
        add_to(&mut self.waves);
        if y == self.rect.y {
            add_to(&mut self.first_row);
        }
    }

    /// Gives a sample its state; its place in the tile.
    fn decide(&mut self, x: u32, y: u32, state: SampleState, wave: u8) -> usize {
        let i = self.offset(x, y);
        assert!(self.states[i].is_none(), "a policy decided sample ({x}, {y}) twice");
        self.states[i] = Some((state, wave));
        i
    }

    fn offset(&self, x: u32, y: u32) -> usize {
        let Rect { x: left, y: top, width, height } = self.rect;
        let inside = (left..left + width).contains(&x) && (top..top + height).contains(&y);
        assert!(inside, "sample ({x}, {y}) is outside tile {}", self.index);
        (y - top) as usize * width as usize + (x - left) as usize
    }
}

/// What is wrong with the tile's columns, if anything.
fn check(tile: &Tile, rect: Rect) -> Result<(), String> {
    let nodes = tile.tree.nodes.len();
    if tile.rect != rect || tile.tree.samples() != rect.len() {
        return Err(format!("{} samples where {} belong", tile.tree.samples(), rect.len()));
    }
    if tile.hits.len() != nodes || tile.radiance.len() != nodes {
        let (hits, radiance) = (tile.hits.len(), tile.radiance.len());
        return Err(format!("{nodes} rays, but {hits} hits and {radiance} radiance entries"));
    }
    let first = &tile.tree.first;
    if first.windows(2).any(|w| w[0] >= w[1]) || first.last().is_none_or(|&n| n as usize != nodes) {
        return Err("a sample has no primary ray".into());
    }
    (0..rect.len()).try_for_each(|sample| check_shape(&tile.tree.nodes[tile.tree.sample(sample)]))
}

/// Checks that the children that hits announce are there, each once, and nothing else.
fn check_shape(nodes: &[RayNode]) -> Result<(), String> {
    let mut open = 1u32;
    for (i, node) in nodes.iter().enumerate() {
        if open == 0 {
            return Err(format!("a ray tree of {} hits ends after {i}", nodes.len()));
        }
        open += u32::from(node.reflect) + u32::from(node.refract);
        open -= 1;
    }
    if open == 0 { Ok(()) } else { Err(format!("a ray tree of {} hits lacks {open}", nodes.len())) }
}

/// Each sample as one hit with the colour and the rays of all.
fn record<S: TileSource + ?Sized>(source: &S, camera: &Camera, tile: &Tile, rect: Rect) -> Recorded {
    let mut recorded = Recorded { first: vec![0], ..Recorded::default() };
    for sample in 0..rect.len() {
        let range = tile.tree.sample(sample);
        let nodes = &tile.tree.nodes[range.clone()];
        let (x, y) = place(rect, sample);
        let surface = nodes[0].hit.then(|| primary(source, camera, &nodes[0], &tile.hits[range.start], (x, y)));
        let colour = composite(nodes, &tile.radiance[range.clone()]);
        let rays = RayCounts::of(nodes);
        let total = rays.total() as u32;
        let (local, reflect, refract) = (tile.radiance[range.start].local.to_vec3(), None, None);
        recorded.nodes.push(Node { surface, local, colour, reflect, refract, own_rays: total, rays: total, len: 1 });
        recorded.rays.push(rays);
        recorded.first.push(recorded.nodes.len() as u32);
    }
    recorded
}

/// Each sample with all its hits.
fn record_trees<S: TileSource + ?Sized>(source: &S, camera: &Camera, tile: &Tile, rect: Rect) -> Recorded {
    let black = Vec3::ZERO;
    let mut nodes = Vec::with_capacity(tile.tree.nodes.len());
    for sample in 0..rect.len() {
        for i in tile.tree.sample(sample) {
            let (node, hit, radiance) = (&tile.tree.nodes[i], &tile.hits[i], &tile.radiance[i]);
            let surface = match (node.hit, i == tile.tree.first[sample] as usize) {
                (false, _) => None,
                (true, true) => Some(primary(source, camera, node, hit, place(rect, sample))),
                (true, false) => Some(secondary(source, node, hit)),
            };
            let (reflect, refract) = (radiance.reflect.to_vec3(), radiance.refract.to_vec3());
            nodes.push(Node {
                surface,
                local: radiance.local.to_vec3(),
                colour: black,
                reflect: node.reflect.then_some(reflect),
                refract: node.refract.then_some(refract),
                own_rays: 1 + node.shadows.count(),
                rays: 0,
                len: 1,
            });
        }
        // Children stand behind their parents: from the end, a hit finds its subtrees finished.
        let range = tile.tree.sample(sample);
        for i in range.clone().rev() {
            finish(&mut nodes[i..range.end]);
        }
    }
    let rays = tile.tree.nodes.iter().map(|node| RayCounts::of(std::slice::from_ref(node))).collect();
    Recorded { first: tile.tree.first.clone(), nodes, rays }
}

fn place(rect: Rect, sample: usize) -> (u32, u32) {
    (rect.x + sample as u32 % rect.width, rect.y + sample as u32 / rect.width)
}

fn primary<S: TileSource + ?Sized>(
    source: &S,
    camera: &Camera,
    node: &RayNode,
    hit: &Hit,
    (x, y): (u32, u32),
) -> SurfacePoint {
    let ray = rays::primary(camera, x, y);
    SurfacePoint { position: ray.origin + ray.direction * hit.t, ..secondary(source, node, hit) }
}

fn secondary<S: TileSource + ?Sized>(source: &S, node: &RayNode, hit: &Hit) -> SurfacePoint {
    SurfacePoint {
        object: source.object_of(hit.triangle),
        shadows: node.shadows,
        normal: hit.normal.decode(),
        position: Vec3::ZERO,
        t: hit.t,
    }
}
