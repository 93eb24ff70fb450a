//! Eight numbers side by side, one a ray.
//!
//! Each lane is the scalar IEEE operation in the order that the code says, and nothing is summed or compared across
//! lanes. So a lane gives the bits that scalar code would, on every machine.

use std::ops::{Add, Div, Mul, Sub};

use glam::Vec4;
use rayreel_formats::math::Vec3;

/// Rays in a packet.
pub const LANES: usize = 8;

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub struct Lanes(Vec4, Vec4);

impl Lanes {
    /// All zero.
    pub const ZERO: Self = Self(Vec4::ZERO, Vec4::ZERO);

    /// Eight times the same number.
    #[inline(always)]
    pub fn splat(v: f32) -> Self {
        Self(Vec4::splat(v), Vec4::splat(v))
    }

    /// From lane 0 on.
    #[inline(always)]
    pub fn new([a, b, c, d, e, f, g, h]: [f32; LANES]) -> Self {
        Self(Vec4::new(a, b, c, d), Vec4::new(e, f, g, h))
    }

    /// From lane 0 on.
    #[inline(always)]
    pub fn to_array(self) -> [f32; LANES] {
        let ([a, b, c, d], [e, f, g, h]) = (self.0.to_array(), self.1.to_array());
        [a, b, c, d, e, f, g, h]
    }

    /// The smaller numbers. No lane may be NaN.
    #[inline(always)]
    pub fn min(self, o: Self) -> Self {
        Self(self.0.min(o.0), self.1.min(o.1))
    }

    /// The larger numbers. No lane may be NaN.
    #[inline(always)]
    pub fn max(self, o: Self) -> Self {
        Self(self.0.max(o.0), self.1.max(o.1))
    }

    /// Magnitudes.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    /// The lanes, a bit each, in which `self <= o`.
    #[inline(always)]
    pub fn le(self, o: Self) -> u8 {
        (self.0.cmple(o.0).bitmask() | self.1.cmple(o.1).bitmask() << 4) as u8
    }

    /// The lanes, a bit each, in which `self < o`.
    #[inline(always)]
    pub fn lt(self, o: Self) -> u8 {
        (self.0.cmplt(o.0).bitmask() | self.1.cmplt(o.1).bitmask() << 4) as u8
    }

    /// `self` where it is at least `least` away from zero; elsewhere `least` with its sign.
    #[inline(always)]
    pub fn away_from_zero(self, least: f32) -> Self {
        let least = Vec4::splat(least);
        let half = |v: Vec4| Vec4::select(v.abs().cmplt(least), least.copysign(v), v);
        Self(half(self.0), half(self.1))
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0, self.1 * o.1)
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        Self(self.0 / o.0, self.1 / o.1)
    }
}

/// Eight vectors. The operations are those of [`Vec3`], in their order.
#[derive(Clone, Copy, Debug)]
pub struct Lanes3 {
    /// First components.
    pub x: Lanes,
    /// Second components.
    pub y: Lanes,
    /// Third components.
    pub z: Lanes,
}

impl Lanes3 {
    /// Eight times the same vector.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self { x: Lanes::splat(v.x), y: Lanes::splat(v.y), z: Lanes::splat(v.z) }
    }

    /// From lane 0 on.
    #[inline(always)]
    pub fn new(v: [Vec3; LANES]) -> Self {
        Self { x: Lanes::new(v.map(|v| v.x)), y: Lanes::new(v.map(|v| v.y)), z: Lanes::new(v.map(|v| v.z)) }
    }

    /// [`Vec3::dot`].
    #[inline(always)]
    pub fn dot(self, o: Self) -> Lanes {
        (self.x * o.x + self.y * o.y) + self.z * o.z
    }

    /// [`Vec3::cross`].
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self { x: self.y * o.z - self.z * o.y, y: self.z * o.x - self.x * o.z, z: self.x * o.y - self.y * o.x }
    }

    /// [`Vec3::max_abs`].
    #[inline(always)]
    pub fn max_abs(self) -> Lanes {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }
}

impl Add for Lanes3 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl Sub for Lanes3 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}
