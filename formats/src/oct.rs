//! Unit vectors in 32 bits: the octahedral map of Meyer et al. 2010, 2 x 16 bit.
//!
//! Shading normals are quantised by this map *before* a secondary ray leaves the surface, so the trace holds exactly
//! the normal that the tracer used.

use crate::math::{Vec3, vec3};

/// Largest code of one axis. It is even, so that zero has a code of its own and axis-aligned normals are exact.
const STEPS: f32 = 65534.0;

/// An octahedrally coded unit vector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bincode::Encode, bincode::Decode)]
pub struct Oct {
    /// Code of the first axis, 0 to 65534 for -1 to 1.
    pub u: u16,
    /// Code of the second axis.
    pub v: u16,
}

impl Oct {
    /// The code nearest to the direction of `n`. `n` need not have unit length; a zero or non-finite vector gives +z.
    #[inline]
    pub fn encode(n: Vec3) -> Self {
        let sum = (n.x.abs() + n.y.abs()) + n.z.abs();
        if !(sum > 0.0 && sum < f32::INFINITY) {
            return Self::encode(vec3(0.0, 0.0, 1.0));
        }
        let (mut x, mut y) = (n.x / sum, n.y / sum);
        if n.z < 0.0 {
            (x, y) = fold(x, y);
        }
        Self { u: quantise(x), v: quantise(y) }
    }

    /// The unit vector of this code, by the same operations on every machine.
    #[inline]
    pub fn decode(self) -> Vec3 {
        let mut x = f32::from(self.u) / STEPS * 2.0 - 1.0;
        let mut y = f32::from(self.v) / STEPS * 2.0 - 1.0;
        let z = (1.0 - x.abs()) - y.abs();
        if z < 0.0 {
            (x, y) = fold(x, y);
        }
        vec3(x, y, z).normalized()
    }

    /// Both codes in one word, `u` in the low half.
    pub fn to_bits(self) -> u32 {
        u32::from(self.u) | u32::from(self.v) << 16
    }

    /// The inverse of [`Oct::to_bits`].
    pub fn from_bits(bits: u32) -> Self {
        Self { u: bits as u16, v: (bits >> 16) as u16 }
    }
}

/// Mirrors the lower half of the octahedron over the diagonals.
#[inline]
fn fold(x: f32, y: f32) -> (f32, f32) {
    let sign = |v: f32| if v < 0.0 { -1.0 } else { 1.0 };
    ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
}

#[inline]
fn quantise(v: f32) -> u16 {
    // The cast truncates towards zero and saturates.
    ((v * 0.5 + 0.5) * STEPS + 0.5) as u16
}

#[cfg(test)]
mod tests {
    use rayreel_testkit::Random;

    use super::*;

    #[test]
    fn axes_are_exact() {
        for axis in [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)] {
            for n in [axis, -axis] {
                assert_eq!(Oct::encode(n).decode(), n);
            }
        }
    }

    #[test]
    fn error_is_below_a_hundredth_of_a_degree_and_codes_are_stable() {
        let mut random = Random(1);
        for _ in 0..100_000 {
            let n = vec3(random.signed(), random.signed(), random.signed());
            if n.length() < 0.01 {
                continue;
            }
            let code = Oct::encode(n);
            let back = code.decode();
            let sine = back.cross(n.normalized()).length();
            assert!(sine < 1.0e-4, "{n:?} came back as {back:?}");
            assert_eq!(Oct::from_bits(code.to_bits()), code);
        }
    }
}
