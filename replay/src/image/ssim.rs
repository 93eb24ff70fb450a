//! Structural similarity after Wang et al. 2004: an 11 x 11 Gaussian window of sigma 1.5, K1 = 0.01, K2 = 0.03, L = 255, on
//! the BT.601 luma (0.299 R + 0.587 G + 0.114 B, not rounded) of the 8-bit sRGB values, averaged over all positions at which
//! the window lies inside the picture. No down-sampling.

use std::ops::Range;

use rayon::prelude::*;

use super::Srgb8;
use crate::error::Result;

/// Window edge in pixels.
const WINDOW: usize = 11;
/// Rows of window positions per task: memory stays small, and few rows are blurred twice.
const STRIP: usize = 64;
const SIGMA: f64 = 1.5;
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// Mean SSIM; 1 for identical pictures, `None` if the picture is smaller than the window.
///
/// # Errors
/// When the sizes differ.
pub fn ssim(a: &Srgb8, b: &Srgb8) -> Result<Option<f64>> {
    a.same_size(b)?;
    let (width, height) = (a.width as usize, a.height as usize);
    if width < WINDOW || height < WINDOW {
        return Ok(None);
    }
    // Equal pictures are common (`full` against itself). At each position both factors are exactly 1 then.
    if a.pixels == b.pixels {
        return Ok(Some(1.0));
    }
    let kernel = kernel();
    let positions = height - WINDOW + 1;
    let strip = |start: usize| strip_sums(&kernel, a, b, start..(start + STRIP).min(positions));
    let starts: Vec<usize> = (0..positions).step_by(STRIP).collect();
    let sums: Vec<Vec<f64>> = starts.into_par_iter().map(strip).collect();
    // Row sums are added in order: a parallel sum would depend on the threads.
    let sum: f64 = sums.iter().flatten().sum();
    Ok(Some(sum / ((width - WINDOW + 1) * positions) as f64))
}

/// SSIM sums of the rows of window positions in `rows`. Five moments per pixel are blurred along the rows, then down the
/// columns: the Gaussian is separable.
fn strip_sums(kernel: &[f64; WINDOW], a: &Srgb8, b: &Srgb8, rows: Range<usize>) -> Vec<f64> {
    let blurred: Vec<_> =
        (rows.start..rows.end + WINDOW - 1).map(|y| blur_row(kernel, &luma_row(a, y), &luma_row(b, y))).collect();
    (0..rows.len()).map(|y| row_sum(kernel, &blurred[y..y + WINDOW])).collect()
}

/// The window along one axis; its weights sum to 1.
fn kernel() -> [f64; WINDOW] {
    let raw: [f64; WINDOW] = std::array::from_fn(|i| {
        let d = i as f64 - (WINDOW / 2) as f64;
        libm::exp(-d * d / (2.0 * SIGMA * SIGMA))
    });
    let sum: f64 = raw.iter().sum();
    raw.map(|w| w / sum)
}

fn luma_row(image: &Srgb8, y: usize) -> Vec<f64> {
    let width = image.width as usize;
    let luma = |p: &[u8; 3]| 0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2]);
    image.pixels[y * width..][..width].iter().map(luma).collect()
}

/// Means of a, b, a^2, b^2 and ab along a row.
fn blur_row(kernel: &[f64; WINDOW], a: &[f64], b: &[f64]) -> Vec<[f64; 5]> {
    a.windows(WINDOW)
        .zip(b.windows(WINDOW))
        .map(|(a, b)| {
            let mut moments = [0.0; 5];
            for ((&w, &a), &b) in kernel.iter().zip(a).zip(b) {
                for (sum, value) in moments.iter_mut().zip([a, b, a * a, b * b, a * b]) {
                    *sum += w * value;
                }
            }
            moments
        })
        .collect()
}

/// Sum of the SSIM values of one row of window positions.
fn row_sum(kernel: &[f64; WINDOW], rows: &[Vec<[f64; 5]>]) -> f64 {
    let mut sum = 0.0;
    for x in 0..rows[0].len() {
        let mut moments = [0.0; 5];
        for (&w, row) in kernel.iter().zip(rows) {
            for (sum, value) in moments.iter_mut().zip(row[x]) {
                *sum += w * value;
            }
        }
        sum += of_moments(moments);
    }
    sum
}

fn of_moments([a, b, aa, bb, ab]: [f64; 5]) -> f64 {
    let (var_a, var_b, cov) = (aa - a * a, bb - b * b, ab - a * b);
    ((2.0 * a * b + C1) * (2.0 * cov + C2)) / ((a * a + b * b + C1) * (var_a + var_b + C2))
}

#[cfg(test)]
mod tests {
    use rayreel_testkit::Random;

    use super::*;

    fn noise(width: u32, height: u32, seed: u32, range: u32) -> Srgb8 {
        let mut random = Random(seed.into());
        let pixels = (0..width * height).map(|_| std::array::from_fn(|_| random.below(range) as u8)).collect();
        Srgb8 { width, height, pixels }
    }

    /// Without looking whether they are equal.
    #[test]
    fn a_picture_is_like_itself_to_the_last_bit() {
        for range in [2, 256] {
            let picture = noise(40, 31, 7, range);
            let rows = strip_sums(&kernel(), &picture, &picture, 0..21);
            assert_eq!(rows, [30.0; 21]);
            assert_eq!(ssim(&picture, &picture).unwrap(), Some(1.0));
        }
    }

    /// The formulas of the paper with the two-dimensional window, variances as means of squared differences.
    fn direct(a: &Srgb8, b: &Srgb8) -> f64 {
        let luma = |image: &Srgb8| (0..image.height as usize).flat_map(|y| luma_row(image, y)).collect::<Vec<_>>();
        let (x, y) = (luma(a), luma(b));
        let (width, height) = (a.width as usize, a.height as usize);
        let mut weights = Vec::new();
        for dy in 0..11 {
            for dx in 0..11 {
                let (ex, ey) = (f64::from(dx) - 5.0, f64::from(dy) - 5.0);
                weights.push((dx as usize, dy as usize, (-(ex * ex + ey * ey) / 4.5).exp()));
            }
        }
        let total: f64 = weights.iter().map(|w| w.2).sum();
        let (mut sum, mut count) = (0.0, 0.0);
        for top in 0..=height - 11 {
            for left in 0..=width - 11 {
                let at = |v: &[f64], dx, dy| v[(top + dy) * width + left + dx];
                let mean = |f: &dyn Fn(usize, usize) -> f64| {
                    weights.iter().map(|&(dx, dy, w)| w * f(dx, dy)).sum::<f64>() / total
                };
                let (mx, my) = (mean(&|dx, dy| at(&x, dx, dy)), mean(&|dx, dy| at(&y, dx, dy)));
                let vx = mean(&|dx, dy| (at(&x, dx, dy) - mx).powi(2));
                let vy = mean(&|dx, dy| (at(&y, dx, dy) - my).powi(2));
                let cov = mean(&|dx, dy| (at(&x, dx, dy) - mx) * (at(&y, dx, dy) - my));
                sum += (2.0 * mx * my + 6.5025) * (2.0 * cov + 58.5225)
                    / ((mx * mx + my * my + 6.5025) * (vx + vy + 58.5225));
                count += 1.0;
            }
        }
        sum / count
    }

    #[test]
    fn equals_the_direct_form() {
        for (width, height) in [(11, 11), (17, 13), (24, 31), (13, 90)] {
            let a = noise(width, height, 1, 256);
            let mut near = a.clone();
            near.pixels.iter_mut().step_by(3).for_each(|p| p[1] = p[1].saturating_add(20));
            for b in [near, noise(width, height, 2, 256), noise(width, height, 3, 20)] {
                let (fast, slow) = (ssim(&a, &b).unwrap().unwrap(), direct(&a, &b));
                assert!((fast - slow).abs() < 1.0e-9, "{fast} {slow}");
            }
        }
    }

    #[test]
    fn identical_is_one_and_small_is_none() {
        let a = noise(20, 12, 5, 256);
        assert_eq!(ssim(&a, &a).unwrap(), Some(1.0));
        let small = noise(10, 40, 5, 256);
        assert_eq!(ssim(&small, &small).unwrap(), None);
        assert!(ssim(&a, &small).is_err());
    }
}
