//! Random tiles: trees, hits, colours that no ray leads to, and paths that walk the tree as a traversal could.

use rayreel_formats::bvh::{Bvh, Child};
use rayreel_formats::half::Half3;
use rayreel_formats::intersect::intersect;
use rayreel_formats::rays;
use rayreel_formats::scene::{Camera, Meta, Rect};
use rayreel_formats::tile::{Hit, Paths, Radiance, RayClass, RayNode, Shadows, Tile, Tree, step};

use super::{Random, soup};

/// How a random tile looks.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// A hit spawns a child of each kind once in so many times.
    pub child_in: u32,
    /// A value of the last ray is repeated all but once in so many times.
    pub news_in: u32,
}

pub fn tile(random: &mut Random, look: Look, bvh: &Bvh, meta: &Meta, camera: &Camera, index: u32, frame: u32) -> Tile {
    let rect = meta.tile_rect(index);
    let tree = tree(random, look, rect, meta, !bvh.triangles.is_empty());
    let hits = hits(random, look, &tree, rect, bvh, camera);
    let radiance = tree.nodes.iter().map(|node| radiance(random, node)).collect();
    let paths = paths(random, look, &tree, bvh);
    Tile { frame, index, rect, tree, hits, radiance, paths }
}

fn tree(random: &mut Random, look: Look, rect: Rect, meta: &Meta, can_hit: bool) -> Tree {
    let mut tree = Tree::default();
    for _ in 0..rect.len() {
        tree.first.push(tree.nodes.len() as u32);
        let mut open = vec![RayClass::PRIMARY];
        // A sample may go all the way down, but not everywhere at once.
        let most = tree.nodes.len() + 60;
        while let Some(class) = open.pop() {
            let hit = can_hit && !random.once_in(4);
            let deeper = hit && class.depth() < meta.max_depth && tree.nodes.len() + open.len() < most;
            let mut child = || deeper && !random.once_in(look.child_in);
            let (reflect, refract) = (child(), child());
            let lights = (1u64 << (2 * meta.lights.len())) - 1;
            let shadows = Shadows(if hit { random.next() & random.next() & lights as u32 } else { 0 });
            tree.nodes.push(RayNode { class, hit, reflect, refract, shadows });
            open.extend(refract.then(|| class.refraction()));
            open.extend(reflect.then(|| class.reflection()));
        }
    }
    tree.first.push(tree.nodes.len() as u32);
    tree
}

fn hits(random: &mut Random, look: Look, tree: &Tree, rect: Rect, bvh: &Bvh, camera: &Camera) -> Vec<Hit> {
    let mut out = Vec::with_capacity(tree.nodes.len());
    let mut last = 0;
    for sample in 0..tree.samples() {
        let (x, y) = (sample as u32 % rect.width, sample as u32 / rect.width);
        let ray = rays::primary(camera, rect.x + x, rect.y + y);
        for node in tree.sample(sample) {
            if !tree.nodes[node].hit {
                out.push(Hit::MISS);
                continue;
            }
            if random.once_in(look.news_in) {
                last = random.below(bvh.triangles.len() as u32);
            }
            // Some values are those that a primary ray would give, and some of those are off by one unit in the last
            // place.
            let met = intersect(&ray, bvh.corners(last as usize), f32::INFINITY);
            let (t, u, v) = met.map_or((0.0, 0.0, 0.0), |m| (m.t, m.u, m.v));
            let t = match random.below(4) {
                0 => f32::from_bits(random.next()),
                1 => f32::from_bits(t.to_bits() ^ 1),
                _ => t,
            };
            let t = if t.is_nan() { f32::MAX } else { t };
            let normal = bvh.shading_normal(last as usize, u, v);
            let normal = if random.once_in(3) { soup::oct(random) } else { normal };
            out.push(Hit { triangle: last, t, normal });
        }
    }
    out
}

fn radiance(random: &mut Random, node: &RayNode) -> Radiance {
    let mut colour = |there: bool| {
        let value = [(); 3].map(|()| random.below(0x7c00) as u16);
        if there { Half3(value) } else { Half3::ZERO }
    };
    Radiance { local: colour(true), reflect: colour(node.reflect), refract: colour(node.refract) }
}

fn paths(random: &mut Random, look: Look, tree: &Tree, bvh: &Bvh) -> Paths {
    let mut paths = Paths::default();
    let (mut closest, mut shadow) = (Vec::new(), Vec::new());
    for node in &tree.nodes {
        for ray in 0..=node.shadows.count() {
            let any = ray > 0;
            let path = if any { &mut shadow } else { &mut closest };
            if path.is_empty() || random.once_in(look.news_in) {
                *path = walk(random, bvh, any);
            }
            paths.spans.push((paths.steps.len() as u32, path.len() as u32));
            paths.steps.extend_from_slice(path);
        }
    }
    paths
}

/// A path that some traversal of the tree could take.
pub fn walk(random: &mut Random, bvh: &Bvh, any_hit: bool) -> Vec<u8> {
    let (mut steps, mut stack, mut hit) = (Vec::new(), Vec::new(), false);
    let mut current = Some(Child::inner(0));
    loop {
        let Some(child) = current.take() else {
            let Some(waiting) = stack.pop() else { return steps };
            let visited = any_hit || !hit || random.once_in(2);
            steps.push(if visited { step::POP } else { step::CULLED });
            current = visited.then_some(waiting);
            continue;
        };
        if child.is_leaf() {
            for triangle in child.triangles() {
                let may_pass = bvh.material(triangle).may_pass(any_hit);
                let outcomes = [step::MISS, step::MISS, step::HIT, step::PASS];
                let outcome = outcomes[random.below(if may_pass { 4 } else { 3 }) as usize];
                steps.push(outcome);
                hit |= outcome == step::HIT;
                if any_hit && hit {
                    return steps;
                }
            }
            continue;
        }
        let [left, right] = bvh.nodes[child.node()].children;
        // Deep into large trees, but not everywhere.
        let outcome = if steps.len() > 150 { step::NONE } else { random.below(5) as u8 };
        steps.push(outcome);
        match outcome {
            step::LEFT => current = Some(left),
            step::RIGHT => current = Some(right),
            step::LEFT_FIRST => (current, _) = (Some(left), stack.push(right)),
            step::RIGHT_FIRST => (current, _) = (Some(right), stack.push(left)),
            _ => {}
        }
    }
}
