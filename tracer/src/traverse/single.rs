//! One ray on its way through the tree.

use glam::{Vec4, Vec4Swizzles};
use rayreel_formats::bvh::{Child, MAX_TREE_DEPTH};
use rayreel_formats::intersect::intersect;
use rayreel_formats::rays::Ray;
use rayreel_formats::tile::step;

use super::padding::Padding;
use super::{RayHit, TINY, TraversalBvh, TwoBoxes, WIDEN};

/// Memory of a traversal, reused from ray to ray.
#[derive(Debug)]
pub struct TraversalScratch {
    stack: Box<[(Child, f32); MAX_TREE_DEPTH]>,
    /// Recorded steps; the caller takes what each ray appended.
    pub steps: Vec<u8>,
}

impl Default for TraversalScratch {
    fn default() -> Self {
        Self { stack: Box::new([(Child::leaf(0, 0), 0.0); MAX_TREE_DEPTH]), steps: Vec::new() }
    }
}

/// A ray prepared for slab tests. Lanes as in [`TwoBoxes`].
struct Slabs {
    origin: [Vec4; 3],
    inverse: [Vec4; 3],
}

impl Slabs {
    fn new(ray: &Ray, padding: Padding) -> Self {
        let inverse = |d: f32| Vec4::splat(1.0 / if d.abs() < TINY { TINY.copysign(d) } else { d });
        let (o, d) = (ray.origin, ray.direction);
        let pad = padding.of_ray(o);
        // Moving the origin up against minimum planes and down against maximum planes grows all boxes at no cost.
        let padded = |o: f32, pad: f32| Vec4::new(o + pad, o + pad, o - pad, o - pad);
        let origin = [padded(o.x, pad.x), padded(o.y, pad.y), padded(o.z, pad.z)];
        Self { origin, inverse: [inverse(d.x), inverse(d.y), inverse(d.z)] }
    }

    /// Entry distances of both boxes, and whether each is met before `t_max`.
    #[inline(always)]
    fn test(&self, node: &TwoBoxes, t_max: f32) -> ([f32; 2], [bool; 2]) {
        let slab = |planes: Vec4, axis: usize| (planes - self.origin[axis]) * self.inverse[axis];
        let (x, y, z) = (slab(node.x, 0), slab(node.y, 1), slab(node.z, 2));
        // Minimum and maximum planes change places where the ray runs backwards; taking both orders needs no branch.
        let (sx, sy, sz) = (x.zwxy(), y.zwxy(), z.zwxy());
        let near = x.min(sx).max(y.min(sy)).max(z.min(sz).max(Vec4::ZERO));
        let far = x.max(sx).min(y.max(sy)).min(z.max(sz).min(Vec4::splat(t_max))) * WIDEN;
        ([near.x, near.y], [near.x <= far.x, near.y <= far.y])
    }
}

impl TraversalBvh {
    /// The closest hit. `pass(triangle, u, v)` says of a hit whether the ray goes on as if the triangle were not there.
    /// With `RECORD` the steps are appended to the scratch memory.
    #[inline]
    pub fn closest_hit<const RECORD: bool>(
        &self,
        ray: &Ray,
        scratch: &mut TraversalScratch,
        pass: impl FnMut(u32, f32, f32) -> bool,
    ) -> Option<RayHit> {
        self.walk::<RECORD, false>(ray, scratch, pass)
    }

    /// The first hit that is found, which need not be the closest: enough to know that a shadow ray is blocked.
    #[inline]
    pub fn any_hit<const RECORD: bool>(
        &self,
        ray: &Ray,
        scratch: &mut TraversalScratch,
        pass: impl FnMut(u32, f32, f32) -> bool,
    ) -> Option<RayHit> {
        self.walk::<RECORD, true>(ray, scratch, pass)
    }

    #[inline(always)]
    fn walk<const RECORD: bool, const ANY_HIT: bool>(
        &self,
        ray: &Ray,
        scratch: &mut TraversalScratch,
        mut pass: impl FnMut(u32, f32, f32) -> bool,
    ) -> Option<RayHit> {
        let slabs = Slabs::new(ray, self.padding);
        let TraversalScratch { stack, steps } = scratch;
        let mut record = |s: u8| {
            if RECORD {
                steps.push(s);
            }
        };
        let (mut best, mut t_max, mut top) = (None, ray.t_max, 0);
        let mut current = Child::inner(0);
        loop {
            if current.is_leaf() {
                for triangle in current.triangles() {
                    let Some(hit) = intersect(ray, self.corners[triangle], t_max) else {
                        record(step::MISS);
                        continue;
                    };
                    if pass(triangle as u32, hit.u, hit.v) {
                        record(step::PASS);
                        continue;
                    }
                    record(step::HIT);
                    t_max = hit.t;
                    best = Some(RayHit { triangle: triangle as u32, t: hit.t, u: hit.u, v: hit.v });
                    if ANY_HIT {
                        return best;
                    }
                }
            } else {
                let node = &self.nodes[current.node()];
                let [left, right] = node.children;
                let ([near_left, near_right], met) = slabs.test(node, t_max);
                match met {
                    [true, true] => {
                        let left_first = near_left <= near_right;
                        let (first, second, near) =
                            if left_first { (left, right, near_right) } else { (right, left, near_left) };
                        record(if left_first { step::LEFT_FIRST } else { step::RIGHT_FIRST });
                        // A tree is never deeper than the stack (`Bvh::new` checks).
                        stack[top] = (second, near);
                        top += 1;
                        current = first;
                        continue;
                    }
                    [true, false] => {
                        record(step::LEFT);
                        current = left;
                        continue;
                    }
                    [false, true] => {
                        record(step::RIGHT);
                        current = right;
                        continue;
                    }
                    [false, false] => record(step::NONE),
                }
            }
            // Pop children until one starts before the closest hit so far.
            loop {
                if top == 0 {
                    return best;
                }
                top -= 1;
                let (child, near) = stack[top];
                if ANY_HIT || near <= t_max * WIDEN {
                    record(step::POP);
                    current = child;
                    break;
                }
                record(step::CULLED);
            }
        }
    }
}
