//! Mitchell 1987: where the contrast of neighbouring samples is too high, all samples are traced.
//!
//! His picture is sampled at two levels, and contrast decides which: it is closer to what eyes see than variance. He gives red,
//! green and blue limits of their own.

use rayreel_formats::math::Vec3;

use super::cell::{Cell, bilinear, share};
use super::rule::{COLOURS, CellRule};
use crate::policy::kinds::Mitchell1987;
use crate::policy::similarity::Compared;
use rayreel_machine::work::PolicyReads;

/// The rule.
#[derive(Clone, Debug)]
pub struct Mitchell {
    /// Red, green, blue.
    limits: [f64; 3],
}

impl Mitchell {
    /// The rule with these values.
    pub fn new(values: &Mitchell1987) -> Self {
        Self { limits: [values.red, values.green, values.blue] }
    }
}

impl CellRule for Mitchell {
    fn reads(&self) -> PolicyReads {
        COLOURS
    }

    fn decide(&self, cell: &mut Cell<'_>) {
        let corners = cell.colours();
        // A line of samples has two corners, else there are four: each but the first is one more to look at.
        let colours = if cell.x.0 == cell.x.1 || cell.y.0 == cell.y.1 { 1 } else { 3 };
        cell.compared(1, Compared { pairs: 1, colours });
        let contrast = contrast(corners);
        let is_flat = (0..3).all(|channel| contrast[channel] <= self.limits[channel]);
        for at in cell.samples() {
            if is_flat {
                cell.interpolate(at, bilinear(corners, share(cell.x, at.0), share(cell.y, at.1)), 1);
            } else {
                cell.trace(at, 1);
            }
        }
    }
}

/// Per channel the contrast of four colours: `(max - min) / (max + min)`, 0 for black alone, NaN if one is.
fn contrast(corners: [Vec3; 4]) -> [f64; 3] {
    std::array::from_fn(|channel| {
        let values = corners.map(|colour| f64::from(colour.to_array()[channel]));
        if values.iter().any(|v| v.is_nan()) {
            return f64::NAN;
        }
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        if low == 0.0 && high == 0.0 { 0.0 } else { (high - low) / (high + low) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayreel_formats::math::vec3;

    #[test]
    fn contrast_by_hand() {
        let corners = [vec3(0.1, 0.0, 0.5), vec3(0.3, 0.0, 0.5), vec3(0.2, 0.0, 0.0), vec3(0.2, 0.0, 0.25)];
        let [red, green, blue] = contrast(corners);
        assert!((red - 0.5).abs() < 1.0e-6, "0.2 of 0.4");
        assert_eq!((green, blue), (0.0, 1.0), "black is flat; black beside anything is all contrast");
        assert!(contrast([Vec3::splat(f32::NAN), Vec3::ONE, Vec3::ONE, Vec3::ONE])[0].is_nan());
    }
}
