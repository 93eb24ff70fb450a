//! Flicker: how much the error of a picture changes from one frame to the next.
//!
//! With result R and reference F in 8-bit sRGB, the error of frame t is E = R - F, and the flicker between two frames is the root
//! of the mean of (E(t) - E(t - 1))^2 over all values: the same as comparing the change of the result with the change that the
//! reference goes through. An error that stays where it is on the screen does not flicker; one that pops up, or swims over
//! the picture, does. Over a sequence the mean is taken of the squares of all pairs of consecutive frames.
//!
//! Its limits: it is a difference of values and knows neither frame rate nor viewer; an error that moves with an object counts,
//! though the eye follows the object and may not mind it; and a reference that itself flickers (one sample a pixel) is taken as
//! right.

use super::Srgb8;
use super::psnr::SquaredError;
use crate::error::Result;

/// The error of the last frame, by which the next is measured.
#[derive(Clone, Debug, Default)]
pub struct Flicker {
    previous: Option<(u32, Vec<[i16; 3]>)>,
}

impl Flicker {
    /// Takes the next frame; gives the squared change of the error since the frame before, or `None` if that was not the last
    /// one taken, or had another size.
    ///
    /// # Errors
    /// When the sizes of `result` and `reference` differ.
    pub fn next(&mut self, frame: u32, result: &Srgb8, reference: &Srgb8) -> Result<Option<SquaredError>> {
        result.same_size(reference)?;
        let error = |(r, f): (&[u8; 3], &[u8; 3])| std::array::from_fn(|c| i16::from(r[c]) - i16::from(f[c]));
        let errors: Vec<[i16; 3]> = result.pixels.iter().zip(&reference.pixels).map(error).collect();
        let follows = |(last, of): &(u32, Vec<_>)| frame.checked_sub(1) == Some(*last) && of.len() == errors.len();
        let change = self.previous.as_ref().filter(|last| follows(last)).map(|(_, last)| change(last, &errors));
        self.previous = Some((frame, errors));
        Ok(change)
    }
}

fn change(before: &[[i16; 3]], now: &[[i16; 3]]) -> SquaredError {
    let squared = |(a, b): (&i16, &i16)| i64::from(i32::from(*a) - i32::from(*b)).pow(2) as u64;
    let sum = before.as_flattened().iter().zip(now.as_flattened()).map(squared).sum();
    SquaredError { sum, values: now.len() as u64 * 3 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(codes: [u8; 4]) -> Srgb8 {
        Srgb8 { width: 2, height: 2, pixels: codes.map(|code| [code; 3]).to_vec() }
    }

    /// Flicker of each pair of frames.
    fn flicker(frames: &[([u8; 4], [u8; 4])]) -> Vec<Option<SquaredError>> {
        let mut state = Flicker::default();
        let mut next = |(i, &(r, f)): (u32, &_)| state.next(i, &picture(r), &picture(f)).unwrap();
        (7..).zip(frames).map(&mut next).collect()
    }

    #[test]
    fn an_error_that_stays_does_not_flicker() {
        // The scene moves, and the result is 5 too bright everywhere in both frames.
        let still = flicker(&[([15, 25, 35, 45], [10, 20, 30, 40]), ([105, 5, 205, 55], [100, 0, 200, 50])]);
        assert_eq!(still, [None, Some(SquaredError { sum: 0, values: 12 })]);
        // Nor does an exact result of a flickering scene.
        let exact = flicker(&[([0; 4], [0; 4]), ([255; 4], [255; 4])]);
        assert_eq!(exact[1].unwrap().rms(), 0.0);
    }

    #[test]
    fn one_that_alternates_does() {
        // Errors of +3 and -3 in turn change by 6 each frame.
        let (high, low) = (([53; 4], [50; 4]), ([47; 4], [50; 4]));
        for error in &flicker(&[high, low, high])[1..] {
            assert_eq!(error.unwrap(), SquaredError { sum: 36 * 12, values: 12 });
            assert_eq!(error.unwrap().rms(), 6.0);
        }
        // One pixel of four pops by 255 each way: 510^2 in a quarter of the values.
        let popping = flicker(&[([255, 0, 0, 0], [0; 4]), ([0; 4], [255, 0, 0, 0])]);
        assert_eq!(popping[1].unwrap(), SquaredError { sum: 510 * 510 * 3, values: 12 });
        assert_eq!(popping[1].unwrap().rms(), 255.0);
    }

    #[test]
    fn only_consecutive_frames_are_pairs() {
        let mut state = Flicker::default();
        let (a, b) = (picture([1; 4]), picture([2; 4]));
        let mut pair = |frame| state.next(frame, &a, &b).unwrap().is_some();
        assert_eq!([0, 1, 3, 4, 4, 3, 4].map(&mut pair), [false, true, false, true, false, false, true]);
        let wide = Srgb8 { width: 4, height: 1, ..picture([1; 4]) };
        assert!(state.next(5, &wide, &a).is_err());
    }
}
