//! The one-dimensional filters that make up FLIP's two-dimensional ones: all are separable, the blue-yellow one as a sum of two.

use std::f64::consts::PI;

/// Contrast sensitivity of the paper's table 1: a sum of Gaussians, each with amplitude and squared width in degrees.
const ACHROMATIC: (f64, f64) = (1.0, 0.0047);
const RED_GREEN: (f64, f64) = (1.0, 0.0053);
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// Width of the smallest feature that a viewer sees, degrees.
const FEATURE: f64 = 0.082;

/// All filters for a viewer. Weights are f32: so are the pictures that they filter.
pub struct Filters {
    /// Blur of Y, Cx, Cz and Cz: the two blurs of Cz are added after both axes are done.
    pub blur: [Vec<f32>; 4],
    /// Gaussian at the scale of features.
    pub gauss: Vec<f32>,
    /// Its first derivative: edges.
    pub edge: Vec<f32>,
    /// Its second derivative: points.
    pub point: Vec<f32>,
}

impl Filters {
    /// The filters for a number of pixels per degree.
    pub fn new(ppd: f64) -> Self {
        let [achromatic, red_green] = [ACHROMATIC, RED_GREEN].map(|of| sampled(of, ppd));
        let blue_yellow = BLUE_YELLOW.map(|of| sampled(of, ppd));
        // The two-dimensional weights, products of these, must sum to 1 for both Gaussians together.
        let both = blue_yellow.iter().map(|w| sum(w) * sum(w)).sum::<f64>().sqrt();
        let [wide, narrow] = blue_yellow.map(|w| scaled(&w, both));
        let (gauss, edge, point) = features(ppd);
        let blur = [scaled(&achromatic, sum(&achromatic)), scaled(&red_green, sum(&red_green)), wide, narrow];
        Self { blur, gauss, edge, point }
    }

    /// Pixels to each side that the blurs reach.
    pub fn blur_radius(&self) -> usize {
        self.blur[0].len() / 2
    }

    /// Pixels to each side that the feature filters reach.
    pub fn feature_radius(&self) -> usize {
        self.gauss.len() / 2
    }
}

/// One axis of a Gaussian of the contrast sensitivity, taken from frequencies to degrees, so long that the widest fits.
fn sampled((amplitude, width): (f64, f64), ppd: f64) -> Vec<f64> {
    let widest = BLUE_YELLOW[0].1;
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i32;
    let height = (amplitude * (PI / width).sqrt()).sqrt();
    let weight = |i: i32| {
        let x = f64::from(i) / ppd;
        height * libm::exp(-PI * PI * x * x / width)
    };
    (-radius..=radius).map(weight).collect()
}

/// Gaussian and its derivatives. Positive and negative weights of a derivative sum to 1 and -1.
fn features(ppd: f64) -> (Vec<f32>, Vec<f32>, Vec<f32>) {
    let deviation = 0.5 * FEATURE * ppd;
    let radius = (3.0 * deviation).ceil() as i32;
    let taps = || (-radius..=radius).map(f64::from);
    let gauss = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
    let bell: Vec<f64> = taps().map(gauss).collect();
    let edge: Vec<f64> = taps().map(|x| -x * gauss(x)).collect();
    let point: Vec<f64> = taps().map(|x| (x * x / (deviation * deviation) - 1.0) * gauss(x)).collect();
    (scaled(&bell, sum(&bell)), balanced(&edge), balanced(&point))
}

fn sum(weights: &[f64]) -> f64 {
    weights.iter().sum()
}

fn scaled(weights: &[f64], by: f64) -> Vec<f32> {
    weights.iter().map(|w| (w / by) as f32).collect()
}

fn balanced(weights: &[f64]) -> Vec<f32> {
    let positive: f64 = weights.iter().map(|w| w.max(0.0)).sum();
    let negative: f64 = weights.iter().map(|w| (-w).max(0.0)).sum();
    weights.iter().map(|&w| (if w > 0.0 { w / positive } else { w / negative }) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(weights: &[f32]) -> f64 {
        weights.iter().copied().map(f64::from).sum()
    }

    #[test]
    fn weights_sum_to_what_they_must() {
        for ppd in [20.0, 67.0206, 120.0] {
            let filters = Filters::new(ppd);
            let [y, cx, wide, narrow] = filters.blur.each_ref().map(|w| total(w));
            let cz = wide * wide + narrow * narrow;
            for one in [y, cx, cz, total(&filters.gauss)] {
                assert!((one - 1.0).abs() < 1.0e-6, "{one}");
            }
            for derivative in [&filters.edge, &filters.point] {
                assert!(total(derivative).abs() < 1.0e-6, "flat areas have no features");
                let positive: f64 = derivative.iter().map(|&w| f64::from(w.max(0.0))).sum();
                assert!((positive - 1.0).abs() < 1.0e-6);
            }
        }
    }

    #[test]
    fn reach_for_the_default_viewer() {
        let filters = Filters::new(super::super::PIXELS_PER_DEGREE);
        assert_eq!((filters.blur_radius(), filters.feature_radius()), (10, 9));
    }
}
