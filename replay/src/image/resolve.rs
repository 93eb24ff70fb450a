//! Samples to pixels: the mean of the sub-samples of each pixel, in linear space.

use std::ops::Range;

use rayon::prelude::*;
use rayreel_formats::math::Vec3;

use super::Image;

/// Gathers the samples of a frame. Each pixel sums its sub-samples in the order in which they are added: row by row.
#[derive(Clone, Debug)]
pub struct Resolver {
    samples: u32,
    image: Image,
}

impl Resolver {
    /// A picture of `width` x `height` pixels with `samples` samples per pixel and axis.
    pub fn new(width: u32, height: u32, samples: u32) -> Self {
        let pixels = vec![[0.0; 3]; width as usize * height as usize];
        Self { samples, image: Image { width, height, pixels } }
    }

    /// Adds the colour of sample (`x`, `y`) of the sample grid.
    ///
    /// # Panics
    /// When the sample is outside the picture.
    pub fn add(&mut self, x: u32, y: u32, colour: Vec3) {
        let (px, py) = (x / self.samples, y / self.samples);
        assert!(px < self.image.width, "sample ({x}, {y}) is outside the picture");
        let pixel = &mut self.image.pixels[py as usize * self.image.width as usize + px as usize];
        for (sum, value) in pixel.iter_mut().zip(colour.to_array()) {
            *sum += value;
        }
    }

    /// Adds whole rows of samples: `colours` is asked for each of them and gives its colours, left to right.
    ///
    /// # Panics
    /// When there are more than the picture has room for.
    pub fn add_rows(&mut self, rows: Range<u32>, colours: impl Fn(u32, &mut dyn FnMut(Vec3)) + Sync) {
        let (width, samples) = (self.image.width as usize, self.samples);
        if rows.is_empty() || width == 0 {
            return;
        }
        // A row of pixels is one task: its sums are made in the order of the samples whatever thread does it.
        let lines = rows.start / samples..rows.end.div_ceil(samples);
        let pixels = &mut self.image.pixels[lines.start as usize * width..lines.end as usize * width];
        pixels.par_chunks_exact_mut(width).zip(lines).for_each(|(pixels, line)| {
            for y in rows.start.max(line * samples)..rows.end.min((line + 1) * samples) {
                let (mut x, mut left) = (0, samples);
                colours(y, &mut |colour| {
                    for (sum, value) in pixels[x].iter_mut().zip(colour.to_array()) {
                        *sum += value;
                    }
                    left -= 1;
                    if left == 0 {
                        (x, left) = (x + 1, samples);
                    }
                });
            }
        });
    }

    /// The picture, once all samples are in.
    pub fn finish(mut self) -> Image {
        let samples = (self.samples * self.samples) as f32;
        for value in self.image.pixels.as_flattened_mut() {
            *value /= samples;
        }
        self.image
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_the_mean_of_its_samples() {
        let mut resolver = Resolver::new(2, 1, 2);
        let colour = |x, y| Vec3::splat((y * 4 + x) as f32);
        // Rows may come in parts, and a part may end within a pixel.
        for rows in [0..1, 1..2] {
            resolver.add_rows(rows, |y, add| (0..4).for_each(|x| add(colour(x, y))));
        }
        assert_eq!(resolver.finish().pixels, [[2.5; 3], [4.5; 3]]);
    }
}
