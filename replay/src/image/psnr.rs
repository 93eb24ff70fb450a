//! Squared errors of 8-bit sRGB values, all three channels together, and what is made of them: peak signal-to-noise ratio, root
//! mean square. The errors are integers, so those of tiles and frames can be added.

use std::iter::Sum;
use std::ops::Add;

use super::Srgb8;
use crate::error::Result;

/// The squared error of some values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SquaredError {
    /// Sum of the squared differences.
    pub sum: u64,
    /// Number of values: three a pixel.
    pub values: u64,
}

impl SquaredError {
    /// PSNR in dB; `None` if nothing differs.
    pub fn decibels(self) -> Option<f64> {
        decibels(self.sum, self.values)
    }

    /// Root of the mean squared difference, 8-bit levels; 0 of no values.
    pub fn rms(self) -> f64 {
        (self.sum as f64 / self.values.max(1) as f64).sqrt()
    }

    /// Whether the mean is larger than that of `other`. Exact.
    pub fn is_worse_than(self, other: Self) -> bool {
        let mean = |a: Self, b: Self| u128::from(a.sum) * u128::from(b.values);
        mean(self, other) > mean(other, self)
    }
}

impl Add for SquaredError {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self { sum: self.sum + o.sum, values: self.values + o.values }
    }
}

impl Sum for SquaredError {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::default(), Add::add)
    }
}

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

    #[test]
    fn means_are_compared_not_sums() {
        let error = |sum, values| SquaredError { sum, values };
        assert!(error(10, 3).is_worse_than(error(30, 12)));
        assert!(!error(30, 12).is_worse_than(error(10, 4)), "the same mean is not worse");
        assert_eq!([error(27, 3).rms(), error(0, 0).rms()], [3.0, 0.0]);
        assert_eq!([error(1, 3), error(4, 6)].into_iter().sum::<SquaredError>(), error(5, 9));
    }
}
