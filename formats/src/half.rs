//! Colours and weights as half floats.
//!
//! The tracer rounds every local colour and every child weight to half precision *before* it composites, so an image
//! composed from a trace equals the tracer's own to the last bit.

use crate::math::{Vec3, vec3};
use ::half::f16;

/// Largest finite half float.
const MAX: f32 = 65504.0;

/// A non-negative RGB triple in half precision, as bit patterns. For such values the patterns sort like the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Half3(pub [u16; 3]);

impl Half3 {
    /// Black, or a weight of nothing.
    pub const ZERO: Self = Self([0; 3]);

    /// Rounds to nearest even; negative values and NaN become zero, large ones the largest finite half.
    #[inline]
    pub fn from_vec3(v: Vec3) -> Self {
        let pack = |x: f32| if x > 0.0 { f16::from_f32_const(if x < MAX { x } else { MAX }).to_bits() } else { 0 };
        Self([pack(v.x), pack(v.y), pack(v.z)])
    }

    /// The exact values.
    #[inline]
    pub fn to_vec3(self) -> Vec3 {
        let unpack = |bits| f16::from_bits(bits).to_f32_const();
        vec3(unpack(self.0[0]), unpack(self.0[1]), unpack(self.0[2]))
    }

    /// True when every pattern is a non-negative finite number.
    pub fn is_valid(self) -> bool {
        self.0.iter().all(|&bits| bits < 0x7c00)
    }
}
