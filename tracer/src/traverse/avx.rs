//! Eight numbers in one vector, on processors that have AVX.
//!
//! With packets in two halves plain tracing takes 1.3 times as long. Safety: a value of [`Avx`] is made and used only below
//! [`packet`](super::TraversalBvh::packet), which asks the processor first. Nothing outside of this folder can name it, and must not:
//! its functions are safe to call only there. They are inlined into one that is compiled for AVX2; outside of it each would be a call.

#![expect(unsafe_code, reason = "measured: see above")]

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

use super::lanes::{LANES, Lanes};

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx(__m256);

impl Lanes for Avx {
    #[inline(always)]
    fn splat(v: f32) -> Self {
        // SAFETY: see the head of the file.
        Self(unsafe { _mm256_set1_ps(v) })
    }

    #[inline(always)]
    fn new(v: [f32; LANES]) -> Self {
        // SAFETY: see the head of the file; `v` is as long as the vector, and may lie anywhere.
        Self(unsafe { _mm256_loadu_ps(v.as_ptr()) })
    }

    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        let mut v = [0.0; LANES];
        // SAFETY: see the head of the file; `v` is as long as the vector, and may lie anywhere.
        unsafe { _mm256_storeu_ps(v.as_mut_ptr(), self.0) };
        v
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        // SAFETY: see the head of the file.
        Self(unsafe { _mm256_min_ps(self.0, o.0) })
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        // SAFETY: see the head of the file.
        Self(unsafe { _mm256_max_ps(self.0, o.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see the head of the file.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    #[inline(always)]
    fn le(self, o: Self) -> u8 {
        // SAFETY: see the head of the file.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, o.0)) as u8 }
    }

    #[inline(always)]
    fn lt(self, o: Self) -> u8 {
        // SAFETY: see the head of the file.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, o.0)) as u8 }
    }

    #[inline(always)]
    fn away_from_zero(self, least: f32) -> Self {
        let (least, v) = (Self::splat(least), self.0);
        // SAFETY: see the head of the file.
        Self(unsafe {
            let small = _mm256_cmp_ps::<_CMP_LT_OQ>(self.abs().0, least.0);
            let signed = _mm256_or_ps(least.0, _mm256_and_ps(v, _mm256_set1_ps(-0.0)));
            _mm256_blendv_ps(v, signed, small)
        })
    }
}

impl Add for Avx {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        // SAFETY: see the head of the file.
        Self(unsafe { _mm256_add_ps(self.0, o.0) })
    }
}

impl Sub for Avx {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        // SAFETY: see the head of the file.
        Self(unsafe { _mm256_sub_ps(self.0, o.0) })
    }
}

impl Mul for Avx {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        // SAFETY: see the head of the file.
        Self(unsafe { _mm256_mul_ps(self.0, o.0) })
    }
}

impl Div for Avx {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        // SAFETY: see the head of the file.
        Self(unsafe { _mm256_div_ps(self.0, o.0) })
    }
}
