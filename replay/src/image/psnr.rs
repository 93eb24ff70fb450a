//! Peak signal-to-noise ratio on 8-bit sRGB values, all three channels together.

use super::Srgb8;
use crate::error::Result;

/// Sum of the squared differences of all values. Exact: sums of several frames can be added.
///
/// # Errors
/// When the sizes differ.
pub fn squared_error(a: &Srgb8, b: &Srgb8) -> Result<u64> {
    a.same_size(b)?;
    Ok(a.bytes().iter().zip(b.bytes()).map(|(&a, &b)| u64::from(a.abs_diff(b)).pow(2)).sum())
}

/// PSNR in dB of `values` values with this squared error: 10 log10(255^2 / mean). `None` for identical pictures, whose ratio
/// is infinite.
pub fn decibels(squared_error: u64, values: u64) -> Option<f64> {
    (squared_error > 0).then(|| 10.0 * libm::log10(255.0 * 255.0 * values as f64 / squared_error as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let image = |v: u8| Srgb8 { width: 2, height: 1, pixels: vec![[v, 0, 255], [7, v, 9]] };
        assert_eq!(squared_error(&image(10), &image(16)).unwrap(), 72);
        assert_eq!(decibels(0, 6), None);
        // A difference of 255 everywhere is 0 dB, of 25.5 20 dB.
        assert_eq!(decibels(255 * 255 * 6, 6), Some(0.0));
        let db = decibels(65_025, 100).unwrap();
        assert!((db - 20.0).abs() < 1.0e-12, "{db}");
        let other = Srgb8 { width: 1, height: 2, pixels: vec![[0; 3]; 2] };
        assert!(squared_error(&image(1), &other).is_err());
    }
}
