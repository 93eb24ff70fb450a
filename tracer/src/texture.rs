//! Texture lookups: trilinear colour from a mip chain, bilinear alpha for cut-outs.
//!
//! The mip level comes from a ray cone (Akenine-Möller et al. 2019, simplified: constant spread, no curvature).
//! Without it distant textures would alias, and policies that look for similar neighbours would see noise that no
//! renderer ships.

use rayreel_formats::math::{Vec3, vec3};
use rayreel_scenes as scenes;
use rayreel_scenes::Wrap;

/// A texture with its mip chain, in linear light.
///
/// Where it is cut out, its colours are means weighed by alpha: what is painted into a hole (often black) is seen nowhere.
#[derive(Debug)]
pub struct MipTexture {
    levels: Vec<MipLevel>,
    /// Whether colours are weighed by alpha.
    cut_out: bool,
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
    /// Decodes sRGB and averages down to one texel. `holes` is the texture whose alpha cuts it out, if one does wherever it is used.
    pub fn new(source: &scenes::Texture, holes: Option<&scenes::Texture>) -> Self {
        let table: Vec<u16> =
            (0..=255u8).map(|c| (srgb_to_linear(f64::from(c) / 255.0) * 65535.0 + 0.5) as u16).collect();
        let decode =
            |t: &[u8; 4]| [table[t[0] as usize], table[t[1] as usize], table[t[2] as usize], u16::from(t[3]) * 257];
        let (width, height) = (source.width, source.height);
        let mut base = MipLevel { width, height, texels: source.texels.iter().map(decode).collect() };
        if let Some(holes) = holes {
            // The texel of theirs that lies below the middle of each.
            let below = |at: u32, size: u32, theirs: u32| {
                ((2 * u64::from(at) + 1) * u64::from(theirs) / (2 * u64::from(size))) as usize
            };
            for (texel, at) in base.texels.iter_mut().zip(0..) {
                let (x, y) = (below(at % width, width, holes.width), below(at / width, height, holes.height));
                texel[3] = u16::from(holes.texels[y * holes.width as usize + x][3]) * 257;
            }
        }
        let cut_out = holes.is_some();
        let mut levels = vec![base];
        while let Some(next) = levels.last().and_then(|level| level.halved(cut_out)) {
            levels.push(next);
        }
        Self { levels, cut_out, wrap: source.wrap }
    }

    /// Number of texels of the finest level.
    pub fn area(&self) -> f32 {
        self.levels[0].width as f32 * self.levels[0].height as f32
    }

    /// The colour at `uv`. `lod` is the level of detail: 0 is the finest level, each unit halves the resolution.
    pub fn colour(&self, uv: [f32; 2], lod: f32) -> Vec3 {
        let last = self.levels.len() - 1;
        let at = |level: usize| self.levels[level].bilinear(self.wrap, self.cut_out, uv);
        if lod <= 0.0 {
            return at(0);
        }
        let lower = lod as usize;
        if lower >= last {
            return at(last);
        }
        let blend = lod - lower as f32;
        at(lower) * (1.0 - blend) + at(lower + 1) * blend
    }

    /// True where the cut-out lets rays pass: alpha of the finest level below one half.
    pub fn is_transparent(&self, uv: [f32; 2]) -> bool {
        let [_, _, _, alpha] = self.levels[0].gather(self.wrap, false, uv);
        alpha < 0.5
    }
}

impl MipLevel {
    /// The next coarser level, half as many texels along each edge, rounded down; `None` at one texel. Each texel is the mean of what
    /// lies below it.
    fn halved(&self, cut_out: bool) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let below = shares(y, self.height)
                    .flat_map(|(y, tall)| shares(x, self.width).map(move |(x, wide)| ((x, y), tall * wide)));
                let below = below.map(|((x, y), share)| (self.texels[(y * self.width + x) as usize], share));
                texels.push(mean(below, cut_out));
            }
        }
        Some(Self { width, height, texels })
    }

    fn bilinear(&self, wrap: [Wrap; 2], cut_out: bool, uv: [f32; 2]) -> Vec3 {
        let [r, g, b, _] = self.gather(wrap, cut_out, uv);
        vec3(r, g, b)
    }

    /// Bilinear lookup of all four channels, with colours weighed by alpha or not. `v` points up, rows run down.
    fn gather(&self, wrap: [Wrap; 2], cut_out: bool, [u, v]: [f32; 2]) -> [f32; 4] {
        let (x0, x1, fx) = around(wrap[0], u, self.width);
        let (y0, y1, fy) = around(wrap[1], 1.0 - v, self.height);
        let texel = |x: u32, y: u32| self.texels[(y * self.width + x) as usize];
        let texels = [texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1)];
        let mix = |[a, b, c, d]: [f32; 4]| {
            let top = a * (1.0 - fx) + b * fx;
            let bottom = c * (1.0 - fx) + d * fx;
            (top * (1.0 - fy) + bottom * fy) / 65535.0
        };
        let plain = |i: usize| mix(texels.map(|texel| f32::from(texel[i])));
        let alpha = if cut_out { plain(3) } else { 0.0 };
        if alpha <= 0.0 {
            return std::array::from_fn(plain);
        }
        let weighed = |i: usize| mix(texels.map(|texel| f32::from(texel[i]) * (f32::from(texel[3]) / 65535.0))) / alpha;
        [weighed(0), weighed(1), weighed(2), alpha]
    }
}

/// The texels of an edge of `size` that lie below texel `at` of one half as long, with how much of each: all of two, or of three parts
/// where the edge is odd. Together they are `size`, or 2 of an even edge.
fn shares(at: u32, size: u32) -> impl Iterator<Item = (u32, u64)> + Clone {
    let half = size / 2;
    let of: [u64; 3] = match (size, size % 2) {
        (1, _) => [1, 0, 0],
        (_, 0) => [1, 1, 0],
        _ => [half - at, half, at + 1].map(u64::from),
    };
    (2 * at..).zip(of).filter(|(_, share)| *share > 0)
}

/// The mean of texels by their shares, rounded up; of colours that are cut out also by their alpha, if any of it is left.
fn mean(texels: impl Iterator<Item = ([u16; 4], u64)> + Clone, cut_out: bool) -> [u16; 4] {
    let weighed = |weight: &dyn Fn([u16; 4], u64) -> u64, channel: usize| {
        let (sum, all) = texels.clone().fold((0, 0), |(sum, all), (texel, share)| {
            let weight = weight(texel, share);
            (sum + u64::from(texel[channel]) * weight, all + weight)
        });
        (all > 0).then(|| sum.div_ceil(all) as u16)
    };
    let plain = |channel| weighed(&|_, share| share, channel).unwrap_or_default();
    let by_alpha = |channel| weighed(&|texel, share| share * u64::from(texel[3]), channel);
    std::array::from_fn(|i| if cut_out && i < 3 { by_alpha(i).unwrap_or_else(|| plain(i)) } else { plain(i) })
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
        MipTexture { levels: vec![MipLevel { width: 4, height: 1, texels }], cut_out: false, wrap: [wrap; 2] }
    }

    /// Red at some coordinates, in thirds.
    fn thirds(wrap: Wrap, at: [f32; 6]) -> [f32; 6] {
        at.map(|u| row(wrap).colour([u, 0.5], 0.0).x * 3.0)
    }

    fn texture((width, height): (u32, u32), texel: impl Fn(u32, u32) -> [u8; 4]) -> scenes::Texture {
        let texels = (0..width * height).map(|at| texel(at % width, at / width)).collect();
        scenes::Texture { name: "test".into(), width, height, texels, wrap: [Wrap::Repeat; 2] }
    }

    /// The last column of odd edges counted twice at every level: half of this texture was red from afar.
    #[test]
    fn the_last_level_is_the_mean_whatever_the_size() {
        for size in [(128, 128), (129, 129), (257, 3), (600, 400), (1, 75), (1080, 2)] {
            let red = texture(size, |x, y| if x + 1 == size.0 || y == 0 { [255, 0, 0, 255] } else { [0, 0, 0, 255] });
            let of_all = f64::from(size.0 + size.1 - 1) / (f64::from(size.0) * f64::from(size.1));
            let found = f64::from(MipTexture::new(&red, None).colour([0.3, 0.4], 99.0).x);
            // Each level rounds up by less than one of 65535.
            assert!((0.0..2e-4).contains(&(found - of_all)), "{size:?}: {found}, not {of_all}");
        }
    }

    /// Black below the holes darkened what is seen of a leaf, the more the farther it is.
    #[test]
    fn what_lies_in_a_hole_has_no_colour() {
        let leaf = |x: u32, y: u32| (x % 8).pow(2) + (y % 8).pow(2) < 30;
        let both = texture((64, 64), |x, y| if leaf(x, y) { [0, 255, 0, 255] } else { [0, 0, 0, 0] });
        let alone = texture((64, 64), |x, y| if leaf(x, y) { [0, 255, 0, 255] } else { [9, 9, 9, 255] });
        let holes = texture((32, 32), |x, y| [0, 0, 0, 255 * u8::from(leaf(2 * x, 2 * y))]);
        let green = |texture: &MipTexture, lod| texture.colour([0.031, 0.977], lod);
        for lod in [0.0, 0.7, 2.0, 3.5, 9.0] {
            assert!((green(&MipTexture::new(&both, Some(&both)), lod) - vec3(0.0, 1.0, 0.0)).max_abs() < 1e-3, "{lod}");
            let other = green(&MipTexture::new(&alone, Some(&holes)), lod);
            assert!(other.y > 0.85 && other.x < 0.05, "{lod}: {other:?}");
        }
        assert!(green(&MipTexture::new(&both, None), 9.0).y < 0.9);
        let edge = MipTexture::new(&both, Some(&both));
        assert!(edge.is_transparent([0.99, 0.01]) && !edge.is_transparent([0.02, 0.98]));
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
