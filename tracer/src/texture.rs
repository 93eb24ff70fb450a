//! Texture lookups: trilinear colour from a mip chain, bilinear alpha for cut-outs.
//!
//! The mip level comes from a ray cone (Akenine-Möller et al. 2019, simplified: constant spread, no curvature).
//! Without it distant textures would alias, and policies that look for similar neighbours would see noise that no
//! renderer ships.

use rayreel_formats::math::{Vec3, vec3};
use rayreel_scenes as scenes;
use rayreel_scenes::Wrap;

/// A texture with its mip chain, in linear light.
#[derive(Debug)]
pub struct MipTexture {
    levels: Vec<MipLevel>,
    /// What lies beyond the edges, along `u` and `v`.
    wrap: [Wrap; 2],
}

#[derive(Debug)]
struct MipLevel {
    width: u32,
    height: u32,
    /// Linear RGB and alpha, each scaled to 16 bit: half the size of floats, finer than the 8-bit source.
    texels: Vec<[u16; 4]>,
}

impl MipTexture {
    /// Decodes sRGB and averages down to one texel.
    pub fn new(source: &scenes::Texture) -> Self {
        let table: Vec<u16> =
            (0..=255u8).map(|c| (srgb_to_linear(f64::from(c) / 255.0) * 65535.0 + 0.5) as u16).collect();
        let decode =
            |t: &[u8; 4]| [table[t[0] as usize], table[t[1] as usize], table[t[2] as usize], u16::from(t[3]) * 257];
        let base =
            MipLevel { width: source.width, height: source.height, texels: source.texels.iter().map(decode).collect() };
        let mut levels = vec![base];
        while let Some(next) = levels.last().and_then(MipLevel::halved) {
            levels.push(next);
        }
        Self { levels, wrap: source.wrap }
    }

    /// Number of texels of the finest level.
    pub fn area(&self) -> f32 {
        self.levels[0].width as f32 * self.levels[0].height as f32
    }

    /// The colour at `uv`. `lod` is the level of detail: 0 is the finest level, each unit halves the resolution.
    pub fn colour(&self, uv: [f32; 2], lod: f32) -> Vec3 {
        let last = self.levels.len() - 1;
        if lod <= 0.0 {
            return self.levels[0].bilinear(self.wrap, uv);
        }
        let lower = lod as usize;
        if lower >= last {
            return self.levels[last].bilinear(self.wrap, uv);
        }
        let blend = lod - lower as f32;
        self.levels[lower].bilinear(self.wrap, uv) * (1.0 - blend)
            + self.levels[lower + 1].bilinear(self.wrap, uv) * blend
    }

    /// True where the cut-out lets rays pass: alpha of the finest level below one half.
    pub fn is_transparent(&self, uv: [f32; 2]) -> bool {
        let [_, _, _, alpha] = self.levels[0].gather(self.wrap, uv);
        alpha < 0.5
    }
}

impl MipLevel {
    /// The next coarser level; `None` at one texel. Odd edges repeat their last texel.
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let at = |x: u32, y: u32| self.texels[(y.min(self.height - 1) * self.width + x.min(self.width - 1)) as usize];
        let mut texels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let four = [at(2 * x, 2 * y), at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1)];
                texels.push(std::array::from_fn(|c| {
                    (four.iter().map(|t| u32::from(t[c])).sum::<u32>().div_ceil(4)) as u16
                }));
            }
        }
        Some(Self { width, height, texels })
    }

    fn bilinear(&self, wrap: [Wrap; 2], uv: [f32; 2]) -> Vec3 {
        let [r, g, b, _] = self.gather(wrap, uv);
        vec3(r, g, b)
    }

    /// Bilinear lookup of all four channels. `v` points up, rows run down.
    fn gather(&self, wrap: [Wrap; 2], [u, v]: [f32; 2]) -> [f32; 4] {
        let (x0, x1, fx) = around(wrap[0], u, self.width);
        let (y0, y1, fy) = around(wrap[1], 1.0 - v, self.height);
        let texel = |x: u32, y: u32| self.texels[(y * self.width + x) as usize];
        let (a, b, c, d) = (texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1));
        std::array::from_fn(|i| {
            let top = f32::from(a[i]) * (1.0 - fx) + f32::from(b[i]) * fx;
            let bottom = f32::from(c[i]) * (1.0 - fx) + f32::from(d[i]) * fx;
            (top * (1.0 - fy) + bottom * fy) / 65535.0
        })
    }
}

/// The two texels around a coordinate, and the weight of the second.
#[inline]
fn around(wrap: Wrap, coordinate: f32, size: u32) -> (u32, u32, f32) {
    match wrap {
        Wrap::Repeat => repeated(coordinate, size),
        Wrap::Mirror => {
            let turned = coordinate - 2.0 * (coordinate * 0.5).floor();
            clamped(if turned > 1.0 { 2.0 - turned } else { turned }, size)
        }
        Wrap::Clamp => clamped(coordinate, size),
    }
}

/// The same of a texture whose edges go on.
fn clamped(coordinate: f32, size: u32) -> (u32, u32, f32) {
    let last = (size - 1) as f32;
    let position = (coordinate * size as f32 - 0.5).clamp(0.0, last);
    let first = (position.floor() as u32).min(size - 1);
    (first, (first + 1).min(size - 1), position - first as f32)
}

/// The same of a texture that repeats.
fn repeated(coordinate: f32, size: u32) -> (u32, u32, f32) {
    let fraction = coordinate - coordinate.floor();
    let position = fraction * size as f32 - 0.5;
    let floor = position.floor();
    let first = if floor < 0.0 { size - 1 } else { (floor as u32).min(size - 1) };
    let second = if first + 1 == size { 0 } else { first + 1 };
    (first, second, position - floor)
}

fn srgb_to_linear(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
}

/// Base-2 logarithm, linear within each octave (error below 0.09): enough for a mip level, and the same everywhere.
pub fn approximate_log2(x: f32) -> f32 {
    let bits = x.max(f32::MIN_POSITIVE).to_bits();
    let exponent = (bits >> 23) as f32 - 127.0;
    let mantissa = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000) - 1.0;
    exponent + mantissa
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four texels in a row, the red of texel k being k / 3.
    fn row(wrap: Wrap) -> MipTexture {
        let level = |k: u16| [k * 21845, 0, 0, u16::MAX];
        let texels = (0..4).map(level).collect();
        MipTexture { levels: vec![MipLevel { width: 4, height: 1, texels }], wrap: [wrap; 2] }
    }

    /// Red at some coordinates, in thirds.
    fn thirds(wrap: Wrap, at: [f32; 6]) -> [f32; 6] {
        at.map(|u| row(wrap).colour([u, 0.5], 0.0).x * 3.0)
    }

    #[test]
    fn edges_repeat_turn_round_or_go_on() {
        let at = [0.0, 0.125, 1.0, 1.125, -0.375, 2.625];
        let near = |found: [f32; 6], wanted: [f32; 6]| {
            let same = found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3);
            assert!(same, "{found:?}, not {wanted:?}");
        };
        near(thirds(Wrap::Repeat, at), [1.5, 0.0, 1.5, 0.0, 2.0, 2.0]);
        near(thirds(Wrap::Mirror, at), [0.0, 0.0, 3.0, 3.0, 1.0, 2.0]);
        near(thirds(Wrap::Clamp, at), [0.0, 0.0, 3.0, 3.0, 0.0, 3.0]);
    }
}
