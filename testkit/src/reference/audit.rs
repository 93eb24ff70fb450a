//! Audits: pixels drawn by chance, traced whole and compared as displayed.

use super::area::Area;
use super::draw::draw;
use super::maker::{KnownSample, Maker};
use super::outcome::Origin;
use crate::past::Traced;

impl Maker<'_> {
    /// Traces what was interpolated in the pixels that are drawn, and compares the pixels as displayed.
    pub fn audit(&mut self, area: &Area, n: usize, frame: u64, every: u64) -> (u64, u64) {
        let width = self.frame.width;
        let (mut sum, mut values) = (0, 0);
        let whole = |(x, y): &(usize, usize)| x % n == 0 && y % n == 0 && x + n <= area.x1 && y + n <= area.y1;
        for (x, y) in area.samples().filter(whole) {
            let pixel = (y / n * (width / n) + x / n) as u64;
            if !draw(pixel ^ (frame << 40)).is_multiple_of(every) {
                continue;
            }
            let samples: Vec<usize> = (0..n * n).map(|i| (y + i / n) * width + x + i % n).collect();
            let before = self.display(&samples);
            for &at in &samples {
                let KnownSample { how, round, .. } = *self.known[at].as_ref().unwrap();
                let is_whole = self.traced[at].iter().all(|traced| *traced == Traced::WHOLE);
                if how == Origin::Interpolated || !is_whole {
                    self.whole(at, if how == Origin::R { how } else { Origin::Traced }, round);
                }
            }
            let after = self.display(&samples);
            sum += (0..3).map(|c| (before[c] - after[c]).pow(2) as u64).sum::<u64>();
            values += 3;
        }
        (sum, values)
    }

    /// A pixel in 8 bits of sRGB, by the formula of the standard.
    fn display(&self, samples: &[usize]) -> [i64; 3] {
        std::array::from_fn(|channel| {
            let sum = samples.iter().fold(0.0f32, |sum, &at| sum + self.tree(at).colour[channel]);
            let linear = f64::from(sum / samples.len() as f32).clamp(0.0, 1.0);
            let coded = if linear > 0.0031308 { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 } else { 12.92 * linear };
            (coded * 255.0).round() as i64
        })
    }
}
