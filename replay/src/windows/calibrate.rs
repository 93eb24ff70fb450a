//! From windows to a frame: weights of the windows, such that they stand for all tiles.
//!
//! What a window measures is characterised by features ([`Features`]): its size, and rates such as misses or triangle tests for
//! each unit of size. The same is known of the frame, from the functional pass. The weights are those of regression estimation
//! (Deville and Särndal 1992): proportional to size, and corrected as far as the windows' rates differ from the frame's, by a
//! regression on the rates. They do not depend on what is estimated, so one set serves all counters, and sums that hold in each
//! window hold in the estimate. Rates pull less where windows are few (a ridge), and there are fewer of them.

use rayreel_machine::functional::Features;

/// Rates in order of use, as places among the features: cycles as the pass takes them to be, lines of DRAM, triangle tests, SRP
/// cycles, misses of traversal and of intersection units, rays.
const RATES: [usize; 7] = [8, 4, 1, 5, 2, 3, 6];

/// Windows that a rate takes to be used.
const WINDOWS_A_RATE: usize = 12;

/// How much rates are kept from pulling, as a part of their variance.
const RIDGE: f64 = 0.05;

/// How many rates the weights of so many windows use.
pub fn rates_used(windows: usize) -> usize {
    RATES.len().min(windows / WINDOWS_A_RATE)
}

/// The weights of windows of the features `windows` that stand for `total`, by size and the first `used` rates.
pub fn weights(windows: &[Features], total: &Features, used: usize) -> Vec<f64> {
    let size: f64 = windows.iter().map(Features::size).sum();
    if size <= 0.0 || total.size() <= 0.0 {
        return vec![0.0; windows.len()];
    }
    let used = &RATES[..used];
    let rates = |features: &Features| -> Vec<f64> {
        used.iter().map(|&feature| features.0[feature] / features.size().max(1.0)).collect()
    };
    let mut sum = Features::default();
    windows.iter().for_each(|window| sum.add_part(window, 1.0));
    let mean = rates(&sum);
    let apart: Vec<Vec<f64>> = windows
        .iter()
        .map(|window| rates(window).iter().zip(&mean).map(|(rate, mean)| rate - mean).collect())
        .collect();
    let pull = solve(covariance(windows, &apart, &mean), difference(&rates(total), &mean));
    let scale = total.size() / size;
    let dot = |a: &[f64]| a.iter().zip(&pull).map(|(a, b)| a * b).sum::<f64>();
    apart.iter().map(|apart| scale * (1.0 + dot(apart))).collect()
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The covariance of the rates, windows weighted by size, with the ridge.
fn covariance(windows: &[Features], apart: &[Vec<f64>], mean: &[f64]) -> Vec<Vec<f64>> {
    let count = mean.len();
    let size: f64 = windows.iter().map(Features::size).sum();
    let mut matrix = vec![vec![0.0; count]; count];
    for (window, apart) in windows.iter().zip(apart) {
        let part = window.size() / size;
        for (row, a) in matrix.iter_mut().zip(apart) {
            row.iter_mut().zip(apart).for_each(|(cell, b)| *cell += part * a * b);
        }
    }
    for (i, mean) in mean.iter().enumerate() {
        // A rate that is the same everywhere has no variance and must not pull at all.
        matrix[i][i] += RIDGE * matrix[i][i] + 1e-9 * mean * mean + f64::MIN_POSITIVE;
    }
    matrix
}

/// Solves a positive definite system by elimination.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let count = right.len();
    for i in 0..count {
        let (above, below) = matrix.split_at_mut(i + 1);
        for (row, number) in below.iter_mut().zip(i + 1..) {
            let factor = row[i] / above[i][i];
            row.iter_mut().zip(&above[i]).skip(i).for_each(|(cell, pivot)| *cell -= factor * pivot);
            right[number] -= factor * right[i];
        }
    }
    for i in (0..count).rev() {
        let known: f64 = (i + 1..count).map(|column| matrix[i][column] * right[column]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    right
}

#[cfg(test)]
mod tests {
    use rayreel_machine::functional::FEATURES;

    use super::*;

    /// Windows of made-up features, and what each measures: a given mixture of them.
    fn windows(count: usize, mixture: [f64; FEATURES]) -> Vec<(Features, f64)> {
        let mut random = 1u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 40) as f64 / f64::from(1 << 24)
        };
        let mut window = || {
            let size = 1e5 * (0.5 + next());
            let features = Features(
                [1.0, 0.3, 0.1, 0.05, 0.2, 0.7, 0.02, 0.0, 0.6]
                    .map(|rate| size * if rate < 1.0 { rate * (0.5 + next()) } else { rate }),
            );
            (features, features.0.iter().zip(mixture).map(|(a, b)| a * b).sum())
        };
        (0..count).map(|_| window()).collect()
    }

    fn estimate(windows: &[(Features, f64)], total: &Features) -> f64 {
        let features: Vec<Features> = windows.iter().map(|window| window.0).collect();
        weights(&features, total, rates_used(windows.len()))
            .iter()
            .zip(windows)
            .map(|(weight, window)| weight * window.1)
            .sum()
    }

    #[test]
    fn sizes_are_met_exactly() {
        let all = windows(300, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let mut total = Features::default();
        all.iter().for_each(|window| total.add_part(&window.0, 1.0));
        let sampled: Vec<_> = all.iter().step_by(10).copied().collect();
        assert!((estimate(&sampled, &total) / total.size() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_depends_on_the_rates_is_estimated_better_than_by_size_alone() {
        let all = windows(600, [0.5, 1.5, 4.0, 2.0, 3.0, 0.1, 0.0, 0.0, 1.0]);
        let mut total = Features::default();
        all.iter().for_each(|window| total.add_part(&window.0, 1.0));
        let truth: f64 = all.iter().map(|window| window.1).sum();
        let (mut by_rates, mut by_size) = (0.0, 0.0);
        for first in 0..6 {
            let sampled: Vec<_> = all.iter().skip(first).step_by(6).copied().collect();
            let size: f64 = sampled.iter().map(|window| window.0.size()).sum();
            let sum: f64 = sampled.iter().map(|window| window.1).sum();
            by_size += (sum * total.size() / size / truth - 1.0).powi(2);
            by_rates += (estimate(&sampled, &total) / truth - 1.0).powi(2);
        }
        assert!(by_rates < 0.05 * by_size, "{by_rates} and {by_size}");
    }

    #[test]
    fn few_windows_count_by_size() {
        let all = windows(3, [1.0; FEATURES]);
        let total = all[0].0;
        let features: Vec<Features> = all.iter().map(|window| window.0).collect();
        let weights = weights(&features, &total, rates_used(3));
        assert!(weights.windows(2).all(|pair| pair[0] == pair[1]));
    }

    #[test]
    fn windows_without_work_stand_for_nothing() {
        assert_eq!(weights(&[Features::default(); 5], &Features::default(), 1), [0.0; 5]);
    }
}
