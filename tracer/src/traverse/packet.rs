//! Eight rays on their way through the tree together.
//!
//! Every ray does what it would do alone: a node is visited for the rays that are in it, the rays that want the left
//! child first and those that want the right one first get their own turns, and a popped child is visited by the rays
//! whose closest hit lies behind it. So each ray meets its nodes and triangles in its own order. What is shared is the
//! arithmetic, eight lanes at a time, and the branches.

use rayreel_formats::bvh::{Child, MAX_TREE_DEPTH};
use rayreel_formats::math::Vec3;
use rayreel_formats::rays::Ray;
use rayreel_formats::tile::step;

use glam::Vec4;

use super::lanes::{LANES, Lanes, Lanes3};
use super::log::{PathLog, steps};
use super::single::{Progress, Slabs, Stack, empty_stack};
use super::{PAD, RayHit, TINY, TraversalBvh, TwoBoxes, WIDEN};

/// So few rays walk on alone: a packet's visit costs what two or three of theirs do.
const ALONE: u32 = 2;

/// The rays of a packet.
#[derive(Clone, Copy, Debug)]
pub struct PacketRays {
    /// Lane by lane; lanes that are not in `mask` hold any ray.
    pub rays: [Ray; LANES],
    /// The lanes that hold a ray, a bit each.
    pub mask: u8,
}

/// What the rays of a packet hit.
pub type LaneHits = [Option<RayHit>; LANES];

/// A child put aside. At most two are put aside at a node: one for the rays that want the left child first, one for
/// the others.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// Where the rays of `popped` enter its box.
    near: Lanes,
    child: Child,
    /// Rays that put it aside.
    popped: u8,
    /// Rays that only wait for others, and do not know of it as put aside.
    direct: u8,
}

/// Memory of packets, reused from packet to packet.
#[derive(Debug)]
pub struct PacketScratch {
    waiting: Box<[Waiting; 2 * MAX_TREE_DEPTH]>,
    alone: Box<Stack>,
    log: PathLog,
}

impl Default for PacketScratch {
    fn default() -> Self {
        let none = Waiting { near: Lanes::ZERO, child: Child::leaf(0, 0), popped: 0, direct: 0 };
        Self { waiting: Box::new([none; 2 * MAX_TREE_DEPTH]), alone: empty_stack(), log: PathLog::default() }
    }
}

impl PacketScratch {
    /// The steps that were recorded for a lane of the last packet.
    pub fn steps(&self, lane: usize) -> &[u8] {
        self.log.lane(lane)
    }
}

/// The rays of a packet, prepared for slab tests. The operations are those of a single ray, in their order.
struct PacketSlabs {
    /// Origins moved up, against minimum planes.
    up: Lanes3,
    /// Origins moved down, against maximum planes.
    down: Lanes3,
    inverse: Lanes3,
}

impl PacketSlabs {
    #[inline(always)]
    fn new(origin: Lanes3, direction: Lanes3, bvh: &TraversalBvh) -> Self {
        let one = Lanes::splat(1.0);
        let inverse = |d: Lanes| one / d.away_from_zero(TINY);
        let corner = |c: Vec3| (Lanes3::splat(c) - origin).max_abs();
        let reach = corner(bvh.bounds.min).max(corner(bvh.bounds.max));
        let pad = |o: Lanes| reach * Lanes::splat(PAD) + o.abs() * Lanes::splat(f32::EPSILON);
        let pad = Lanes3 { x: pad(origin.x), y: pad(origin.y), z: pad(origin.z) };
        let inverse = Lanes3 { x: inverse(direction.x), y: inverse(direction.y), z: inverse(direction.z) };
        Self { up: origin + pad, down: origin - pad, inverse }
    }

    /// Entry distances of the left (`SIDE` 0) or right box of a node, and the rays that meet it before `t_max`.
    #[inline(always)]
    fn test<const SIDE: usize>(&self, node: &TwoBoxes, t_max: Lanes) -> (Lanes, u8) {
        let slab = |planes: Vec4, up: Lanes, down: Lanes, inverse: Lanes| {
            let planes = planes.to_array();
            let (a, b) = (Lanes::splat(planes[SIDE]) - up, Lanes::splat(planes[SIDE + 2]) - down);
            let (a, b) = (a * inverse, b * inverse);
            (a.min(b), a.max(b))
        };
        let x = slab(node.x, self.up.x, self.down.x, self.inverse.x);
        let y = slab(node.y, self.up.y, self.down.y, self.inverse.y);
        let z = slab(node.z, self.up.z, self.down.z, self.inverse.z);
        let near = x.0.max(y.0).max(z.0.max(Lanes::ZERO));
        let far = x.1.min(y.1).min(z.1.min(t_max)) * Lanes::splat(WIDEN);
        (near, near.le(far))
    }

    /// One of the rays, as it walks alone.
    fn lane(&self, lane: usize) -> Slabs {
        let of = |v: Lanes| v.to_array()[lane];
        let origin = |up: Lanes, down: Lanes| {
            let (up, down) = (of(up), of(down));
            Vec4::new(up, up, down, down)
        };
        let inverse = |v: Lanes| Vec4::splat(of(v));
        Slabs {
            origin: [origin(self.up.x, self.down.x), origin(self.up.y, self.down.y), origin(self.up.z, self.down.z)],
            inverse: [inverse(self.inverse.x), inverse(self.inverse.y), inverse(self.inverse.z)],
        }
    }
}

/// A packet on its way.
struct PacketWalk<'a, 's> {
    bvh: &'a TraversalBvh,
    packet: &'a PacketRays,
    scratch: &'s mut PacketScratch,
    origin: Lanes3,
    direction: Lanes3,
    slabs: PacketSlabs,
    t_max: [f32; LANES],
    hits: LaneHits,
    /// Rays that go on. A shadow ray ends at its first hit.
    alive: u8,
}

/// The lanes of a mask, ascending.
#[inline(always)]
fn lanes_of(mask: u8) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| mask >> lane & 1 != 0)
}

impl TraversalBvh {
    /// What the rays of a packet hit: the closest hits, or with `ANY_HIT` the first ones that are found.
    /// `pass(lane, triangle, u, v)` says of a hit whether the ray goes on as if the triangle were not there.
    /// With `RECORD` the scratch memory holds the steps of all rays afterwards.
    pub fn packet<const RECORD: bool, const ANY_HIT: bool>(
        &self,
        packet: &PacketRays,
        scratch: &mut PacketScratch,
        mut pass: impl FnMut(usize, u32, f32, f32) -> bool,
    ) -> LaneHits {
        let (origin, direction) =
            (Lanes3::new(packet.rays.map(|r| r.origin)), Lanes3::new(packet.rays.map(|r| r.direction)));
        let slabs = PacketSlabs::new(origin, direction, self);
        let t_max = packet.rays.map(|r| r.t_max);
        scratch.log.clear();
        let hits = [None; LANES];
        let alive = packet.mask;
        let mut walk = PacketWalk { bvh: self, packet, scratch, origin, direction, slabs, t_max, hits, alive };
        walk.run::<RECORD, ANY_HIT>(&mut pass);
        walk.hits
    }
}

impl PacketWalk<'_, '_> {
    #[inline(always)]
    fn record<const RECORD: bool>(&mut self, mask: u8, steps: u64) {
        if RECORD {
            self.scratch.log.push(mask, steps);
        }
    }

    #[inline(always)]
    fn run<const RECORD: bool, const ANY_HIT: bool>(&mut self, pass: &mut impl FnMut(usize, u32, f32, f32) -> bool) {
        let (mut current, mut active, mut top) = (Child::inner(0), self.alive, 0);
        loop {
            let next = if active.count_ones() <= ALONE {
                for lane in lanes_of(active) {
                    self.alone::<RECORD, ANY_HIT>(lane, current, pass);
                }
                None
            } else if current.is_leaf() {
                self.leaf::<RECORD, ANY_HIT>(current, active, pass);
                None
            } else {
                self.node::<RECORD>(current, active, &mut top)
            };
            let next = next.or_else(|| self.next_waiting::<RECORD, ANY_HIT>(&mut top));
            let Some(next) = next else { return };
            (current, active) = next;
        }
    }

    /// Visits an inner node for the rays of `active`, and gives the child to go on with and its rays.
    #[inline(always)]
    fn node<const RECORD: bool>(&mut self, at: Child, active: u8, top: &mut usize) -> Option<(Child, u8)> {
        let node = &self.bvh.nodes[at.node()];
        let [left, right] = node.children;
        let t_max = Lanes::new(self.t_max);
        let (near_left, met_left) = self.slabs.test::<0>(node, t_max);
        let (near_right, met_right) = self.slabs.test::<1>(node, t_max);
        let (met_left, met_right) = (met_left & active, met_right & active);
        let both = met_left & met_right;
        let left_first = both & near_left.le(near_right);
        let right_first = both & !left_first;
        if RECORD {
            let one = steps(met_left & !both, step::LEFT) | steps(met_right & !both, step::RIGHT);
            let two = steps(left_first, step::LEFT_FIRST) | steps(right_first, step::RIGHT_FIRST);
            self.scratch.log.push(active, one | two);
        }
        let waiting = &mut self.scratch.waiting;
        if right_first == 0 {
            if met_left == 0 {
                return (met_right != 0).then_some((right, met_right));
            }
            if met_right != 0 {
                waiting[*top] = Waiting { near: near_right, child: right, popped: both, direct: met_right & !both };
                *top += 1;
            }
            return Some((left, met_left));
        }
        let left_only = met_left & !both;
        if left_first == 0 {
            waiting[*top] = Waiting { near: near_left, child: left, popped: both, direct: left_only };
            *top += 1;
            return Some((right, met_right));
        }
        // Left for those that want it first, right for all, left for the rest.
        waiting[*top] = Waiting { near: near_left, child: left, popped: right_first, direct: 0 };
        let direct = met_right & !left_first;
        waiting[*top + 1] = Waiting { near: near_right, child: right, popped: left_first, direct };
        *top += 2;
        Some((left, left_only | left_first))
    }

    /// Pops children until there is one that a ray visits.
    #[inline(always)]
    fn next_waiting<const RECORD: bool, const ANY_HIT: bool>(&mut self, top: &mut usize) -> Option<(Child, u8)> {
        while *top > 0 && self.alive != 0 {
            *top -= 1;
            let Waiting { near, child, popped, direct } = self.scratch.waiting[*top];
            let (popped, direct) = (popped & self.alive, direct & self.alive);
            let visited = if ANY_HIT { popped } else { popped & near.le(Lanes::new(self.t_max) * Lanes::splat(WIDEN)) };
            if popped != 0 {
                self.record::<RECORD>(popped, steps(visited, step::POP) | steps(popped & !visited, step::CULLED));
            }
            if visited | direct != 0 {
                return Some((child, visited | direct));
            }
        }
        None
    }

    /// Tests the triangles of a leaf for the rays of `active`.
    #[inline(always)]
    fn leaf<const RECORD: bool, const ANY_HIT: bool>(
        &mut self,
        leaf: Child,
        mut active: u8,
        pass: &mut impl FnMut(usize, u32, f32, f32) -> bool,
    ) {
        for triangle in leaf.triangles() {
            let (met, t, u, v) = self.triangle(self.bvh.corners[triangle], active);
            if met == 0 {
                self.record::<RECORD>(active, steps(active, step::MISS));
                continue;
            }
            let mut passed = 0;
            for lane in lanes_of(met) {
                if pass(lane, triangle as u32, u[lane], v[lane]) {
                    passed |= 1 << lane;
                } else {
                    self.t_max[lane] = t[lane];
                    self.hits[lane] = Some(RayHit { triangle: triangle as u32, t: t[lane], u: u[lane], v: v[lane] });
                }
            }
            let hit = met & !passed;
            let outcomes = steps(active & !met, step::MISS) | steps(hit, step::HIT) | steps(passed, step::PASS);
            self.record::<RECORD>(active, outcomes);
            if ANY_HIT {
                self.alive &= !hit;
                active &= !hit;
                if active == 0 {
                    return;
                }
            }
        }
    }

    /// [`intersect`] in eight lanes: the rays of `active` that hit, and their `t`, `u` and `v`.
    #[inline(always)]
    fn triangle(&self, corners: [Vec3; 3], active: u8) -> (u8, [f32; LANES], [f32; LANES], [f32; LANES]) {
        let [a, b, c] = corners.map(|corner| Lanes3::splat(corner) - self.origin);
        let (e0, e1, e2) = (c - a, a - b, b - c);
        let u = e0.cross(c + a).dot(self.direction);
        let v = e1.cross(a + b).dot(self.direction);
        let w = e2.cross(b + c).dot(self.direction);
        let zero = Lanes::ZERO;
        let front = zero.le(u) & zero.le(v) & zero.le(w);
        let back = u.le(zero) & v.le(zero) & w.le(zero);
        let inside = (front | back) & active;
        if inside == 0 {
            return (0, [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        }
        let normal = e1.cross(e0);
        let t = a.dot(normal) / self.direction.dot(normal);
        let met = inside & zero.lt(t) & t.lt(Lanes::new(self.t_max));
        let sum = (u + v) + w;
        (met, t.to_array(), (u / sum).to_array(), (v / sum).to_array())
    }

    /// Walks one ray through the tree below `start`.
    #[inline(never)]
    fn alone<const RECORD: bool, const ANY_HIT: bool>(
        &mut self,
        lane: usize,
        start: Child,
        pass: &mut impl FnMut(usize, u32, f32, f32) -> bool,
    ) {
        let progress = Progress { t_max: self.t_max[lane], best: self.hits[lane] };
        let PacketScratch { alone, log, .. } = &mut *self.scratch;
        let record = |step: u8| {
            if RECORD {
                log.push_one(lane, step);
            }
        };
        let pass = |triangle: u32, u: f32, v: f32| pass(lane, triangle, u, v);
        let (ray, slabs) = (&self.packet.rays[lane], self.slabs.lane(lane));
        let end = self.bvh.walk_below::<ANY_HIT>(start, ray, &slabs, progress, alone, record, pass);
        (self.t_max[lane], self.hits[lane]) = (end.t_max, end.best);
        if ANY_HIT && end.best.is_some() {
            self.alive &= !(1 << lane);
        }
    }
}
