//! What a policy may see: the samples it has traced, and those interpolated from them.
//!
//! The recorded samples of a tile are private to this module. The only way to one is [`TileView::trace`], which marks the
//! sample as traced and counts its rays, so a policy cannot use a value that hardware would not have had.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays;
use rayreel_formats::scene::{Camera, Rect};
use rayreel_formats::tile::{Hit, RayNode, Shadows, Tile, composite};

use crate::error::{ReplayError, Result};
use crate::frame::counts::RayCounts;
use crate::source::TileSource;

/// A sample as the tile buffer holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Linear RGB.
    pub colour: Vec3,
    /// The primary hit; `None` for the sky.
    pub surface: Option<SurfacePoint>,
}

impl Point {
    const BLACK: Self = Self { colour: Vec3::ZERO, surface: None };
}

/// The primary hit of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Object number.
    pub object: u32,
    /// What the shadow rays of the hit found.
    pub shadows: Shadows,
    /// Unit shading normal as stored, not turned towards the ray.
    pub normal: Vec3,
    /// Hit point, scene units.
    pub position: Vec3,
    /// Length of the primary ray, scene units.
    pub t: f32,
}

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleState {
    /// An R-sample: traced before any test.
    Reference,
    /// An I-sample that was traced.
    Traced,
    /// An I-sample that was interpolated.
    Interpolated,
}

/// What was done in one wave beside tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WaveCounts {
    /// Similarity tests.
    pub tests: u32,
    /// Samples that were interpolated.
    pub interpolated: u32,
}

/// One recorded sample.
#[derive(Clone, Copy, Debug)]
struct Recorded {
    point: Point,
    rays: RayCounts,
}

/// A tile in the hands of a policy. Coordinates are those of the frame's sample grid.
#[derive(Clone, Debug)]
pub struct TileView {
    index: u32,
    rect: Rect,
    recorded: Vec<Recorded>,
    points: Vec<Point>,
    /// State and wave of the samples that are known.
    known: Vec<Option<(SampleState, u8)>>,
    /// Per wave what was done beside tracing.
    waves: Vec<WaveCounts>,
    /// The part of `waves` on the first row: the tile above does it again if it does not share (`Apron::Retrace`).
    first_row: Vec<WaveCounts>,
}

impl TileView {
    /// A view of a recorded tile in which nothing is traced yet.
    ///
    /// # Errors
    /// When the tile's columns do not fit its rectangle.
    pub fn new<S: TileSource + ?Sized>(
        source: &S,
        camera: &Camera,
        (frame, index): (u32, u32),
        tile: &Tile,
    ) -> Result<Self> {
        let rect = source.meta().tile_rect(index);
        check(tile, rect).map_err(|detail| ReplayError::BadTile { frame, tile: index, detail })?;
        let recorded: Vec<_> = (0..rect.len()).map(|i| record(source, camera, tile, rect, i)).collect();
        let (points, known) = (vec![Point::BLACK; rect.len()], vec![None; rect.len()]);
        Ok(Self { index, rect, recorded, points, known, waves: Vec::new(), first_row: Vec::new() })
    }

    /// Tile number in the frame.
    pub fn index(&self) -> u32 {
        self.index
    }

    /// The samples of the tile.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Traces sample (`x`, `y`) in wave `wave` and returns what the rays brought.
    ///
    /// # Panics
    /// When the sample is outside the tile, or known already: a policy never pays twice.
    pub fn trace(&mut self, x: u32, y: u32, state: SampleState, wave: u8) -> Point {
        let point = self.recorded[self.offset(x, y)].point;
        self.put(x, y, point, state, wave);
        point
    }

    /// Gives sample (`x`, `y`) an interpolated value.
    ///
    /// # Panics
    /// As [`TileView::trace`].
    pub fn interpolate(&mut self, x: u32, y: u32, point: Point, wave: u8) {
        self.put(x, y, point, SampleState::Interpolated, wave);
        self.count(y, wave, |counts| counts.interpolated += 1);
    }

    /// Notes a similarity test in wave `wave` that decides about sample (`x`, `y`) and others.
    pub fn tested(&mut self, (_, y): (u32, u32), wave: u8) {
        self.count(y, wave, |counts| counts.tests += 1);
    }

    /// Per wave what was done beside tracing; waves that are not there did nothing.
    pub fn waves(&self) -> &[WaveCounts] {
        &self.waves
    }

    /// The part of [`TileView::waves`] on the tile's first row.
    pub fn first_row_waves(&self) -> &[WaveCounts] {
        &self.first_row
    }

    /// The value of a sample that was traced or interpolated.
    ///
    /// # Panics
    /// When the sample is outside the tile, or not known yet.
    pub fn point(&self, x: u32, y: u32) -> Point {
        let i = self.offset(x, y);
        assert!(self.known[i].is_some(), "a policy read sample ({x}, {y}) before it was known");
        self.points[i]
    }

    /// State of a sample and the wave that brought it; `None` while it is not known.
    ///
    /// # Panics
    /// When the sample is outside the tile.
    pub fn state(&self, x: u32, y: u32) -> Option<(SampleState, u8)> {
        self.known[self.offset(x, y)]
    }

    /// The rays that were traced for a sample; `None` if it was not traced.
    ///
    /// # Panics
    /// When the sample is outside the tile.
    pub fn traced_rays(&self, x: u32, y: u32) -> Option<RayCounts> {
        let i = self.offset(x, y);
        matches!(self.known[i], Some((SampleState::Reference | SampleState::Traced, _))).then(|| self.recorded[i].rays)
    }

    /// The rays of all recorded samples. Not for policies: it is what tracing everything costs.
    pub(crate) fn recorded_rays(&self) -> RayCounts {
        self.recorded.iter().map(|r| r.rays).sum()
    }

    /// The recorded colours of row `y`. Not for policies: it is the picture that they are compared with.
    pub(crate) fn recorded_row(&self, y: u32) -> impl Iterator<Item = Vec3> {
        let start = self.offset(self.rect.x, y);
        self.recorded[start..start + self.rect.width as usize].iter().map(|r| r.point.colour)
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

    fn put(&mut self, x: u32, y: u32, point: Point, state: SampleState, wave: u8) {
        let i = self.offset(x, y);
        assert!(self.known[i].is_none(), "a policy decided sample ({x}, {y}) twice");
        self.points[i] = point;
        self.known[i] = Some((state, wave));
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
    Ok(())
}

fn record<S: TileSource + ?Sized>(source: &S, camera: &Camera, tile: &Tile, rect: Rect, sample: usize) -> Recorded {
    let range = tile.tree.sample(sample);
    let nodes = &tile.tree.nodes[range.clone()];
    let x = rect.x + sample as u32 % rect.width;
    let y = rect.y + sample as u32 / rect.width;
    let surface = nodes[0].hit.then(|| surface(source, camera, &nodes[0], &tile.hits[range.start], (x, y)));
    let colour = composite(nodes, &tile.radiance[range]);
    Recorded { point: Point { colour, surface }, rays: RayCounts::of(nodes) }
}

fn surface<S: TileSource + ?Sized>(
    source: &S,
    camera: &Camera,
    node: &RayNode,
    hit: &Hit,
    (x, y): (u32, u32),
) -> SurfacePoint {
    let ray = rays::primary(camera, x, y);
    SurfacePoint {
        object: source.object_of(hit.triangle),
        shadows: node.shadows,
        normal: hit.normal.decode(),
        position: ray.origin + ray.direction * hit.t,
        t: hit.t,
    }
}
