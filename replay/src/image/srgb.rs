//! Linear RGB to 8-bit sRGB by the exact piecewise function of IEC 61966-2-1.
//!
//! The power comes from the libm crate, so every machine agrees. Pictures are converted by a table of the 255 thresholds
//! between neighbouring codes, found once by bisection with that very function.

use std::sync::LazyLock;

use super::{Image, Srgb8};

/// The code of a linear value: clamped to 0 to 1, encoded, rounded to the nearest of 256. NaN gives 0.
pub fn code(linear: f32) -> u8 {
    let c = f64::from(linear).clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * libm::pow(c, 1.0 / 2.4) - 0.055 };
    // The cast truncates and turns NaN to 0.
    (encoded * 255.0 + 0.5) as u8
}

/// Entry k is the smallest linear value with a code above k.
static THRESHOLDS: LazyLock<[f32; 255]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        // The bit patterns of non-negative floats sort like the floats.
        let (mut below, mut above) = (0u32, 1.0f32.to_bits());
        while above - below > 1 {
            let middle = below.midpoint(above);
            if usize::from(code(f32::from_bits(middle))) > k {
                above = middle;
            } else {
                below = middle;
            }
        }
        f32::from_bits(above)
    })
});

/// Converts a picture.
pub fn encode(image: &Image) -> Srgb8 {
    let table = &*THRESHOLDS;
    let pixels = image.pixels.iter().map(|pixel| pixel.map(|v| lookup(table, v))).collect();
    Srgb8 { width: image.width, height: image.height, pixels }
}

#[inline]
fn lookup(table: &[f32; 255], linear: f32) -> u8 {
    // At most 255 thresholds lie below. NaN is not above any.
    table.partition_point(|&threshold| linear >= threshold) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_the_codes_of_the_function() {
        let table = &*THRESHOLDS;
        for &threshold in table {
            let bits = threshold.to_bits();
            for v in (bits - 2000..bits + 2000).map(f32::from_bits) {
                assert_eq!(lookup(table, v), code(v), "{v}");
            }
        }
        for v in (0..=0x3f80_0000u32).step_by(977).map(f32::from_bits) {
            assert_eq!(lookup(table, v), code(v), "{v}");
        }
        for v in [-1.0, -0.0, 0.0, 1.0, 1.0001, 1.0e30, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            assert_eq!(lookup(table, v), code(v), "{v}");
        }
    }

    #[test]
    fn known_codes() {
        let known = [(0.0, 0), (1.0, 255), (0.5, 188), (0.214_041_14, 128), (0.003_130_8, 10), (0.18, 118), (2.0, 255)];
        for (linear, expected) in known {
            assert_eq!(code(linear), expected, "{linear}");
        }
    }
}
