//! Sampling policies: which recorded samples are traced, and which are interpolated from traced ones.
//!
//! A [`SamplePolicy`] decides, tile by tile, through a [`TileView`], which gives out nothing that the policy has not traced. The
//! built-in ones are the kinds of [`Policy`]. They cut the sample grid of the frame into blocks of n x n samples. *R-samples*
//! stand at every column that is a multiple of n, or the last one, in every row that is a multiple of n, or the last one. They
//! are always traced. The others are *I-samples*, decided in two steps:
//!
//! - **X step**, along each row of R-samples. Between two neighbouring R-samples that are similar the samples are interpolated.
//!   Otherwise they are traced: all of them ([`Refine::Direct`]), or the middle one, after which both halves are tested again
//!   ([`Refine::Hierarchical`]).
//! - **Y step**, down each column, the same between two neighbouring rows of R-samples, whose samples are all known by now.
//!
//! Then, if it is on, **correction**: interpolated samples that a traced neighbour contradicts are traced too. With `secondary`
//! an I-sample need not be traced whole: each hit of its ray tree is decided by itself.
//!
//! The block is the same for all tiles (`adaptive`), follows each tile's similarity in the frame before (`multirate`), or the
//! distance from a gaze point (`foveated`); `full` has blocks of one sample. But for blocks that differ and for correction, the
//! result depends on the frame alone and not on its tiles, which only matter for accounting ([`Apron`]).
//!
//! The files, each of which uses only those before it: `schema` and `load` (settings), `tree` (a sample's hits), `interpolate`,
//! `similarity`, `lattice` (where R-samples stand), `view`, `reuse` (hit by hit), `correct`, `audit`, `target`, `rate` (blocks and
//! limits of tiles), `sampler` (the seam), `adaptive` (the steps on a tile), `blocks` (all of it as a sampler).

mod adaptive;
mod audit;
mod blocks;
mod correct;
mod interpolate;
mod lattice;
mod load;
mod rate;
mod reuse;
mod sampler;
pub mod schema;
mod similarity;
mod target;
pub mod tree;
pub mod view;

use serde::{Deserialize, Serialize};

pub use interpolate::between;
pub use load::{NamedPolicy, PRESETS};
pub use sampler::{SamplePolicy, Sampler};
pub use view::{SampleState, TileView};

/// A sampling policy, resolved: every value is there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Policy {
    /// Every sample is traced.
    Full,
    /// Similar samples are interpolated.
    Adaptive(Adaptive),
    /// The same, with the block of each tile chosen by its similarity in the frame before.
    Multirate(Multirate),
    /// The same, with larger blocks away from where the eye looks.
    Foveated(Foveated),
}

impl Policy {
    /// The kind, as `kind = ".."` names it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Adaptive(_) => "adaptive",
            Self::Multirate(_) => "multirate",
            Self::Foveated(_) => "foveated",
        }
    }
}

/// What all policies but `full` do with the samples of a block, whatever its size. [`schema`] rejects keys that do not exist.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sampling {
    /// What happens between dissimilar samples.
    pub refine: Refine,
    /// Each hit of a ray tree is decided by itself.
    pub secondary: bool,
    /// With `secondary`: a primary hit may be interpolated although some of its children are traced (POLICIES.md says
    /// what that means for a replay); else it is traced with them.
    pub stand_in: bool,
    /// When two samples are similar.
    pub similarity: Similarity,
    /// What is traced after all.
    pub correct: Correct,
}

/// The values of [`Policy::Adaptive`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adaptive {
    /// Block edge n in samples: one R-sample per n x n block.
    pub block: u32,
    /// Who pays for the samples on the far border of a tile.
    pub apron: Apron,
    /// What is done within a block.
    #[serde(flatten)]
    pub sampling: Sampling,
}

/// The values of [`Policy::Multirate`]: as [`Adaptive`], with shared aprons, and a block of its own for each tile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Multirate {
    /// Block of all tiles in a first frame and after a cut.
    pub start: u32,
    /// Smallest block.
    pub finest: u32,
    /// Largest block.
    pub coarsest: u32,
    /// A tile asks for the next larger block at this similarity ratio or above.
    pub raise: f64,
    /// A tile asks for the next smaller block at this similarity ratio or below.
    pub lower: f64,
    /// In odd frames `raise` is this much higher and `lower` this much lower, so that a ratio near a threshold does not
    /// switch the block to and fro (paper, section 3: "we can switch the threshold values").
    pub alternate: f64,
    /// Frames in a row that must ask for the same change before it is made.
    pub hold: u32,
    /// A camera that turns by more than this between frames is a cut, degrees.
    pub cut_deg: f64,
    /// A mean change of the tiles' similarity ratios above this is a cut too, seen one frame later.
    pub cut_change: f64,
    /// The picture's quality that the colour limit is moved to hold.
    pub target: Target,
    /// What is done within a block.
    #[serde(flatten)]
    pub sampling: Sampling,
}

/// The quality to hold, and how far the colour limit may be moved for it: POLICIES.md has the rules.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// PSNR of the picture against `full`, dB; off: the limit stays, and nothing is audited.
    pub psnr_db: Limit,
    /// One pixel in so many is traced whole, to see how far off interpolation was.
    pub audit: u32,
    /// Smallest factor on the colour limit.
    pub strictest: f64,
    /// Largest factor on the colour limit.
    pub loosest: f64,
    /// The limit is not made stricter than it stands where at least this share of the samples is traced.
    pub share: f64,
}

/// The values of [`Policy::Foveated`]: as [`Adaptive`], with shared aprons, and the block by distance from the gaze point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Foveated {
    /// Where the eye looks, fraction of the picture's width.
    pub gaze_x: f64,
    /// Where the eye looks, fraction of the picture's height.
    pub gaze_y: f64,
    /// Tiles nearer than this have the smallest block, fraction of the picture's height.
    pub inner: f64,
    /// Tiles farther than this have the largest block, fraction of the picture's height.
    pub outer: f64,
    /// Smallest block.
    pub finest: u32,
    /// Largest block.
    pub coarsest: u32,
    /// Factor on the colour limit from `outer` on; it grows linearly from 1 at `inner`.
    pub relax: f64,
    /// What is done within a block.
    #[serde(flatten)]
    pub sampling: Sampling,
}

/// Which interpolated samples are traced after all (after Kim et al. 2016).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Correct {
    /// Most passes over a tile; 0 switches correction off.
    pub passes: u32,
    /// Attributes that contradict count only where the display colours differ by more than this; off: always.
    pub colour: Limit,
}

/// What happens between two dissimilar samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Refine {
    /// All samples between are traced.
    Direct,
    /// The middle one is traced, and both halves are tested again.
    Hierarchical,
}

/// Who pays for the closing row and column of a tile: the samples of the next tiles that its tests read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Apron {
    /// They are traced once, by the tile that owns them, and shared.
    Share,
    /// Each tile traces what it needs of them again. The picture is the same; the rays count as apron rays.
    Retrace,
}

/// When two samples are similar: every test that is on must pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Similarity {
    /// The objects are the same.
    pub object_id: bool,
    /// Largest angle between the shading normals, degrees.
    pub normal_deg: Limit,
    /// The shadow rays to all lights found the same.
    pub shadow: bool,
    /// Largest distance between the hit points, as a fraction of the shorter ray length.
    pub position: Limit,
    /// Largest distance of the second hit point from the tangent plane of the first, as a fraction of the shorter ray length.
    pub plane: Limit,
    /// Largest difference of the hits' local colours as displayed: where object, normal and shadows agree, texture is what
    /// is left to differ.
    pub texture: Limit,
    /// Largest difference of the samples' colours as displayed, across a gap of two samples and for a sample of three rays
    /// (POLICIES.md has the rule).
    pub colour: Limit,
    /// A traced middle sample that was predicted within the colour limit passes the colour test for both its halves.
    pub predict: bool,
    /// The tests are made on the secondary hits too.
    pub secondary: bool,
    /// Secondary hits may be unlike where the colours differ by less than this fraction of the colour limit.
    pub unlike: Limit,
}

impl Similarity {
    /// No test: all hits are alike.
    pub const NONE: Self = Self {
        object_id: false,
        normal_deg: Limit::Off,
        shadow: false,
        position: Limit::Off,
        plane: Limit::Off,
        texture: Limit::Off,
        colour: Limit::Off,
        predict: false,
        secondary: false,
        unlike: Limit::Off,
    };
}

impl Sampling {
    /// No test, no correction; whole samples.
    pub const NONE: Self = Self {
        refine: Refine::Direct,
        secondary: false,
        stand_in: false,
        similarity: Similarity::NONE,
        correct: Correct { passes: 0, colour: Limit::Off },
    };
}

/// A threshold that can be off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "LimitText", into = "LimitText")]
pub enum Limit {
    /// The test is not made.
    Off,
    /// The test passes up to this value, inclusive.
    At(f64),
}

impl Limit {
    /// The value, if the test is on.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Off => None,
            Self::At(value) => Some(value),
        }
    }
}

/// How a [`Limit`] is written: a number, or `"off"`.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum LimitText {
    At(f64),
    Off(OffText),
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum OffText {
    Off,
}

impl From<LimitText> for Limit {
    fn from(text: LimitText) -> Self {
        match text {
            LimitText::At(value) => Self::At(value),
            LimitText::Off(OffText::Off) => Self::Off,
        }
    }
}

impl From<Limit> for LimitText {
    fn from(limit: Limit) -> Self {
        match limit {
            Limit::At(value) => Self::At(value),
            Limit::Off => Self::Off(OffText::Off),
        }
    }
}
