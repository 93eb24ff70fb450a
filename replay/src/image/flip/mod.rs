//! FLIP after Andersson et al. 2020 (FLIP: A Difference Evaluator for Alternating Images), for pictures of low dynamic range:
//! how much a viewer sees when result and reference are shown in turn, from 0 to 1 for each pixel.
//!
//! ```text
//! sRGB -> YCxCz -> blurred as the eye blurs (contrast sensitivity) -> CIELab, Hunt -> HyAB distance -> colour difference c
//! luminance -> first and second derivative at the scale of visible edges -> feature difference f
//! FLIP = c ^ (1 - f)
//! ```
//!
//! The picture's figure is the mean over its pixels. NVIDIA's own code is C++ whose powers come from the platform, so its last
//! digits differ from machine to machine; this is an implementation of the paper that takes powers from the libm crate and
//! never sums across threads. A test holds it to values of NVIDIA's code.

mod colour;
mod filters;
mod strip;

use std::f64::consts::PI;

use rayon::prelude::*;

use self::filters::Filters;
use super::Srgb8;
use crate::error::Result;

/// Pixels per degree of visual angle unless told otherwise: the paper's viewer, 0.7 m before a screen of 0.7 m and 3840 pixels.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 / 0.7 * 0.7 * (PI / 180.0);

/// Rows per task. Memory stays small, and few rows are filtered twice.
const STRIP: usize = 64;

/// The FLIP value of each pixel, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 0 (no difference seen) to 1.
    pub values: Vec<f32>,
}

impl FlipMap {
    /// The mean; 0 of no pixels. Rows are summed one by one: the order does not depend on threads.
    pub fn mean(&self) -> f64 {
        let rows = self.values.chunks_exact((self.width as usize).max(1));
        let sum: f64 = rows.map(|row| row.iter().copied().map(f64::from).sum::<f64>()).sum();
        sum / self.values.len().max(1) as f64
    }
}

/// The FLIP map of two pictures seen at `pixels_per_degree`. The order of the pictures does not matter.
///
/// # Errors
/// When the sizes differ.
///
/// # Panics
/// When `pixels_per_degree` is not from 1 to 1000: no screen is seen so, and the filters grow with it.
pub fn flip(a: &Srgb8, b: &Srgb8, pixels_per_degree: f64) -> Result<FlipMap> {
    assert!((1.0..=1000.0).contains(&pixels_per_degree), "{pixels_per_degree} pixels per degree");
    a.same_size(b)?;
    let mut values = vec![0.0; a.pixels.len()];
    // Equal pictures are common (`full` against itself), and cost nothing.
    if a.pixels != b.pixels {
        let filters = Filters::new(pixels_per_degree);
        let strips = values.par_chunks_mut(a.width as usize * STRIP).enumerate();
        strips.for_each(|(i, out)| strip::strip(&filters, [a, b], i * STRIP, out));
    }
    Ok(FlipMap { width: a.width, height: a.height, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_viewer() {
        assert!((PIXELS_PER_DEGREE - 67.0206).abs() < 1.0e-4);
    }

    #[test]
    fn means_and_sizes() {
        let map = FlipMap { width: 2, height: 2, values: vec![0.0, 0.25, 0.5, 1.0] };
        assert_eq!(map.mean(), 0.4375);
        assert_eq!(FlipMap { width: 0, height: 0, values: Vec::new() }.mean(), 0.0);
        let picture = |width, height| Srgb8 { width, height, pixels: vec![[9; 3]; 6] };
        assert!(flip(&picture(2, 3), &picture(3, 2), PIXELS_PER_DEGREE).is_err());
        assert_eq!(flip(&picture(2, 3), &picture(2, 3), PIXELS_PER_DEGREE).unwrap().values, [0.0; 6]);
    }
}
