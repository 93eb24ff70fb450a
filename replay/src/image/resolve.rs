//! Samples to pixels: the mean of the sub-samples of each pixel, in linear space.

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
        for (i, (x, y)) in [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (2, 1), (3, 1)].into_iter().enumerate() {
            resolver.add(x, y, Vec3::splat(i as f32));
        }
        assert_eq!(resolver.finish().pixels, [[2.5; 3], [4.5; 3]]);
    }
}
