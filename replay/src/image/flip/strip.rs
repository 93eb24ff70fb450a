//! A strip of rows: filters along the rows, then down the columns, then the pixels' values.
//!
//! Each value is a sum over taps in their order, whichever thread makes it; neighbouring values are independent, so the compiler
//! works on several at a time without changing any.

use super::colour::{log_difference, perceived, ycxcz};
use super::filters::Filters;
use crate::image::Srgb8;

/// Rows of a picture's strip, filtered along the rows, one plane after the other: the four blurs, then edge, point and Gaussian.
struct Rows {
    width: usize,
    planes: [Vec<f32>; 7],
}

/// FLIP values of the rows of `out`, the first of which is row `top` of the pictures.
pub fn strip(filters: &Filters, pictures: [&Srgb8; 2], top: usize, out: &mut [f32]) {
    let (width, height) = (pictures[0].width as usize, pictures[0].height as usize);
    let radius = filters.blur_radius().max(filters.feature_radius());
    let count = out.len() / width;
    let rows = pictures.map(|picture| Rows::new(filters, picture, top as isize - radius as isize, count + 2 * radius));
    debug_assert!(top + count <= height, "the strip ends below the picture");
    let mut columns = [Columns::new(width), Columns::new(width)];
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        for (columns, rows) in columns.iter_mut().zip(&rows) {
            columns.filter(filters, rows, y + radius);
        }
        for (x, out) in out.iter_mut().enumerate() {
            *out = value(&columns[0], &columns[1], x);
        }
    }
}

impl Rows {
    /// `count` rows from `first` on; rows and columns outside the picture repeat its edge.
    fn new(filters: &Filters, picture: &Srgb8, first: isize, count: usize) -> Self {
        let (width, height) = (picture.width as usize, picture.height as usize);
        let radius = filters.blur_radius().max(filters.feature_radius());
        let mut padded: [Vec<f32>; 4] = std::array::from_fn(|_| vec![0.0; width + 2 * radius]);
        let mut rows = Self { width, planes: std::array::from_fn(|_| vec![0.0; width * count]) };
        for i in 0..count {
            let y = (first + i as isize).clamp(0, height as isize - 1) as usize;
            let source = &picture.pixels[y * width..][..width];
            convert(source, radius, &mut padded);
            let [luma, cx, cz, luminance] = &padded;
            let [y_blur, cx_blur, wide, narrow] = &filters.blur;
            let jobs = [
                (y_blur, luma),
                (cx_blur, cx),
                (wide, cz),
                (narrow, cz),
                (&filters.edge, luminance),
                (&filters.point, luminance),
                (&filters.gauss, luminance),
            ];
            for (plane, (weights, source)) in rows.planes.iter_mut().zip(jobs) {
                let source = &source[radius - weights.len() / 2..];
                along(weights, source, &mut plane[i * width..][..width]);
            }
        }
        rows
    }
}

/// Y, Cx, Cz and luminance of a row, its ends repeated `radius` times.
fn convert(source: &[[u8; 3]], radius: usize, padded: &mut [Vec<f32>; 4]) {
    for (x, &pixel) in source.iter().enumerate() {
        let ([y, cx, cz], luminance) = ycxcz(pixel);
        for (plane, value) in padded.iter_mut().zip([y, cx, cz, luminance]) {
            plane[radius + x] = value;
        }
    }
    for plane in padded {
        let end = radius + source.len();
        let (first, last) = (plane[radius], plane[end - 1]);
        plane[..radius].fill(first);
        plane[end..].fill(last);
    }
}

/// out\[x\] = sum over k of weights\[k\] source\[x + k\].
fn along(weights: &[f32], source: &[f32], out: &mut [f32]) {
    out.fill(0.0);
    for (k, &weight) in weights.iter().enumerate() {
        add(weight, &source[k..][..out.len()], out);
    }
}

#[inline]
fn add(weight: f32, source: &[f32], out: &mut [f32]) {
    out.iter_mut().zip(source).for_each(|(out, value)| *out += weight * value);
}

/// One row filtered in both directions.
struct Columns {
    /// Y, Cx and Cz as the eye blurs them; the fourth is the second part of Cz.
    blurred: [Vec<f32>; 4],
    /// Derivatives of the luminance: along x and y, and twice along x and y.
    derivatives: [Vec<f32>; 4],
}

impl Columns {
    fn new(width: usize) -> Self {
        let planes = || std::array::from_fn(|_| vec![0.0; width]);
        Self { blurred: planes(), derivatives: planes() }
    }

    /// Filters around row `y` of `rows`.
    fn filter(&mut self, filters: &Filters, rows: &Rows, y: usize) {
        let [blurs @ .., edge, point, gauss] = &rows.planes;
        let jobs = [(&filters.gauss, edge), (&filters.edge, gauss), (&filters.gauss, point), (&filters.point, gauss)];
        let jobs = filters.blur.iter().zip(blurs).chain(jobs);
        for ((weights, plane), out) in jobs.zip(self.blurred.iter_mut().chain(&mut self.derivatives)) {
            out.fill(0.0);
            let rows = plane[(y - weights.len() / 2) * rows.width..].chunks_exact(rows.width);
            weights.iter().zip(rows).for_each(|(&weight, row)| add(weight, row, out));
        }
    }

    fn colour(&self, x: usize) -> [f32; 3] {
        let [y, cx, wide, narrow] = self.blurred.each_ref().map(|plane| plane[x]);
        perceived([y, cx, wide + narrow])
    }

    /// How much of an edge and of a point the pixel is.
    fn features(&self, x: usize) -> [f32; 2] {
        let [dx, dy, ddx, ddy] = self.derivatives.each_ref().map(|plane| plane[x]);
        [(dx * dx + dy * dy).sqrt(), (ddx * ddx + ddy * ddy).sqrt()]
    }
}

/// The FLIP value of a pixel: a colour difference counts for more where there is a feature in one picture only.
#[inline]
fn value(a: &Columns, b: &Columns, x: usize) -> f32 {
    let log_colour = log_difference(a.colour(x), b.colour(x));
    if log_colour == f32::NEG_INFINITY {
        return 0.0;
    }
    let ([edge_a, point_a], [edge_b, point_b]) = (a.features(x), b.features(x));
    let difference = (edge_a - edge_b).abs().max((point_a - point_b).abs());
    let feature = (difference * std::f32::consts::FRAC_1_SQRT_2).sqrt();
    // Rounding may carry a largest difference past 1.
    libm::exp2f(log_colour * (1.0 - feature)).clamp(0.0, 1.0)
}
