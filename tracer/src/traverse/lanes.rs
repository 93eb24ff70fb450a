//! Eight numbers side by side, one a ray.
//!
//! Each lane is the scalar IEEE operation in the order that the code says, and nothing is summed or compared across
//! lanes. So a lane gives the bits that scalar code would, on every machine and by every implementation of [`Lanes`].

use std::ops::{Add, Div, Mul, Sub};

use glam::Vec4;
use rayreel_formats::math::Vec3;

/// Rays in a packet.
pub const LANES: usize = 8;

/// Eight numbers.
pub(super) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Eight times the same number.
    fn splat(v: f32) -> Self;

    /// From lane 0 on.
    fn new(v: [f32; LANES]) -> Self;

    /// From lane 0 on.
    fn to_array(self) -> [f32; LANES];

    /// The smaller numbers. No lane may be NaN.
    fn min(self, o: Self) -> Self;

    /// The larger numbers. No lane may be NaN.
    fn max(self, o: Self) -> Self;

    /// Magnitudes.
    fn abs(self) -> Self;

    /// The lanes, a bit each, in which `self <= o`.
    fn le(self, o: Self) -> u8;

    /// The lanes, a bit each, in which `self < o`.
    fn lt(self, o: Self) -> u8;

    /// `self` where it is at least `least` away from zero; elsewhere `least` with its sign.
    fn away_from_zero(self, least: f32) -> Self;
}

/// Eight numbers as two vectors of four, which every machine has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halves(Vec4, Vec4);

impl Lanes for Halves {
    #[inline(always)]
    fn splat(v: f32) -> Self {
        Self(Vec4::splat(v), Vec4::splat(v))
    }

    #[inline(always)]
    fn new([a, b, c, d, e, f, g, h]: [f32; LANES]) -> Self {
        Self(Vec4::new(a, b, c, d), Vec4::new(e, f, g, h))
    }

    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        let ([a, b, c, d], [e, f, g, h]) = (self.0.to_array(), self.1.to_array());
        [a, b, c, d, e, f, g, h]
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(self.0.min(o.0), self.1.min(o.1))
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(self.0.max(o.0), self.1.max(o.1))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    #[inline(always)]
    fn le(self, o: Self) -> u8 {
        (self.0.cmple(o.0).bitmask() | self.1.cmple(o.1).bitmask() << 4) as u8
    }

    #[inline(always)]
    fn lt(self, o: Self) -> u8 {
        (self.0.cmplt(o.0).bitmask() | self.1.cmplt(o.1).bitmask() << 4) as u8
    }

    #[inline(always)]
    fn away_from_zero(self, least: f32) -> Self {
        let least = Vec4::splat(least);
        let half = |v: Vec4| Vec4::select(v.abs().cmplt(least), least.copysign(v), v);
        Self(half(self.0), half(self.1))
    }
}

impl Add for Halves {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
}

impl Sub for Halves {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1)
    }
}

impl Mul for Halves {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0, self.1 * o.1)
    }
}

impl Div for Halves {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        Self(self.0 / o.0, self.1 / o.1)
    }
}

/// Eight vectors. The operations are those of [`Vec3`], in their order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes3<L> {
    /// First components.
    pub x: L,
    /// Second components.
    pub y: L,
    /// Third components.
    pub z: L,
}

impl<L: Lanes> Lanes3<L> {
    /// Eight times the same vector.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self { x: L::splat(v.x), y: L::splat(v.y), z: L::splat(v.z) }
    }

    /// From lane 0 on.
    #[inline(always)]
    pub fn new(v: [Vec3; LANES]) -> Self {
        Self { x: L::new(v.map(|v| v.x)), y: L::new(v.map(|v| v.y)), z: L::new(v.map(|v| v.z)) }
    }

    /// [`Vec3::dot`].
    #[inline(always)]
    pub fn dot(self, o: Self) -> L {
        (self.x * o.x + self.y * o.y) + self.z * o.z
    }

    /// [`Vec3::cross`].
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self { x: self.y * o.z - self.z * o.y, y: self.z * o.x - self.x * o.z, z: self.x * o.y - self.y * o.x }
    }

    /// [`Vec3::max_abs`].
    #[inline(always)]
    pub fn max_abs(self) -> L {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }
}

impl<L: Lanes> Add for Lanes3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<L: Lanes> Sub for Lanes3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}
