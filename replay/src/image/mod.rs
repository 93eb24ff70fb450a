//! Pictures: resolving samples to pixels, comparing, writing and reading them.

pub mod compare;
pub mod errors;
pub mod files;
pub mod flicker;
pub mod flip;
pub mod layers;
pub mod psnr;
pub mod resolve;
pub mod srgb;
pub mod ssim;
pub mod tiles;

use crate::error::{ReplayError, Result};

/// A picture in linear RGB, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels.
    pub pixels: Vec<[f32; 3]>,
}

/// A picture in 8-bit sRGB, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Srgb8 {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl Srgb8 {
    /// Number of values: three a pixel.
    pub fn values(&self) -> usize {
        self.pixels.len() * 3
    }

    /// All values as bytes.
    pub fn bytes(&self) -> &[u8] {
        self.pixels.as_flattened()
    }

    /// Refuses to compare pictures of different sizes.
    pub(crate) fn same_size(&self, other: &Self) -> Result<()> {
        if (self.width, self.height) == (other.width, other.height) {
            return Ok(());
        }
        let detail = format!(
            "a picture of {} x {} pixels cannot be compared with one of {} x {}",
            self.width, self.height, other.width, other.height
        );
        Err(ReplayError::Usage { detail })
    }
}
