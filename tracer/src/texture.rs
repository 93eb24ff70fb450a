//! Texture lookups: trilinear colour from a mip chain, bilinear alpha for cut-outs.
//!
//! The mip level comes from a ray cone (Akenine-Möller et al. 2019, simplified: constant spread, no curvature).
//! Without it distant textures would alias, and policies that look for similar neighbours would see noise that no
//! renderer ships.

use std::ops::Range;

use rayreel_formats::math::{Vec3, vec3};
use rayreel_scenes as scenes;
use rayreel_scenes::Wrap;

/// A texture with its mip chain, in linear light.
///
/// Where it is cut out, its colours are means of what is seen: what is painted into a hole (often black) has no part in them.
#[derive(Debug)]
pub struct MipTexture {
    /// Where it is cut out, the fourth channel is the part of the texel that is seen.
    levels: Vec<MipLevel>,
    /// Whether it is.
    cut_out: bool,
    /// What lies beyond the edges, along `u` and `v`.
    wrap: [Wrap; 2],
}

/// The alpha of a texture that cuts out.
#[derive(Debug)]
pub struct CutOut {
    level: MipLevel,
    wrap: [Wrap; 2],
}

/// What a texel counts by, beside its nearness.
#[derive(Clone, Copy)]
enum Weights {
    /// All alike.
    Equal,
    /// Those of which anything is seen, alike: near at hand that is what it is in the way it is painted.
    Seen,
    /// By how much of them is seen.
    Share,
}

#[derive(Debug)]
struct MipLevel {
    width: u32,
    height: u32,
    /// Linear RGB and alpha, each scaled to 16 bit: half the size of floats, finer than the 8-bit source.
    texels: Vec<[u16; 4]>,
}

impl CutOut {
    /// The texture as it is.
    pub fn new(source: &scenes::Texture) -> Self {
        Self { level: MipLevel::new(source), wrap: source.wrap }
    }

    /// True where it lets rays pass: alpha below one half.
    pub fn is_transparent(&self, uv: [f32; 2]) -> bool {
        let [_, _, _, alpha] = self.level.gather(self.wrap, Weights::Equal, uv);
        alpha < 0.5
    }
}

impl MipTexture {
    /// Decodes sRGB and averages down to one texel. `holes` is the texture whose alpha cuts it out, if one does.
    pub fn new(source: &scenes::Texture, holes: Option<&scenes::Texture>) -> Self {
        let mut base = MipLevel::new(source);
        if let Some(holes) = holes {
            for (texel, at) in base.texels.iter_mut().zip(0..) {
                let (x, y) = (at % base.width, at / base.width);
                texel[3] = seen(holes, below(x, base.width, holes.width), below(y, base.height, holes.height));
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
        let at = |level: usize| {
            let weights = match (self.cut_out, level) {
                (false, _) => Weights::Equal,
                (true, 0) => Weights::Seen,
                (true, _) => Weights::Share,
            };
            let [r, g, b, _] = self.levels[level].gather(self.wrap, weights, uv);
            vec3(r, g, b)
        };
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
}

impl MipLevel {
    /// The finest level.
    fn new(source: &scenes::Texture) -> Self {
        let table: Vec<u16> =
            (0..=255u8).map(|c| (srgb_to_linear(f64::from(c) / 255.0) * 65535.0 + 0.5) as u16).collect();
        let decode =
            |t: &[u8; 4]| [table[t[0] as usize], table[t[1] as usize], table[t[2] as usize], u16::from(t[3]) * 257];
        Self { width: source.width, height: source.height, texels: source.texels.iter().map(decode).collect() }
    }

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

    /// Bilinear lookup of all four channels. `v` points up, rows run down.
    fn gather(&self, wrap: [Wrap; 2], weights: Weights, [u, v]: [f32; 2]) -> [f32; 4] {
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
        let shares = match weights {
            Weights::Equal => return std::array::from_fn(plain),
            Weights::Seen => texels.map(|texel| f32::from(u8::from(texel[3] > 0))),
            Weights::Share => texels.map(|texel| f32::from(texel[3]) / 65535.0),
        };
        // Scaled as colours are.
        let all = mix(shares) * 65535.0;
        if all <= 0.0 {
            return std::array::from_fn(plain);
        }
        let weighed = |i: usize| mix(std::array::from_fn(|t| f32::from(texels[t][i]) * shares[t])) / all;
        [weighed(0), weighed(1), weighed(2), plain(3)]
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

/// The texels of an edge of `theirs` that lie below texel `at` of one of `size`, at least one.
fn below(at: u32, size: u32, theirs: u32) -> Range<u32> {
    let edge = |at: u32| u64::from(at) * u64::from(theirs);
    let (first, end) = (edge(at) / u64::from(size), edge(at + 1).div_ceil(u64::from(size)));
    first as u32..(end as u32).min(theirs)
}

/// The part of some texels that a cut-out shows, of 65535.
fn seen(holes: &scenes::Texture, columns: Range<u32>, rows: Range<u32>) -> u16 {
    let all = columns.len() as u64 * rows.len() as u64;
    let texels = rows.flat_map(|y| columns.clone().map(move |x| (y * holes.width + x) as usize));
    let shown = texels.filter(|&at| holes.texels[at][3] >= 128).count() as u64;
    (shown * 65535 / all) as u16
}

/// The mean of texels by their shares, rounded up; of colours that are cut out also by the part that is seen, if any is.
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
        let green = |texture: &MipTexture, lod| texture.colour([0.031, 0.977], lod);
        for lod in [0.0, 0.7, 2.0, 3.5, 9.0] {
            assert!((green(&MipTexture::new(&both, Some(&both)), lod) - vec3(0.0, 1.0, 0.0)).max_abs() < 1e-3, "{lod}");
        }
        assert!(green(&MipTexture::new(&both, None), 9.0).y < 0.9);
        let edge = CutOut::new(&both);
        assert!(edge.is_transparent([0.99, 0.01]) && !edge.is_transparent([0.02, 0.98]));
        // What is seen is seen whole, however much of it there is: alpha is looked at and not shown.
        let soft =
            texture((8, 8), |x, _| if x < 4 { [255, 0, 0, 150] } else { [0, 0, 255, 255 - 150 * (x as u8 % 2)] });
        let mean = MipTexture::new(&soft, Some(&soft)).colour([0.5, 0.5], 9.0);
        assert!((mean - vec3(2.0 / 3.0, 0.0, 1.0 / 3.0)).max_abs() < 1e-3, "{mean:?}");
    }

    /// Blue around red, of which a finer mask shows a quarter to all: what is seen of red counts by how much that is, near and far.
    #[test]
    fn a_finer_mask_shows_a_part_of_a_texel() {
        let is_red = |x: u32, y: u32| (1..3).contains(&x) && (1..3).contains(&y);
        let colours = texture((4, 4), |x, y| if is_red(x, y) { [255, 0, 0, 255] } else { [0, 0, 255, 255] });
        for rows in 1..=4 {
            let mask = texture((16, 16), |x, y| [0, 0, 0, 255 * u8::from(!is_red(x / 4, y / 4) || y % 4 < rows)]);
            let mips = MipTexture::new(&colours, Some(&mask));
            let red = rows as f32;
            let far = mips.colour([0.5, 0.5], 9.0);
            assert!((far - vec3(red, 0.0, 12.0) * (1.0 / (red + 12.0))).max_abs() < 1e-3, "{rows}: {far:?}");
            let near = mips.colour([0.5, 0.5], 0.0);
            assert!((near - vec3(1.0, 0.0, 0.0)).max_abs() < 1e-3, "{rows}: {near:?}");
            let between = mips.colour([0.25, 0.5], 0.0);
            assert!((between - vec3(0.5, 0.0, 0.5)).max_abs() < 1e-3, "{rows}: {between:?}");
        }
        // A coarser mask hides what lies below its texels.
        let mask = texture((2, 2), |x, _| [0, 0, 0, 255 * (1 - x as u8)]);
        let far = MipTexture::new(&colours, Some(&mask)).colour([0.5, 0.5], 9.0);
        assert!((far - vec3(0.25, 0.0, 0.75)).max_abs() < 1e-3, "{far:?}");
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
