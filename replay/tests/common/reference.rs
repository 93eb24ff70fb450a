//! A second implementation of the adaptive policy: the whole frame at once, slow and obvious, written from POLICIES.md and
//! not from the code it checks. It shares the trace format's functions (rays, colours, normals) and nothing else.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays;
use rayreel_formats::tile::{RayKind, composite};
use rayreel_replay::TileSource;
use rayreel_replay::policy::{Adaptive, Apron, Refine};

/// How a sample came to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// An R-sample, traced first.
    R,
    /// Traced by the X or the Y step.
    Traced,
    /// Interpolated.
    Interpolated,
}

#[derive(Clone, Copy, Debug)]
struct Known {
    colour: [f32; 3],
    hit: bool,
    object: u32,
    shadows: u32,
    normal: [f32; 3],
    position: [f32; 3],
    t: f32,
}

/// Number of rays: primary, reflection, refraction, shadow.
pub type Rays = [u64; 4];

/// What the reference found out about a frame. Samples are row by row over the whole grid.
pub struct Outcome {
    pub width: usize,
    pub how: Vec<How>,
    pub colours: Vec<[f32; 3]>,
    pub rays_full: Rays,
    pub rays_traced: Rays,
    pub rays_apron: Rays,
    pub samples_apron: u64,
    /// Rays of the traced and of the apron samples, per tile.
    pub tiles: Vec<(Rays, Rays)>,
}

struct Frame {
    width: usize,
    height: usize,
    recorded: Vec<Known>,
    rays: Vec<Rays>,
}

/// Replays one frame.
pub fn replay<S: TileSource>(source: &S, policy: &Adaptive, frame: u32) -> Outcome {
    let recorded = read(source, frame);
    let (width, height) = (recorded.width, recorded.height);
    let n = policy.block as usize;
    let columns: Vec<usize> = (0..width).filter(|x| x % n == 0 || *x == width - 1).collect();
    let rows: Vec<usize> = (0..height).filter(|y| y % n == 0 || *y == height - 1).collect();
    let mut known: Vec<Option<Known>> = vec![None; width * height];
    let mut how: Vec<Option<How>> = vec![None; width * height];
    for &y in &rows {
        for &x in &columns {
            known[y * width + x] = Some(recorded.recorded[y * width + x]);
            how[y * width + x] = Some(How::R);
        }
    }
    for &y in &rows {
        for pair in columns.windows(2) {
            let line: Vec<usize> = (pair[0]..=pair[1]).map(|x| y * width + x).collect();
            fill(policy, &recorded, &mut known, &mut how, &line);
        }
    }
    for x in 0..width {
        for pair in rows.windows(2) {
            let line: Vec<usize> = (pair[0]..=pair[1]).map(|y| y * width + x).collect();
            fill(policy, &recorded, &mut known, &mut how, &line);
        }
    }
    let how: Vec<How> = how.into_iter().map(|h| h.expect("every sample is decided")).collect();
    account(source, policy, &recorded, how, &known)
}

/// Decides the inner samples of `line`, whose two ends are known.
fn fill(policy: &Adaptive, frame: &Frame, known: &mut [Option<Known>], how: &mut [Option<How>], line: &[usize]) {
    let gap = line.len() - 1;
    if gap < 2 {
        return;
    }
    let (a, b) = (known[line[0]].unwrap(), known[line[gap]].unwrap());
    if similar(policy, &a, &b) {
        for i in 1..gap {
            known[line[i]] = Some(between(&a, &b, i, gap));
            how[line[i]] = Some(How::Interpolated);
        }
        return;
    }
    let traced: Vec<usize> = match policy.refine {
        Refine::Direct => (1..gap).collect(),
        Refine::Hierarchical => vec![gap / 2],
    };
    for i in traced {
        known[line[i]] = Some(frame.recorded[line[i]]);
        how[line[i]] = Some(How::Traced);
    }
    if policy.refine == Refine::Hierarchical {
        fill(policy, frame, known, how, &line[..=gap / 2]);
        fill(policy, frame, known, how, &line[gap / 2..]);
    }
}

fn similar(policy: &Adaptive, a: &Known, b: &Known) -> bool {
    let rules = &policy.similarity;
    if !a.hit && !b.hit {
        return true;
    }
    if a.hit != b.hit {
        return false;
    }
    let (na, nb) = (a.normal.map(f64::from), b.normal.map(f64::from));
    let (pa, pb) = (a.position.map(f64::from), b.position.map(f64::from));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let step = [pb[0] - pa[0], pb[1] - pa[1], pb[2] - pa[2]];
    let reach = f64::from(a.t.min(b.t));
    let mut pass = true;
    if rules.object_id {
        pass &= a.object == b.object;
    }
    if rules.shadow {
        pass &= a.shadows == b.shadows;
    }
    if let Some(degrees) = rules.normal_deg.value() {
        let cosine = libm::cos(degrees.to_radians());
        pass &= dot(na, nb) >= cosine * (dot(na, na) * dot(nb, nb)).sqrt();
    }
    if let Some(limit) = rules.position.value() {
        pass &= dot(step, step).sqrt() <= limit * reach;
    }
    if let Some(limit) = rules.plane.value() {
        pass &= dot(step, na).abs() <= limit * reach;
    }
    pass
}

/// Sample `i` of `gap` from `a` to `b`.
fn between(a: &Known, b: &Known, i: usize, gap: usize) -> Known {
    let (near, far, distance) = if i <= gap - i { (a, b, i) } else { (b, a, gap - i) };
    let s = distance as f32 / gap as f32;
    let mix = |n: f32, f: f32| n + (f - n) * s;
    let mix3 = |n: [f32; 3], f: [f32; 3]| [mix(n[0], f[0]), mix(n[1], f[1]), mix(n[2], f[2])];
    let mut normal = mix3(near.normal, far.normal);
    let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
    if length > 0.0 {
        normal = normal.map(|v| v / length);
    } else {
        normal = near.normal;
    }
    Known {
        colour: mix3(near.colour, far.colour),
        hit: near.hit,
        object: near.object,
        shadows: near.shadows,
        normal,
        position: mix3(near.position, far.position),
        t: mix(near.t, far.t),
    }
}

fn read<S: TileSource>(source: &S, frame: u32) -> Frame {
    let meta = source.meta();
    let (width, height) = (meta.grid().0 as usize, meta.grid().1 as usize);
    let camera = source.camera(frame).unwrap();
    let mut recorded = vec![None; width * height];
    let mut rays = vec![[0; 4]; width * height];
    for index in 0..meta.tile_count() {
        let tile = source.tile(frame, index).unwrap();
        for sample in 0..tile.rect.len() {
            let x = tile.rect.x as usize + sample % tile.rect.width as usize;
            let y = tile.rect.y as usize + sample / tile.rect.width as usize;
            let range = tile.tree.sample(sample);
            let nodes = &tile.tree.nodes[range.clone()];
            let hit = tile.hits[range.start];
            let ray = rays::primary(&camera, x as u32, y as u32);
            let position = if nodes[0].hit { ray.origin + ray.direction * hit.t } else { Vec3::ZERO };
            recorded[y * width + x] = Some(Known {
                colour: composite(nodes, &tile.radiance[range]).to_array(),
                hit: nodes[0].hit,
                object: if nodes[0].hit { source.object_of(hit.triangle) } else { 0 },
                shadows: nodes[0].shadows.0,
                normal: hit.normal.decode().to_array(),
                position: position.to_array(),
                t: if nodes[0].hit { hit.t } else { 0.0 },
            });
            for node in nodes {
                rays[y * width + x][node.class.kind() as usize] += 1;
                rays[y * width + x][RayKind::Shadow as usize] += node.shadows.cast().count() as u64;
            }
        }
    }
    Frame { width, height, recorded: recorded.into_iter().map(|k| k.expect("tiles cover the frame")).collect(), rays }
}

fn account<S: TileSource>(
    source: &S,
    policy: &Adaptive,
    frame: &Frame,
    how: Vec<How>,
    known: &[Option<Known>],
) -> Outcome {
    let mut outcome = Outcome {
        width: frame.width,
        colours: known.iter().map(|k| k.unwrap().colour).collect(),
        rays_full: sum(frame.rays.iter().copied()),
        rays_traced: [0; 4],
        rays_apron: [0; 4],
        samples_apron: 0,
        tiles: Vec::new(),
        how,
    };
    for index in 0..source.meta().tile_count() {
        let rect = source.meta().tile_rect(index);
        let mut own = Vec::new();
        for y in rect.y..rect.y + rect.height {
            own.extend((rect.x..rect.x + rect.width).map(|x| (x as usize, y as usize)));
        }
        let traced = |&(x, y): &(usize, usize)| outcome.how[y * frame.width + x] != How::Interpolated;
        let rays = |list: Vec<(usize, usize)>| sum(list.into_iter().map(|(x, y)| frame.rays[y * frame.width + x]));
        let again: Vec<_> = match policy.apron {
            Apron::Share => Vec::new(),
            Apron::Retrace => border(policy, frame, rect).into_iter().filter(traced).collect(),
        };
        let paid = (rays(own.into_iter().filter(traced).collect()), rays(again.clone()));
        outcome.rays_traced = sum([outcome.rays_traced, paid.0].into_iter());
        outcome.rays_apron = sum([outcome.rays_apron, paid.1].into_iter());
        outcome.samples_apron += again.len() as u64;
        outcome.tiles.push(paid);
    }
    outcome
}

/// The samples outside a tile that its steps look at: on the closing column those in R-rows of the tile and of the corner, on
/// the closing row all.
fn border(policy: &Adaptive, frame: &Frame, rect: rayreel_formats::scene::Rect) -> Vec<(usize, usize)> {
    let n = policy.block as usize;
    let (left, top) = (rect.x as usize, rect.y as usize);
    let (right, bottom) = (left + rect.width as usize, top + rect.height as usize);
    let mut list = Vec::new();
    if right < frame.width {
        for y in top..=bottom {
            if y < frame.height && (y % n == 0 || y == frame.height - 1) {
                list.push((right, y));
            }
        }
    }
    if bottom < frame.height {
        list.extend((left..right).map(|x| (x, bottom)));
    }
    list
}

fn sum(list: impl Iterator<Item = Rays>) -> Rays {
    list.fold([0; 4], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
}
