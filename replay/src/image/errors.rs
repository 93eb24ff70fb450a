//! Pictures of errors: where result and reference differ, and where a viewer sees it.

use super::Srgb8;
use super::flip::FlipMap;
use crate::error::Result;

/// How many times larger the differences of `error.png` are than the true ones.
pub const AMPLIFICATION: u8 = 8;

/// The magma colour map (S. van der Walt and N. Smith, CC0): every fifteenth of its 256 colours. Straight lines between them are
/// at most 3 codes off.
const MAGMA: [[u8; 3]; 18] = [
    [0, 0, 4],
    [9, 7, 32],
    [26, 16, 66],
    [49, 17, 101],
    [74, 16, 121],
    [98, 25, 128],
    [121, 34, 130],
    [145, 43, 129],
    [170, 51, 125],
    [194, 59, 117],
    [217, 70, 107],
    [236, 88, 96],
    [247, 114, 92],
    [252, 142, 100],
    [254, 170, 116],
    [254, 198, 138],
    [253, 226, 163],
    [252, 253, 191],
];

/// The absolute difference of each 8-bit sRGB value times [`AMPLIFICATION`], at most 255: black where the pictures agree.
///
/// # Errors
/// When the sizes differ.
pub fn amplified(a: &Srgb8, b: &Srgb8) -> Result<Srgb8> {
    a.same_size(b)?;
    let difference =
        |(a, b): (&[u8; 3], &[u8; 3])| std::array::from_fn(|c| a[c].abs_diff(b[c]).saturating_mul(AMPLIFICATION));
    let pixels = a.pixels.iter().zip(&b.pixels).map(difference).collect();
    Ok(Srgb8 { width: a.width, height: a.height, pixels })
}

/// A FLIP map in the magma colours: black is 0, no difference seen, and pale yellow 1.
pub fn flip_picture(map: &FlipMap) -> Srgb8 {
    // The cast truncates, and turns what is out of range to its end.
    let colours: [[u8; 3]; 256] = std::array::from_fn(magma);
    let pixels = map.values.iter().map(|v| colours[usize::from((v * 255.0 + 0.5) as u8)]).collect();
    Srgb8 { width: map.width, height: map.height, pixels }
}

/// Colour `index` of 256.
fn magma(index: usize) -> [u8; 3] {
    let (i, part) = (index / 15, index % 15);
    let (from, to) = (MAGMA[i], MAGMA[(i + 1).min(MAGMA.len() - 1)]);
    let mix = |c: usize| (usize::from(from[c]) * (15 - part) + usize::from(to[c]) * part + 7) / 15;
    std::array::from_fn(|c| mix(c) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_by_hand() {
        let picture = |pixels: &[[u8; 3]]| Srgb8 { width: 2, height: 1, pixels: pixels.to_vec() };
        let (a, b) = (picture(&[[10, 200, 255], [7, 7, 7]]), picture(&[[13, 190, 0], [7, 38, 39]]));
        // Differences 3, 10, 255; 0, 31, 32: eight times as much, clamped.
        assert_eq!(amplified(&a, &b).unwrap().pixels, [[24, 80, 255], [0, 248, 255]]);
        assert_eq!(amplified(&a, &b).unwrap(), amplified(&b, &a).unwrap());
        assert!(amplified(&a, &Srgb8 { width: 1, height: 2, ..b }).is_err());
    }

    #[test]
    fn the_map_in_colours() {
        let values = vec![0.0, 1.0, 15.0 / 255.0, 1.0 / 255.0, 0.499];
        let picture = flip_picture(&FlipMap { width: 5, height: 1, values });
        // 1/15 of the way from (0, 0, 4) to (9, 7, 32); and colour 127, 7/15 of the way from (170, 51, 125) to (194, 59, 117).
        assert_eq!(picture.pixels, [[0, 0, 4], [252, 253, 191], [9, 7, 32], [1, 0, 6], [181, 55, 121]]);
    }
}
