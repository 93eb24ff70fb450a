//! What a trace holds of a tile, as trees of hits: what a policy may look into only by tracing.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays;
use rayreel_formats::scene::{Camera, Rect};
use rayreel_formats::tile::{Hit, RayNode, Tile, composite};

use crate::counts::RayCounts;
use crate::policy::tree::{Node, SurfacePoint, finish};
use crate::source::TileSource;

/// What was recorded of a tile, as trees: sample `i` has the hits `first[i]..first[i + 1]`.
#[derive(Default)]
pub(super) struct Recorded {
    pub first: Vec<u32>,
    pub nodes: Vec<Node>,
    /// Per hit the rays by kind.
    pub rays: Vec<RayCounts>,
}

impl Recorded {
    /// What `source` recorded of `tile`, which stands at `rect`. With `deep` all hits of a sample, else one that has the
    /// colour and the rays of all.
    ///
    /// # Errors
    /// What is wrong with the tile's columns.
    pub fn new<S: TileSource + ?Sized>(
        source: &S,
        camera: &Camera,
        tile: &Tile,
        rect: Rect,
        deep: bool,
    ) -> Result<Self, String> {
        check(tile, rect)?;
        Ok(if deep { record_trees(source, camera, tile, rect) } else { record(source, camera, tile, rect) })
    }

    /// Where the hits of a sample stand.
    pub fn range(&self, sample: usize) -> std::ops::Range<usize> {
        self.first[sample] as usize..self.first[sample + 1] as usize
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
        let (x, y) = position(rect, sample);
        let surface = nodes[0].hit.then(|| primary(source, camera, &nodes[0], &tile.hits[range.start], (x, y)));
        let colour = composite(nodes, &tile.radiance[range.clone()]);
        let rays = RayCounts::of(nodes);
        let total = rays.total() as u32;
        let (local, reflect, refract) = (tile.radiance[range.start].local.to_vec3(), None, None);
        recorded.nodes.push(Node {
            surface,
            local,
            colour,
            reflect,
            refract,
            hit_rays: total,
            rays: total,
            len: 1,
            age: 0,
        });
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
                (true, true) => Some(primary(source, camera, node, hit, position(rect, sample))),
                (true, false) => Some(secondary(source, node, hit)),
            };
            let (reflect, refract) = (radiance.reflect.to_vec3(), radiance.refract.to_vec3());
            nodes.push(Node {
                surface,
                local: radiance.local.to_vec3(),
                colour: black,
                reflect: node.reflect.then_some(reflect),
                refract: node.refract.then_some(refract),
                hit_rays: 1 + node.shadows.count(),
                rays: 0,
                len: 1,
                age: 0,
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

/// Column and row of the `sample`-th sample of a tile, in the frame's grid.
fn position(rect: Rect, sample: usize) -> (u32, u32) {
    (rect.x + sample as u32 % rect.width, rect.y + sample as u32 / rect.width)
}

/// The surface that a camera ray met, with its position.
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

/// The surface that any closest-hit ray met; its position is left out.
fn secondary<S: TileSource + ?Sized>(source: &S, node: &RayNode, hit: &Hit) -> SurfacePoint {
    SurfacePoint {
        object: source.object_of(hit.triangle),
        shadows: node.shadows,
        normal: hit.normal.decode(),
        position: Vec3::ZERO,
        t: hit.t,
    }
}
