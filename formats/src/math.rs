//! Scalar vector arithmetic in a written order.
//!
//! Every ray is rebuilt from the trace by the very operations that made it, on any machine. So this module uses only
//! scalar `+ - * / sqrt`, which IEEE 754 defines to the last bit, and never a SIMD reduction, a fused multiply-add or
//! libm. glam's `dot` and `normalize` differ between targets and are not used where a result depends on them.

use std::ops::{Add, Mul, Neg, Sub};

/// A vector of three `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bincode::Encode, bincode::Decode)]
pub struct Vec3 {
    /// First component.
    pub x: f32,
    /// Second component.
    pub y: f32,
    /// Third component.
    pub z: f32,
}

/// Short for [`Vec3::new`].
#[inline(always)]
pub const fn vec3(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3 { x, y, z }
}

impl Vec3 {
    /// The origin.
    pub const ZERO: Self = vec3(0.0, 0.0, 0.0);
    /// All ones: white, or no attenuation.
    pub const ONE: Self = vec3(1.0, 1.0, 1.0);

    /// A vector of three components.
    pub const fn new(x: f32, y: f32, z: f32) -> Self {
        Self { x, y, z }
    }

    /// Three equal components.
    #[inline(always)]
    pub const fn splat(v: f32) -> Self {
        Self { x: v, y: v, z: v }
    }

    /// `(x * x' + y * y') + z * z'`, in this order.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f32 {
        (self.x * other.x + self.y * other.y) + self.z * other.z
    }

    /// The cross product, each component one subtraction of two products: `a.cross(b) == -(b.cross(a))` to the last
    /// bit.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Euclidean length.
    #[inline(always)]
    pub fn length(self) -> f32 {
        self.dot(self).sqrt()
    }

    /// The vector divided by its length, component by component. A zero vector gives NaN: callers check.
    #[inline(always)]
    pub fn normalized(self) -> Self {
        let length = self.length();
        Self { x: self.x / length, y: self.y / length, z: self.z / length }
    }

    /// Component-wise product.
    #[inline(always)]
    pub fn times(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }

    /// Component-wise minimum.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        let m = |a: f32, b: f32| if a < b { a } else { b };
        Self { x: m(self.x, other.x), y: m(self.y, other.y), z: m(self.z, other.z) }
    }

    /// Component-wise maximum.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        let m = |a: f32, b: f32| if a > b { a } else { b };
        Self { x: m(self.x, other.x), y: m(self.y, other.y), z: m(self.z, other.z) }
    }

    /// The largest component.
    #[inline(always)]
    pub fn max_component(self) -> f32 {
        let m = |a: f32, b: f32| if a > b { a } else { b };
        m(m(self.x, self.y), self.z)
    }

    /// The largest absolute component.
    #[inline(always)]
    pub fn max_abs(self) -> f32 {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }.max_component()
    }

    /// True when no component is NaN or infinite.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }

    /// The components in order.
    pub const fn to_array(self) -> [f32; 3] {
        [self.x, self.y, self.z]
    }
}

impl From<[f32; 3]> for Vec3 {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}

impl Add for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl Sub for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl Mul<f32> for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f32) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

impl Neg for Vec3 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
