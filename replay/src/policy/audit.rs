//! Audits: a few pixels are traced whole, to see how far off the picture is.
//!
//! A policy cannot know what it did not trace. So one pixel in `target.audit`, drawn by a hash of frame and place, is traced in
//! any case. Its rays go out in the round in which its samples were interpolated. Tests and neighbours use the interpolated
//! values as everywhere. In the end both are compared as displayed, and the picture shows what was traced.
//!
//! The rest of a sample of which some rays were traced follows in its round too. So the mean over the audited pixels estimates the
//! squared error of the picture without bias.

use super::scramble::scramble;
use super::view::{SampleState, TileView};
use crate::image::psnr::SquaredError;
use crate::image::srgb;

/// Which pixels are audited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Audit {
    /// One pixel in so many.
    pub every: u32,
    /// Samples per pixel and axis.
    pub samples: u32,
    /// Pixels in a row of the picture.
    pub width: u32,
}

impl Audit {
    /// Whether pixel (`x`, `y`) of frame `frame` is audited.
    pub fn picks(&self, frame: u32, x: u32, y: u32) -> bool {
        let place = u64::from(y) * u64::from(self.width) + u64::from(x);
        scramble(place ^ u64::from(frame) << 40).is_multiple_of(u64::from(self.every))
    }

    /// Audits a tile whose samples are all decided. Pixels that reach into another tile are left out.
    pub fn run(&self, view: &mut TileView, frame: u32) -> SquaredError {
        let (rect, n) = (view.rect(), self.samples);
        let columns = rect.x.div_ceil(n)..(rect.x + rect.width) / n;
        let rows = rect.y.div_ceil(n)..(rect.y + rect.height) / n;
        let mut error = SquaredError::default();
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            if self.picks(frame, x, y) {
                let before = self.shown(view, x, y);
                self.trace(view, x, y);
                let after = self.shown(view, x, y);
                let squares = before.iter().zip(after).map(|(&a, b)| u64::from(a.abs_diff(b)).pow(2));
                error = error + SquaredError { sum: squares.sum(), values: 3 };
            }
        }
        error
    }

    fn inside(&self, x: u32, y: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
        let n = self.samples;
        (y * n..(y + 1) * n).flat_map(move |y| (x * n..(x + 1) * n).map(move |x| (x, y)))
    }

    fn trace(&self, view: &mut TileView, x: u32, y: u32) {
        for (x, y) in self.inside(x, y) {
            match view.state(x, y) {
                Some((SampleState::Interpolated, round)) => view.correct(x, y, round),
                Some(_) if !view.is_whole(x, y) => view.complete(x, y),
                _ => {}
            }
        }
    }

    /// The pixel in 8-bit sRGB.
    fn shown(&self, view: &TileView, x: u32, y: u32) -> [u8; 3] {
        let mut sum = [0.0f32; 3];
        for (x, y) in self.inside(x, y) {
            sum.iter_mut().zip(view.tree(x, y)[0].colour.to_array()).for_each(|(sum, v)| *sum += v);
        }
        sum.map(|v| srgb::code(v / (self.samples * self.samples) as f32))
    }
}
