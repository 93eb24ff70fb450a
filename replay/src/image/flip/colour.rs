//! FLIP's colour spaces: YCxCz, linear in light, in which the eye's blur is applied; and CIELab with Hunt's adjustment, in which
//! distances are taken.

use std::sync::LazyLock;

/// Linear sRGB to XYZ: the chromaticities of the sRGB primaries and of D65, (0.3127, 0.3290), worked out as fractions.
const XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The exponent that compresses HyAB distances.
const COMPRESSION: f64 = 0.7;
/// Compressed distances below this share of the largest become FLIP values below [`KNEE_VALUE`].
const KNEE: f64 = 0.4;
/// Where the two lines of the remapping meet.
const KNEE_VALUE: f64 = 0.95;

/// What the conversions need, worked out once in f64.
struct Tables {
    /// Linear light of each 8-bit sRGB code.
    linear: [f32; 256],
    /// Linear RGB to XYZ over the white's XYZ.
    to_xyz: [[f32; 3]; 3],
    /// Back.
    to_rgb: [[f32; 3]; 3],
    /// Compressed distance at the knee.
    knee: f32,
    /// Its base-2 logarithm.
    log_knee: f32,
    /// That of the slope below the knee.
    log_slope: f32,
    /// The largest compressed distance, of green and blue.
    largest: f32,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let linear = |code: usize| {
        let c = code as f64 / 255.0;
        (if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }) as f32
    };
    // The white's XYZ is the sum of each row: its RGB is (1, 1, 1).
    let to_xyz = XYZ.map(|row| row.map(|v| v / row.iter().sum::<f64>()));
    let distance = hyab(hunt_lab_f64(to_xyz.map(|row| row[1])), hunt_lab_f64(to_xyz.map(|row| row[2])));
    let largest = libm::pow(distance, COMPRESSION);
    let knee = KNEE * largest;
    Tables {
        linear: std::array::from_fn(linear),
        to_xyz: to_xyz.map(|row| row.map(|v| v as f32)),
        to_rgb: inverse(&to_xyz).map(|row| row.map(|v| v as f32)),
        knee: knee as f32,
        log_knee: libm::log2(knee) as f32,
        log_slope: libm::log2(KNEE_VALUE / knee) as f32,
        largest: largest as f32,
    }
});

fn inverse(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |r: usize, c: usize| {
        let ([r0, r1], [c0, c1]) = ([(r + 1) % 3, (r + 2) % 3], [(c + 1) % 3, (c + 2) % 3]);
        m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    std::array::from_fn(|r| std::array::from_fn(|c| minor(c, r) / determinant))
}

#[inline]
fn times(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Y, Cx and Cz of an 8-bit sRGB pixel; and its luminance, 0 to 1, in which features are sought.
#[inline]
pub fn ycxcz(pixel: [u8; 3]) -> ([f32; 3], f32) {
    let tables = &*TABLES;
    let [x, y, z] = times(&tables.to_xyz, pixel.map(|code| tables.linear[usize::from(code)]));
    ([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], y)
}

/// CIELab of XYZ over white, its chroma scaled with lightness (Hunt): what is dark looks less colourful.
#[inline]
fn hunt_lab(xyz: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] =
        xyz.map(|v| if v > DELTA * DELTA * DELTA { libm::cbrtf(v) } else { v / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * (500.0 * (x - y)), 0.01 * lightness * (200.0 * (y - z))]
}

/// The same in f64, for the largest distance.
fn hunt_lab_f64(xyz: [f64; 3]) -> [f64; 3] {
    hunt_lab(xyz.map(|v| v as f32)).map(f64::from)
}

/// HyAB distance: lightness and chroma are judged apart.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// Hunt-adjusted CIELab of a blurred YCxCz, after clamping to the colours that a screen can show.
#[inline]
pub fn perceived([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let tables = &*TABLES;
    let luminance = (y + 16.0) / 116.0;
    let rgb = times(&tables.to_rgb, [luminance + cx / 500.0, luminance, luminance - cz / 200.0]);
    hunt_lab(times(&tables.to_xyz, rgb.map(|v| v.clamp(0.0, 1.0))))
}

/// The base-2 logarithm of the colour difference (0 to 1) of two perceived colours; minus infinity for equal ones.
///
/// The difference is a power of the distance, and will be raised to another power: two logarithms and an exponential less than by
/// `powf`, which would take half of the time of all that FLIP does.
#[inline]
pub fn log_difference(a: [f32; 3], b: [f32; 3]) -> f32 {
    let tables = &*TABLES;
    let [l, p, q] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let log = COMPRESSION as f32 * libm::log2f(l.abs() + (p * p + q * q).sqrt());
    if log < tables.log_knee {
        return log + tables.log_slope;
    }
    let share = (libm::exp2f(log) - tables.knee) / (tables.largest - tables.knee);
    libm::log2f(KNEE_VALUE as f32 + share * (1.0 - KNEE_VALUE) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_colours() {
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2.0e-3);
        assert!(near(ycxcz([255; 3]).0, [100.0, 0.0, 0.0]), "{:?}", ycxcz([255; 3]));
        assert!(near(ycxcz([0; 3]).0, [-16.0, 0.0, 0.0]));
        // CIELab of sRGB red is (53.24, 80.09, 67.20); chroma is scaled by a hundredth of the lightness.
        let [l, a, b] = perceived(ycxcz([255, 0, 0]).0);
        let hundredth = l * 0.01;
        assert!((l - 53.24).abs() < 0.05 && (a / hundredth - 80.09).abs() < 0.1 && (b / hundredth - 67.2).abs() < 0.1);
        assert!(near(perceived(ycxcz([255; 3]).0), [100.0, 0.0, 0.0]));
    }

    #[test]
    fn clamped_to_what_a_screen_shows() {
        let white = perceived(ycxcz([255; 3]).0);
        assert_eq!(perceived([300.0, 0.0, 0.0]), perceived([200.0, 0.0, 0.0]));
        assert!((perceived([300.0, 0.0, 0.0])[0] - white[0]).abs() < 1.0e-3);
        assert!(perceived([-50.0, 0.0, 0.0])[0].abs() < 1.0e-4);
    }

    #[test]
    fn green_and_blue_are_farthest() {
        let [green, blue, white, black] = [[0, 255, 0], [0, 0, 255], [255; 3], [0; 3]].map(|p| perceived(ycxcz(p).0));
        assert!(log_difference(green, blue).abs() < 1.0e-6);
        let other = libm::exp2f(log_difference(white, black));
        assert!(other < 1.0 && other > KNEE_VALUE as f32, "{other}");
        assert_eq!(log_difference(green, green), f32::NEG_INFINITY);
    }
}
