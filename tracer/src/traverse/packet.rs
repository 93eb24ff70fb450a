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

#[cfg(target_arch = "x86_64")]
use super::avx::Avx;
use super::lanes::{Halves, LANES, Lanes, Lanes3};
use super::log::{PathLog, steps};
use super::padding::Padding;
use super::{RayHit, TINY, TraversalBvh, TwoBoxes, WIDEN};

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

/// Eight numbers in memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Distances([f32; LANES]);

/// A child put aside. At most two are put aside at a node: one for the rays that want the left child first, one for
/// the others.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// Where the rays of `popped` enter its box.
    near: Distances,
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
    log: PathLog,
}

impl Default for PacketScratch {
    fn default() -> Self {
        let none = Waiting { near: Distances([0.0; LANES]), child: Child::leaf(0, 0), popped: 0, direct: 0 };
        Self { waiting: Box::new([none; 2 * MAX_TREE_DEPTH]), log: PathLog::default() }
    }
}

impl PacketScratch {
    /// The steps that were recorded for a lane of the last packet.
    pub fn steps(&self, lane: usize) -> &[u8] {
        self.log.lane(lane)
    }
}

/// The rays of a packet, prepared for slab tests. The operations are those of a single ray, in their order.
struct PacketSlabs<L> {
    /// Origins moved up, against minimum planes.
    up: Lanes3<L>,
    /// Origins moved down, against maximum planes.
    down: Lanes3<L>,
    inverse: Lanes3<L>,
}

impl<L: Lanes> PacketSlabs<L> {
    #[inline(always)]
    fn new(origin: Lanes3<L>, direction: Lanes3<L>, padding: Padding) -> Self {
        let pad = padding.of_rays(origin);
        let one = L::splat(1.0);
        let inverse = Lanes3 {
            x: one / direction.x.away_from_zero(TINY),
            y: one / direction.y.away_from_zero(TINY),
            z: one / direction.z.away_from_zero(TINY),
        };
        Self { up: origin + pad, down: origin - pad, inverse }
    }

    /// Entry distances of the left (`SIDE` 0) or right box of a node, and the rays that meet it before `t_max`.
    #[inline(always)]
    fn test<const SIDE: usize>(&self, node: &TwoBoxes, t_max: L) -> (L, u8) {
        let x = slab::<L, SIDE>(node.x, self.up.x, self.down.x, self.inverse.x);
        let y = slab::<L, SIDE>(node.y, self.up.y, self.down.y, self.inverse.y);
        let z = slab::<L, SIDE>(node.z, self.up.z, self.down.z, self.inverse.z);
        let near = x.0.max(y.0).max(z.0.max(L::splat(0.0)));
        let far = x.1.min(y.1).min(z.1.min(t_max)) * L::splat(WIDEN);
        (near, near.le(far))
    }
}

/// Where rays enter and leave a slab between two planes.
#[inline(always)]
fn slab<L: Lanes, const SIDE: usize>(planes: Vec4, up: L, down: L, inverse: L) -> (L, L) {
    let planes = planes.to_array();
    let (a, b) = ((L::splat(planes[SIDE]) - up) * inverse, (L::splat(planes[SIDE + 2]) - down) * inverse);
    (a.min(b), a.max(b))
}

/// A packet on its way.
struct PacketWalk<'a, 's, L> {
    bvh: &'a TraversalBvh,
    scratch: &'s mut PacketScratch,
    origin: Lanes3<L>,
    direction: Lanes3<L>,
    slabs: PacketSlabs<L>,
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
        pass: impl FnMut(usize, u32, f32, f32) -> bool,
    ) -> LaneHits {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            #[expect(unsafe_code, reason = "the one way to code that not every processor has")]
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { self.packet_avx::<RECORD, ANY_HIT>(packet, scratch, pass) };
        }
        self.packet_anywhere::<RECORD, ANY_HIT>(packet, scratch, pass)
    }

    /// [`TraversalBvh::packet`] as machines do it that have nothing better.
    pub fn packet_anywhere<const RECORD: bool, const ANY_HIT: bool>(
        &self,
        packet: &PacketRays,
        scratch: &mut PacketScratch,
        pass: impl FnMut(usize, u32, f32, f32) -> bool,
    ) -> LaneHits {
        self.packet_of::<Halves, RECORD, ANY_HIT>(packet, scratch, pass)
    }

    /// All that it calls is inlined, and so compiled for this processor: see `avx.rs`.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn packet_avx<const RECORD: bool, const ANY_HIT: bool>(
        &self,
        packet: &PacketRays,
        scratch: &mut PacketScratch,
        pass: impl FnMut(usize, u32, f32, f32) -> bool,
    ) -> LaneHits {
        self.packet_of::<Avx, RECORD, ANY_HIT>(packet, scratch, pass)
    }

    #[inline(always)]
    fn packet_of<L: Lanes, const RECORD: bool, const ANY_HIT: bool>(
        &self,
        packet: &PacketRays,
        scratch: &mut PacketScratch,
        mut pass: impl FnMut(usize, u32, f32, f32) -> bool,
    ) -> LaneHits {
        let rays = &packet.rays;
        let (origin, direction) = (Lanes3::<L>::new(rays.map(|r| r.origin)), Lanes3::new(rays.map(|r| r.direction)));
        let slabs = PacketSlabs::new(origin, direction, self.padding);
        let t_max = rays.map(|r| r.t_max);
        scratch.log.clear();
        let hits = [None; LANES];
        let alive = packet.mask;
        let mut walk = PacketWalk { bvh: self, scratch, origin, direction, slabs, t_max, hits, alive };
        walk.run::<RECORD, ANY_HIT>(&mut pass);
        walk.hits
    }
}

impl<L: Lanes> PacketWalk<'_, '_, L> {
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
            let next = if current.is_leaf() {
                self.leaf::<RECORD, ANY_HIT>(current, active, pass);
                None
            } else {
                self.node::<RECORD>(current, active, &mut top)
            };
            (current, active) = match next {
                Some(next) => next,
                None => match self.next_waiting::<RECORD, ANY_HIT>(&mut top) {
                    Some(next) => next,
                    None => return,
                },
            };
        }
    }

    /// Visits an inner node for the rays of `active`, and gives the child to go on with and its rays.
    #[inline(always)]
    fn node<const RECORD: bool>(&mut self, at: Child, active: u8, top: &mut usize) -> Option<(Child, u8)> {
        let node = &self.bvh.nodes[at.node()];
        let [left, right] = node.children;
        let t_max = L::new(self.t_max);
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
                waiting[*top] = Waiting {
                    near: Distances(near_right.to_array()),
                    child: right,
                    popped: both,
                    direct: met_right & !both,
                };
                *top += 1;
            }
            return Some((left, met_left));
        }
        let left_only = met_left & !both;
        if left_first == 0 {
            waiting[*top] =
                Waiting { near: Distances(near_left.to_array()), child: left, popped: both, direct: left_only };
            *top += 1;
            return Some((right, met_right));
        }
        // Left for those that want it first, right for all, left for the rest.
        waiting[*top] = Waiting { near: Distances(near_left.to_array()), child: left, popped: right_first, direct: 0 };
        let direct = met_right & !left_first;
        waiting[*top + 1] =
            Waiting { near: Distances(near_right.to_array()), child: right, popped: left_first, direct };
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
            let visited =
                if ANY_HIT { popped } else { popped & L::new(near.0).le(L::new(self.t_max) * L::splat(WIDEN)) };
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
        let [a, b, c] = corners;
        let (a, b, c) = (Lanes3::splat(a), Lanes3::splat(b), Lanes3::splat(c));
        let (a, b, c) = (a - self.origin, b - self.origin, c - self.origin);
        let (e0, e1, e2) = (c - a, a - b, b - c);
        let u = e0.cross(c + a).dot(self.direction);
        let v = e1.cross(a + b).dot(self.direction);
        let w = e2.cross(b + c).dot(self.direction);
        let zero = L::splat(0.0);
        let front = zero.le(u) & zero.le(v) & zero.le(w);
        let back = u.le(zero) & v.le(zero) & w.le(zero);
        let inside = (front | back) & active;
        if inside == 0 {
            return (0, [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        }
        let normal = e1.cross(e0);
        let t = a.dot(normal) / self.direction.dot(normal);
        let met = inside & zero.lt(t) & t.lt(L::new(self.t_max));
        let sum = (u + v) + w;
        (met, t.to_array(), (u / sum).to_array(), (v / sum).to_array())
    }
}
