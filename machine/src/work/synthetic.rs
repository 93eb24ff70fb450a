//! Made-up trees, paths and tiles, for tests and benchmarks of the machine.
//!
//! Everything follows from a seed alone, and every path is valid: [`super::check::walk`] accepts it.

use rayreel_formats::bvh::{Child, MAX_LEAF_TRIANGLES, MAX_TREE_DEPTH};
use rayreel_formats::scene::Rect;
use rayreel_formats::tile::{RayKind, step};

use super::check::{PathCounts, walk};
use super::ops::Op;
use super::topology::Topology;
use super::{NO_RAY, NO_TRIANGLE, RayWork, Round, TileWork};

/// A small generator of numbers (SplitMix64).
#[derive(Clone, Copy, Debug)]
pub struct Random(pub u64);

impl Random {
    /// A number below `n`; 0 if `n` is 0.
    pub fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((((z ^ (z >> 31)) >> 32) * u64::from(n)) >> 32) as u32
    }
}

/// A tree whose leaves all stand under `depth` inner nodes and hold `leaf_triangles` triangles each.
///
/// # Panics
/// When `depth` is 0 or above 24, or a leaf cannot hold so many triangles.
pub fn balanced_topology(depth: u32, leaf_triangles: u32) -> Topology {
    assert!((1..=24).contains(&depth) && leaf_triangles <= MAX_LEAF_TRIANGLES);
    let (mut children, mut triangles) = (Vec::new(), 0);
    grow(&mut children, &mut triangles, depth, leaf_triangles);
    Topology::from_children(children, triangles)
}

/// Appends a subtree, depth first.
fn grow(children: &mut Vec<[Child; 2]>, triangles: &mut u32, depth: u32, leaf_triangles: u32) -> Child {
    if depth == 0 {
        *triangles += leaf_triangles;
        return Child::leaf(*triangles - leaf_triangles, leaf_triangles);
    }
    let node = children.len();
    children.push([Child::leaf(0, 0); 2]);
    for side in 0..2 {
        children[node][side] = grow(children, triangles, depth - 1, leaf_triangles);
    }
    Child::inner(node as u32)
}

/// A path and where it ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    /// The steps.
    pub steps: Vec<u8>,
    /// The same as operations.
    pub ops: Vec<Op>,
    /// The last triangle that was hit; [`NO_TRIANGLE`] if none.
    pub hit: u32,
}

/// A random path of a shadow ray or of another one. Of eight inner nodes two show neither child, three
/// one, three both.
///
/// # Panics
/// Never: what is made here is a path.
pub fn random_path(tree: &Topology, shadow: bool, random: &mut Random) -> Path {
    let mut path = random_steps(tree, shadow, random);
    walk(tree, &path.steps, shadow, &mut path.ops, &mut PathCounts::default()).expect("the steps are a path");
    path
}

fn random_steps(tree: &Topology, shadow: bool, random: &mut Random) -> Path {
    let mut path = Path { steps: Vec::new(), ops: Vec::new(), hit: NO_TRIANGLE };
    let mut stack = Vec::with_capacity(MAX_TREE_DEPTH);
    let mut current = Child::inner(0);
    loop {
        if current.is_leaf() {
            for triangle in current.triangles() {
                let test =
                    [step::MISS, step::MISS, step::MISS, step::MISS, step::PASS, step::HIT][random.below(6) as usize];
                path.steps.push(test);
                if test == step::HIT {
                    path.hit = triangle as u32;
                    if shadow {
                        return path;
                    }
                }
            }
        } else {
            let [left, right] = tree.children[current.node()];
            // The root is met: a ray that misses the scene says nothing.
            let code = if !path.steps.is_empty() && random.below(4) == 0 {
                step::NONE
            } else {
                [step::LEFT, step::RIGHT, step::LEFT_FIRST, step::RIGHT_FIRST][random.below(4) as usize]
            };
            path.steps.push(code);
            let (near, far) =
                if code == step::RIGHT || code == step::RIGHT_FIRST { (right, left) } else { (left, right) };
            if code >= step::LEFT_FIRST {
                stack.push(far);
            }
            if code != step::NONE {
                current = near;
                continue;
            }
        }
        loop {
            let Some(next) = stack.pop() else { return path };
            if !shadow && path.hit != NO_TRIANGLE && random.below(2) == 0 {
                path.steps.push(step::CULLED);
                continue;
            }
            path.steps.push(step::POP);
            current = next;
            break;
        }
    }
}

/// One primary ray a path, in one round; the samples stand in rows of 32.
pub fn tile_of(frame: u32, tile: u32, paths: &[Path]) -> TileWork {
    let width = 32.min(paths.len().max(1) as u32);
    let height = (paths.len() as u32).div_ceil(width).max(1);
    let mut work = TileWork::empty(frame, tile, Rect { x: 0, y: 0, width, height });
    work.rounds.push(Round { starts: (0..paths.len() as u32).collect(), ..Round::default() });
    for (i, path) in (0..).zip(paths) {
        let ray = push_ray(&mut work, path, RayKind::Primary);
        (work.rays[ray as usize].x, work.rays[ray as usize].y) = (i % width, i / width);
    }
    work
}

/// Appends a ray without children; the caller links it.
pub fn push_ray(work: &mut TileWork, path: &Path, kind: RayKind) -> u32 {
    let ray = work.rays.len() as u32;
    work.rays.push(RayWork {
        ops_start: work.ops.len() as u32,
        ops_len: path.ops.len() as u32,
        kind,
        shadows: 0,
        triangle: if kind == RayKind::Shadow { NO_TRIANGLE } else { path.hit },
        material: 0,
        reflect: NO_RAY,
        refract: NO_RAY,
        x: 0,
        y: 0,
        depth: 0,
        known_lights: 0,
    });
    work.ops.extend_from_slice(&path.ops);
    ray
}

/// A tile of `samples` random ray trees: hits cast up to two shadow rays and, up to `max_depth` bounces, a reflection, a
/// refraction, or both. Materials go from 0 to 3.
pub fn random_tile(tree: &Topology, tile: u32, samples: u32, max_depth: u8, random: &mut Random) -> TileWork {
    let mut work = tile_of(0, tile, &[]);
    (work.rect.width, work.rect.height) = (32.min(samples.max(1)), samples.div_ceil(32).max(1));
    for sample in 0..samples {
        let at = (sample % work.rect.width, sample / work.rect.width, 0);
        let primary = random_tree(&mut work, tree, RayKind::Primary, at, max_depth, random);
        work.rounds[0].starts.push(primary);
    }
    work
}

fn random_tree(
    work: &mut TileWork,
    tree: &Topology,
    kind: RayKind,
    (x, y, depth): (u32, u32, u8),
    max_depth: u8,
    random: &mut Random,
) -> u32 {
    let path = random_path(tree, false, random);
    let ray = push_ray(work, &path, kind);
    let hit = path.hit != NO_TRIANGLE;
    let shadows = if hit { random.below(3) } else { 0 };
    for _ in 0..shadows {
        let shadow = random_path(tree, true, random);
        let shadow = push_ray(work, &shadow, RayKind::Shadow) as usize;
        (work.rays[shadow].x, work.rays[shadow].y, work.rays[shadow].depth) = (x, y, depth);
    }
    let children = if hit && depth < max_depth { random.below(4) } else { 0 };
    let mut child = |work: &mut TileWork, bit: u32, kind| {
        let spawned = children & bit != 0;
        if spawned { random_tree(work, tree, kind, (x, y, depth + 1), max_depth, random) } else { NO_RAY }
    };
    let reflect = child(work, 1, RayKind::Reflection);
    let refract = child(work, 2, RayKind::Refraction);
    let parent = &mut work.rays[ray as usize];
    (parent.x, parent.y, parent.depth, parent.shadows) = (x, y, depth, shadows as u8);
    (parent.reflect, parent.refract) = (reflect, refract);
    parent.material = if hit { path.hit % 4 } else { 0 };
    ray
}
