//! Pictures to look at closely, with what is known of their tiles.

use serde::{Deserialize, Serialize};

/// The pictures of one scene under one policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewerSet {
    /// Name of the scene.
    pub scene: String,
    /// `2x2` or `1x1`.
    pub mode: String,
    /// Name of the policy.
    pub policy: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Tile edge, pixels; the last column and row of tiles may be cut off.
    pub tile_px: u32,
    /// The files.
    pub images: ViewerImages,
    /// The tiles, row by row; empty if not known.
    pub tiles: Vec<TileFigures>,
}

/// Picture files of a set. Each is shown at the size of the set, whatever size the file has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewerImages {
    /// `full` in the same mode.
    pub reference: Option<String>,
    /// The policy's picture.
    pub result: Option<String>,
    /// Their difference.
    pub error: Option<String>,
    /// Where a viewer sees that they differ: FLIP.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flip: Option<String>,
    /// Similarity map.
    pub similarity: Option<String>,
    /// Rate map.
    pub rate: Option<String>,
}

impl ViewerImages {
    /// The names of the files.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        [&self.reference, &self.result, &self.error, &self.flip, &self.similarity, &self.rate]
            .into_iter()
            .filter_map(|name| name.as_deref())
    }
}

/// A tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TileFigures {
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays traced.
    pub rays_traced: u64,
    /// Traced samples per sample of the grid.
    pub mean_rate: f64,
    /// Interpolated samples per sample that could have been; null where there are none.
    pub similarity_ratio: Option<f64>,
    /// PSNR, dB; null if nothing differs.
    pub psnr_db: Option<f64>,
}
