//! Procedural textures.

use std::sync::LazyLock;

use glam::DVec3;

use crate::{
    pictures::srgb_to_linear,
    scene::{Texture, Wrap},
};

/// Paints a texture: `colour(u, v)` in linear RGB at each texel's centre, `v` up.
pub fn paint(name: &str, side: u32, colour: impl Fn(f64, f64) -> DVec3) -> Texture {
    let mut texels = Vec::with_capacity((side * side) as usize);
    for row in 0..side {
        for column in 0..side {
            let u = (f64::from(column) + 0.5) / f64::from(side);
            let v = 1.0 - (f64::from(row) + 0.5) / f64::from(side);
            let [r, g, b] = colour(u, v).to_array().map(encode);
            texels.push([r, g, b, 255]);
        }
    }
    Texture { name: name.to_owned(), width: side, height: side, texels, wrap: [Wrap::Repeat; 2] }
}

/// Linear to 8-bit sRGB, rounded to the nearest code. Looked up in a table of the codes' lower bounds, because three
/// powers a texel would take longer than the rest of a scene.
fn encode(linear: f64) -> u8 {
    static BOUNDS: LazyLock<[f64; 255]> =
        LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear((i as f64 + 0.5) / 255.0)));
    BOUNDS.partition_point(|bound| *bound <= linear) as u8
}

/// Smooth noise between 0 and 1 with a cell size of one.
#[must_use]
pub fn noise(x: f64, y: f64, seed: u32) -> f64 {
    let (fx, fy) = (libm::floor(x), libm::floor(y));
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (tx, ty) = (smooth(x - fx), smooth(y - fy));
    let (ix, iy) = (fx as i64 as u32, fy as i64 as u32);
    let at = |dx: u32, dy: u32| hash(ix.wrapping_add(dx), iy.wrapping_add(dy), seed);
    let low = at(0, 0) + (at(1, 0) - at(0, 0)) * tx;
    let high = at(0, 1) + (at(1, 1) - at(0, 1)) * tx;
    low + (high - low) * ty
}

/// Noise in several sizes, between 0 and 1.
#[must_use]
pub fn cloud(x: f64, y: f64, octaves: u32, seed: u32) -> f64 {
    let (mut sum, mut weight, mut total, mut scale) = (0.0, 0.5, 0.0, 1.0);
    for octave in 0..octaves {
        sum += noise(x * scale, y * scale, seed.wrapping_add(octave)) * weight;
        total += weight;
        weight *= 0.5;
        scale *= 2.03;
    }
    sum / total
}

/// Clouds of three sizes that repeat over the unit square; the coarsest has `cells` cells to a side.
#[must_use]
pub fn wrapped(u: f64, v: f64, cells: u32, seed: u32) -> f64 {
    let octave = |k: u32| repeating(u, v, cells << k, seed.wrapping_add(k));
    (octave(0) * 0.5 + octave(1) * 0.25 + octave(2) * 0.125) / 0.875
}

/// Like [`noise`], with `period` cells over the unit square, the last beside the first.
fn repeating(u: f64, v: f64, period: u32, seed: u32) -> f64 {
    let (x, y) = (u * f64::from(period), v * f64::from(period));
    let (fx, fy) = (libm::floor(x), libm::floor(y));
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (tx, ty) = (smooth(x - fx), smooth(y - fy));
    let wrap = |cell: f64, step: i64| (cell as i64 + step).rem_euclid(i64::from(period)) as u32;
    let at = |dx: i64, dy: i64| hash(wrap(fx, dx), wrap(fy, dy), seed);
    let low = at(0, 0) + (at(1, 0) - at(0, 0)) * tx;
    let high = at(0, 1) + (at(1, 1) - at(0, 1)) * tx;
    low + (high - low) * ty
}

/// An integer hash as a number between 0 and 1.
fn hash(x: u32, y: u32, seed: u32) -> f64 {
    let mut h = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    f64::from(h ^ (h >> 15)) / f64::from(u32::MAX)
}

/// Wood: planks along `u`, with grain, rings and dark joints. `dark` and `pale` are linear RGB.
#[must_use]
pub fn wood(u: f64, v: f64, planks: f64, dark: DVec3, pale: DVec3) -> DVec3 {
    let plank = libm::floor(v * planks);
    let within = v * planks - plank;
    let shade = hash(plank as i64 as u32, 7, 11);
    // Long grain: noise stretched along the plank, bent by slower noise.
    let bend = cloud(u * 2.0 + shade * 31.0, v * planks * 0.6, 3, 3);
    let rings = 0.5 + 0.5 * libm::sin((within * 5.0 + bend * 9.0 + shade * 6.0) * 3.1);
    let grain = cloud(u * 9.0 + shade * 17.0, v * planks * 34.0, 3, 5);
    let mix = (0.45 * rings + 0.4 * grain + 0.3 * shade).clamp(0.0, 1.0);
    let edge = within.min(1.0 - within);
    let joint = (edge / 0.012).clamp(0.0, 1.0) * 0.55 + 0.45;
    (dark + (pale - dark) * mix) * joint
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_is_the_srgb_curve_rounded() {
        for i in -100..=20_100 {
            let linear = f64::from(i) / 20_000.0;
            let c = linear.clamp(0.0, 1.0);
            let curve = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * libm::pow(c, 1.0 / 2.4) - 0.055 };
            assert_eq!(encode(linear), libm::round(curve * 255.0) as u8, "{linear}");
        }
        assert_eq!([encode(f64::NEG_INFINITY), encode(f64::INFINITY), encode(f64::NAN)], [0, 255, 0]);
    }
}
