//! The similarity map, as the paper's Figure 4: yellow where samples were similar and interpolated, blue where they were not
//! and had to be traced.

use crate::frame::states::StateMap;
use crate::image::Srgb8;
use crate::policy::view::SampleState;

/// Similar: interpolated.
pub const YELLOW: [u8; 3] = [250, 215, 50];
/// Dissimilar: traced.
pub const BLUE: [u8; 3] = [25, 60, 170];

/// The map at sample resolution. I-samples show what became of them; an R-sample takes the mean of the I-samples of its
/// block, so that the lattice of always-traced samples does not veil the picture. A block without I-samples is blue.
pub fn similarity_map(states: &StateMap, block: u32) -> Srgb8 {
    let (width, height) = (states.width, states.height);
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            pixels.push(match states.state(x, y) {
                SampleState::Interpolated => YELLOW,
                SampleState::Traced => BLUE,
                SampleState::Reference => blend(states, block, x, y),
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
            similar += u32::from(state == SampleState::Interpolated);
            all += u32::from(state != SampleState::Reference);
        }
    }
    if all == 0 {
        return BLUE;
    }
    let mix = |yellow: u8, blue: u8| (u32::from(yellow) * similar + u32::from(blue) * (all - similar)) / all;
    std::array::from_fn(|i| mix(YELLOW[i], BLUE[i]) as u8)
}

/// The map at pixel resolution: the mean of the `samples` x `samples` map values of each pixel.
pub fn similarity_map_pixels(states: &StateMap, block: u32, samples: u32) -> Srgb8 {
    let map = similarity_map(states, block);
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
