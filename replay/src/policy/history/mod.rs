//! What the frame before knew of a place: a hit looks up there which lights it sees, and sends no rays to them.
//!
//! The position of a primary hit is found in the picture of the frame before. The four entries around that place are tested: those
//! of the same object that lie in its tangent plane, and are young enough, count. If they cover enough of the place, they are
//! asked hit by hit: where all have the same object and the same states of the lights, these are taken for known, and the hit is
//! shaded with them. The ray that meets the hit is traced in any case, so edges, textures and reflections are those of this
//! frame. POLICIES.md has the rules.

mod lights;
mod project;
mod trust;

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{RayClass, Shadows};
use rayreel_machine::work::history::HistorySpan;

use super::HistoryRules;
use super::scramble::scramble;
use super::similarity::within_angle;
use super::tree::{Node, SurfacePoint, children};
use super::view::TileView;
pub use lights::{KnownLights, LightChecks};
use project::Projection;
pub use trust::Trust;

/// What is kept of a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct KeptHit {
    /// The way down to it.
    path: RayClass,
    object: u32,
    normal: Vec3,
    /// Length of the ray that met it.
    t: f32,
    shadows: Shadows,
    /// Its colour alone: no part of a history, but what stands for a shading that was not recorded.
    local: Vec3,
}

/// What is kept of a sample.
#[derive(Clone, Copy, Debug)]
struct Entry {
    position: Vec3,
    /// Where its hits stand, the primary one first; none where nothing was met.
    first: u32,
    hits: u32,
    /// Which of its tile's hits below primary ones is its first.
    below: u32,
    /// Frames since its lights were looked for.
    age: u8,
}

/// The entries of a frame.
#[derive(Clone, Debug)]
pub struct History {
    rules: HistoryRules,
    /// Entries in a row, and rows.
    size: (u32, u32),
    /// Samples in a row of the frame.
    width: u32,
    /// Entries in a row of a tile, and tiles in a row of the frame.
    edge: u32,
    tiles: u32,
    projection: Option<Projection>,
    entries: Vec<Entry>,
    hits: Vec<KeptHit>,
}

/// The entries that were found at a place.
#[derive(Clone, Debug, Default)]
pub struct Past<'a> {
    /// The nearest first.
    entries: Vec<&'a [KeptHit]>,
    /// Least cosine of normals, and the largest difference of lengths of rays.
    limits: (f64, f64),
    /// Frames since the lights of the oldest were looked for, this one included.
    pub age: u8,
}

impl HistoryRules {
    /// Whether an entry is kept of sample (`x`, `y`).
    fn keeps(&self, x: u32, y: u32) -> bool {
        x.is_multiple_of(self.step) && y.is_multiple_of(self.step)
    }

    /// How many hits of a sample are kept at most: none, the primary one, or all.
    pub(super) fn hits_kept(&self, (x, y): (u32, u32)) -> u32 {
        match (self.keeps(x, y), self.depth) {
            (false, _) => 0,
            (true, 0) => 1,
            (true, _) => u32::MAX,
        }
    }
}

const NOTHING: Entry = Entry { position: Vec3::ZERO, first: 0, hits: 0, below: 0, age: 0 };

impl History {
    /// Nothing yet, for the frames of a trace.
    pub fn new(rules: &HistoryRules, meta: &Meta) -> Self {
        let (width, height) = meta.grid();
        let size = (width.div_ceil(rules.step), height.div_ceil(rules.step));
        let entries = vec![NOTHING; size.0 as usize * size.1 as usize];
        let (edge, tiles) = (meta.tile / rules.step, meta.tile_grid().0);
        Self { rules: rules.clone(), size, width, edge, tiles, projection: None, entries, hits: Vec::new() }
    }

    /// Begins to keep a frame: nothing of it is known yet.
    pub fn begin(&mut self, camera: &Camera) {
        self.projection = Some(Projection::new(camera));
        self.entries.fill(NOTHING);
        self.hits.clear();
    }

    /// Keeps what is known of a decided tile.
    pub fn keep(&mut self, view: &TileView) {
        let (rules, mut below) = (self.rules.clone(), 0);
        for (x, y) in view.samples().filter(|&(x, y)| rules.keeps(x, y)) {
            let (tree, first) = (view.tree(x, y), self.hits.len());
            self.keep_hits(tree, RayClass::PRIMARY);
            let hits = (self.hits.len() - first) as u32;
            let position = tree[0].surface.map_or(Vec3::ZERO, |surface| surface.position);
            let at = self.index(x / self.rules.step, y / self.rules.step);
            self.entries[at] = Entry { position, first: first as u32, hits, below, age: tree[0].age };
            below += hits.saturating_sub(1);
        }
    }

    fn keep_hits(&mut self, tree: &[Node], path: RayClass) {
        let Some(SurfacePoint { object, normal, t, shadows, .. }) = tree[0].surface else { return };
        self.hits.push(KeptHit { path, object, normal, t, shadows, local: tree[0].local });
        if path.depth() < self.rules.depth {
            for (branch, (_, child)) in tree[0].branches(path).zip(children(tree)) {
                self.keep_hits(child, branch);
            }
        }
    }

    /// What a tile of which this history knows all keeps: samples, and hits below their primary ones.
    pub fn kept(&self, view: &TileView) -> (u32, u32) {
        let of = |(x, y): (u32, u32)| {
            self.entries[self.index(x / self.rules.step, y / self.rules.step)].hits.saturating_sub(1)
        };
        let kept = view.samples().filter(|&(x, y)| self.rules.keeps(x, y));
        kept.fold((0, 0), |(samples, below), at| (samples + 1, below + of(at)))
    }

    /// The entries around some places, each once.
    pub fn spans(&self, places: &[u32]) -> Vec<HistorySpan> {
        let around = |&place: &u32| {
            let (x, y) = (place % self.size.0, place / self.size.0);
            [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]
        };
        let inside = |(x, y): &(u32, u32)| *x < self.size.0 && *y < self.size.1;
        let both = |(x, y): (u32, u32)| {
            let (tile, edge) = ((y / self.edge) * self.tiles + x / self.edge, self.edge);
            let columns = edge.min(self.size.0 - x / edge * edge);
            let entry = &self.entries[self.index(x, y)];
            let hit = HistorySpan { tile, below: false, first: (y % edge) * columns + x % edge, count: 1 };
            [hit, HistorySpan { below: true, first: entry.below, count: entry.hits.saturating_sub(1), ..hit }]
        };
        let mut all: Vec<_> = places.iter().flat_map(around).filter(inside).flat_map(both).collect();
        all.retain(|span| span.count > 0);
        all.sort_unstable();
        all.dedup();
        all.dedup_by(|next, span| {
            let joins = (next.tile, next.below, next.first) == (span.tile, span.below, span.first + span.count);
            span.count += if joins { next.count } else { 0 };
            joins
        });
        all
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.size.0 as usize + x as usize
    }

    /// Whether the lights of sample (`x`, `y`) of `frame` are looked for in any case.
    pub fn refreshes(&self, frame: u32, x: u32, y: u32) -> bool {
        let place = scramble(u64::from(y) * u64::from(self.width) + u64::from(x));
        place.wrapping_add(frame.into()).is_multiple_of(self.rules.refresh.into())
    }

    /// What was at the place of a primary hit, whose lights are not known: the entry to the left above, if that is in the picture,
    /// and those that are of its surface.
    pub fn find(&self, surface: &SurfacePoint) -> (Option<u32>, Option<Past<'_>>) {
        let Some(place) = self.projection.as_ref().and_then(|p| p.place(surface.position)) else {
            return (None, None);
        };
        let step = f64::from(self.rules.step);
        let (x, y) = (place.x / step, place.y / step);
        let (left, top) = (x.floor(), y.floor());
        let (columns, rows) = (f64::from(self.size.0), f64::from(self.size.1));
        if !(left >= -1.0 && top >= -1.0 && left < columns && top < rows) {
            return (None, None);
        }
        let (s, t, reach) = (x - left, y - top, self.rules.plane * place.distance);
        let limits = (libm::cos(self.rules.normal_deg.to_radians()), self.rules.distance);
        let (mut cover, mut best, mut past) = (0.0, 0.0, Past { limits, ..Past::default() });
        for (right, below) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let (u, v) = (left + right, top + below);
            if u < 0.0 || v < 0.0 || u >= columns || v >= rows {
                continue;
            }
            let entry = &self.entries[self.index(u as u32, v as u32)];
            let hits = &self.hits[entry.first as usize..][..entry.hits as usize];
            if !self.is_of(entry, hits, surface, reach) {
                continue;
            }
            let weight = (if right > 0.0 { s } else { 1.0 - s }) * (if below > 0.0 { t } else { 1.0 - t });
            cover += weight;
            past.age = past.age.max(entry.age.saturating_add(1));
            // Of entries of the same weight the first counts as nearest.
            if weight > best {
                best = weight;
                past.entries.insert(0, hits);
            } else {
                past.entries.push(hits);
            }
        }
        let first = (top.max(0.0) as u32) * self.size.0 + left.max(0.0) as u32;
        (Some(first), (cover >= self.rules.cover && !past.entries.is_empty()).then_some(past))
    }

    /// Whether an entry is of the surface that is sought, and young enough.
    fn is_of(&self, entry: &Entry, hits: &[KeptHit], surface: &SurfacePoint, reach: f64) -> bool {
        let wide = |v: Vec3| v.to_array().map(f64::from);
        let (a, b, n) = (wide(entry.position), wide(surface.position), wide(surface.normal));
        let off = ((a[0] - b[0]) * n[0] + (a[1] - b[1]) * n[1]) + (a[2] - b[2]) * n[2];
        hits.first().is_some_and(|hit| hit.object == surface.object)
            && u32::from(entry.age) < self.rules.age
            && off.abs() <= reach
    }
}

impl Past<'_> {
    /// The lights of a hit at `path` that are known: all entries have a hit like it there, and agree on them. The hit's shadows have the
    /// low bit of each light that it casts rays at.
    pub fn lights(&self, path: RayClass, seen: &SurfacePoint) -> Option<KnownLights> {
        let (cosine, reach) = self.limits;
        let is_like = |hit: &&KeptHit| {
            let off = (f64::from(hit.t) - f64::from(seen.t)).abs();
            hit.path == path
                && hit.object == seen.object
                && within_angle(hit.normal, seen.normal, cosine)
                && (path == RayClass::PRIMARY || off <= reach * f64::from(seen.t))
        };
        let of = |hits: &[KeptHit]| hits.iter().find(is_like).copied();
        let (nearest, others) = self.entries.split_first()?;
        let nearest = of(nearest)?;
        // Lit or blocked: that a light is tinted does not say how.
        let Shadows(states) = nearest.shadows;
        let mut lights = seen.shadows.0 & (states ^ states >> 1);
        for hits in others {
            lights &= !Shadows(of(hits)?.shadows.0 ^ states).places().0;
        }
        (lights != 0).then_some(KnownLights { lights, shadows: nearest.shadows, local: nearest.local })
    }
}
