//! Result against reference: every figure of quality of a frame.

use rayreel_formats::scene::Meta;

use super::flicker::Flicker;
use super::flip::{self, FlipMap};
use super::psnr::{SquaredError, decibels};
use super::tiles::{TileGrid, tile_errors, worst};
use super::{Image, srgb, ssim};
use crate::error::Result;

/// How near the picture is to that of `full`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Sum of the squared differences of all 8-bit sRGB values.
    pub squared_error: u64,
    /// Number of values: three a pixel.
    pub values: u64,
    /// Structural similarity; `None` if it was not asked for, or of a picture too small for its window.
    pub ssim: Option<f64>,
    /// Mean FLIP value: 0 for identical pictures, at most 1; `None` if it was not asked for.
    pub flip: Option<f64>,
    /// The tile that differs most; `None` if none does.
    pub worst_tile: Option<WorstTile>,
    /// Squared change of the error since the frame before; `None` if that was not replayed.
    pub flicker: Option<SquaredError>,
}

impl Quality {
    /// PSNR in dB; `None` if nothing differs.
    pub fn psnr_db(&self) -> Option<f64> {
        decibels(self.squared_error, self.values)
    }
}

/// The tile that differs most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorstTile {
    /// Its frame.
    pub frame: u32,
    /// Its number in the frame.
    pub tile: u32,
    /// Its error.
    pub error: SquaredError,
}

/// Compares the frames of a sequence, one after the other: flicker is between a frame and the one before.
#[derive(Clone, Debug)]
pub struct Comparer {
    grid: TileGrid,
    perception: bool,
    flicker: Flicker,
}

/// What a comparison found.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The figures.
    pub quality: Quality,
    /// Squared error of each tile, in order.
    pub tiles: Vec<SquaredError>,
    /// The FLIP map, if it was asked for.
    pub flip: Option<FlipMap>,
}

impl Comparer {
    /// For the frames of a trace; with `perception` by SSIM and FLIP too.
    pub fn new(meta: &Meta, perception: bool) -> Self {
        Self { grid: TileGrid::of(meta), perception, flicker: Flicker::default() }
    }

    /// Compares the two linear pictures of frame `frame`, as a screen shows them: in 8-bit sRGB.
    ///
    /// # Errors
    /// When the sizes differ.
    pub fn compare(&mut self, frame: u32, image: &Image, full: &Image) -> Result<Comparison> {
        let (a, b) = (srgb::encode(image), srgb::encode(full));
        let tiles = tile_errors(&a, &b, self.grid)?;
        let flip = self.perception.then(|| flip::flip(&a, &b, flip::PIXELS_PER_DEGREE)).transpose()?;
        let ssim = if self.perception { ssim::ssim(&a, &b)? } else { None };
        let all: SquaredError = tiles.iter().copied().sum();
        let quality = Quality {
            squared_error: all.sum,
            values: all.values,
            ssim,
            flip: flip.as_ref().map(FlipMap::mean),
            worst_tile: worst(&tiles).map(|(tile, error)| WorstTile { frame, tile, error }),
            flicker: self.flicker.next(frame, &a, &b)?,
        };
        Ok(Comparison { quality, tiles, flip })
    }
}
