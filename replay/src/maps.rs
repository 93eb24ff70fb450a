//! The similarity map, as the paper's Figure 4: yellow where samples were similar and interpolated, blue where they were not
//! and had to be traced.

use crate::frame::states::{Blocks, StateMap};
use crate::image::Srgb8;
use crate::policy::view::SampleState;

/// Similar: interpolated.
pub const YELLOW: [u8; 3] = [250, 215, 50];
/// Dissimilar: traced.
pub const BLUE: [u8; 3] = [25, 60, 170];
/// In part: some hits of the ray tree were interpolated.
pub const GREEN: [u8; 3] = [80, 160, 120];

/// The map at sample resolution. I-samples show what became of them; an R-sample takes the mean of the I-samples of its
/// block, so that the lattice of always-traced samples does not veil the picture. A block without I-samples is blue.
pub fn similarity_map(states: &StateMap, blocks: &Blocks) -> Srgb8 {
    let (width, height) = (states.width, states.height);
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            pixels.push(match states.state(x, y) {
                SampleState::Interpolated => YELLOW,
                SampleState::Traced => BLUE,
                SampleState::Partial => GREEN,
                SampleState::Reference => blend(states, blocks.at(x, y), x, y),
            });
        }
    }
    Srgb8 { width, height, pixels }
}

/// The mean colour of the I-samples in the block of (`x`, `y`).
fn blend(states: &StateMap, block: u32, x: u32, y: u32) -> [u8; 3] {
    let (left, top) = (x / block * block, y / block * block);
    let (mut similar, mut all) = (0u32, 0u32);
    for y in top..(top + block).min(states.height) {
        for x in left..(left + block).min(states.width) {
            let state = states.state(x, y);
            // A partial sample counts half.
            similar += match state {
                SampleState::Interpolated => 2,
                SampleState::Partial => 1,
                _ => 0,
            };
            all += 2 * u32::from(state != SampleState::Reference);
        }
    }
    if all == 0 {
        return BLUE;
    }
    let mix = |yellow: u8, blue: u8| (u32::from(yellow) * similar + u32::from(blue) * (all - similar)) / all;
    std::array::from_fn(|i| mix(YELLOW[i], BLUE[i]) as u8)
}

/// The map at pixel resolution: the mean of the `samples` x `samples` map values of each pixel.
pub fn similarity_map_pixels(states: &StateMap, blocks: &Blocks, samples: u32) -> Srgb8 {
    let map = similarity_map(states, blocks);
    let (width, height) = (map.width / samples, map.height / samples);
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let mut sums = [0u32; 3];
            for i in 0..samples * samples {
                let (sx, sy) = (x * samples + i % samples, y * samples + i / samples);
                let sample = map.pixels[sy as usize * map.width as usize + sx as usize];
                sums.iter_mut().zip(sample).for_each(|(sum, v)| *sum += u32::from(v));
            }
            pixels.push(sums.map(|sum| (sum / (samples * samples)) as u8));
        }
    }
    Srgb8 { width, height, pixels }
}

/// The rate map at pixel resolution: traced samples per sample of each tile-sized block of the picture, from dark blue (none)
/// over green to light yellow (all), by the square root, so that low rates can be told apart.
pub fn rate_map_pixels(states: &StateMap, blocks: &Blocks, samples: u32) -> Srgb8 {
    let (width, height) = (states.width / samples, states.height / samples);
    let (across, down) = (blocks.tile_edge(states.width), blocks.tile_edge(states.height));
    let columns = states.width.div_ceil(across);
    let mut colours = Vec::new();
    for top in (0..states.height).step_by(down as usize) {
        for left in (0..states.width).step_by(across as usize) {
            let (right, bottom) = ((left + across).min(states.width), (top + down).min(states.height));
            let traced = (top..bottom)
                .flat_map(|y| (left..right).map(move |x| (x, y)))
                .filter(|&(x, y)| states.state(x, y) != SampleState::Interpolated)
                .count();
            let rate = traced as f64 / (f64::from(right - left) * f64::from(bottom - top));
            colours.push(ramp(rate.sqrt()));
        }
    }
    let pixel = |i: u32| {
        let (x, y) = (i % width * samples, i / width * samples);
        colours[((y / down) * columns + x / across) as usize]
    };
    Srgb8 { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// A colour between dark blue at 0 and light yellow at 1: five points of the viridis map, linear between them.
fn ramp(v: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] =
        [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];
    let place = v.clamp(0.0, 1.0) * 4.0;
    let i = (place.floor() as usize).min(3);
    let s = place - i as f64;
    std::array::from_fn(|c| (STOPS[i][c] + (STOPS[i + 1][c] - STOPS[i][c]) * s + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_r_sample_has_the_mean_of_its_block() {
        // Of the 15 I-samples of a block 5 are interpolated, 4 in part and 6 traced; those of the block beside it all.
        let mut states = StateMap::new((8, 4));
        let of = |x: u32, y: u32| match (x, y) {
            (0 | 4, 0) => SampleState::Reference,
            (4.., _) => SampleState::Interpolated,
            (1.., 0) => SampleState::Traced,
            (_, 1) => SampleState::Partial,
            (_, 2) => SampleState::Interpolated,
            (0, _) => SampleState::Interpolated,
            _ => SampleState::Traced,
        };
        states.set_rows(0..4, |y, set| (0..8).for_each(|x| set(Some((of(x, y), 1)))));
        let map = similarity_map(&states, &Blocks::uniform(4));
        // A partial sample counts half: 5 + 4 / 2 of 15 are yellow.
        let mixed = std::array::from_fn(|i| ((7 * u32::from(YELLOW[i]) + 8 * u32::from(BLUE[i])) / 15) as u8);
        assert_eq!((map.pixels[0], map.pixels[4]), (mixed, YELLOW));
        assert_eq!([map.pixels[1], map.pixels[8], map.pixels[16], map.pixels[24]], [BLUE, GREEN, YELLOW, YELLOW]);
        // Of a pixel of 2x2 samples the mean of those: at the top left the R-sample, one traced and two in part.
        let pixels = similarity_map_pixels(&states, &Blocks::uniform(4), 2);
        let mean = |i: usize| ((u32::from(mixed[i]) + u32::from(BLUE[i]) + 2 * u32::from(GREEN[i])) / 4) as u8;
        assert_eq!((pixels.width, pixels.height, pixels.pixels[0]), (4, 2, std::array::from_fn(mean)));
    }

    /// The picture had squares of its width, four of them, where the frame had two tiles.
    #[test]
    fn a_frame_narrower_than_a_tile_has_the_rates_of_its_tiles() {
        let mut states = StateMap::new((16, 64));
        // Of the upper tile the lower half is interpolated, of the lower one nothing.
        states.set_rows(16..32, |_, set| (0..16).for_each(|_| set(Some((SampleState::Interpolated, 1)))));
        let map = rate_map_pixels(&states, &Blocks::column(32, vec![2, 2]), 1);
        let (half, all) = (ramp(0.5_f64.sqrt()), ramp(1.0));
        assert_eq!((map.width, map.height), (16, 64));
        assert!(map.pixels[..32 * 16].iter().all(|pixel| *pixel == half));
        assert!(map.pixels[32 * 16..].iter().all(|pixel| *pixel == all));
    }
}
