//! Sampling policies: which recorded samples are traced, and which are interpolated from traced ones.
//!
//! The sample grid of the whole frame is cut into blocks of n x n samples. *R-samples* stand at every column that is a
//! multiple of n, or the last one, in every row that is a multiple of n, or the last one; they are always traced. The others
//! are *I-samples*, decided in two steps:
//!
//! - **X step**, along each row of R-samples: between two neighbouring R-samples that are similar ([`similarity`]) the
//!   samples are interpolated ([`interpolate`]), otherwise traced: all of them ([`Refine::Direct`]), or the middle one, after
//!   which both halves are tested again ([`Refine::Hierarchical`]).
//! - **Y step**, down each column, the same between two neighbouring rows of R-samples, whose samples are all known by now.
//!
//! The result depends on the frame alone, not on its tiles; these matter for accounting ([`Apron`]). A policy sees only what
//! it has traced: [`view::TileView`] gives out nothing else. `full` is the same with blocks of one sample.
//!
//! Not here: which tiles are in memory when (see [`crate::frame`]).

pub mod adaptive;
pub mod interpolate;
pub mod lattice;
mod load;
pub mod schema;
pub mod similarity;
pub mod view;

use serde::{Deserialize, Serialize};

pub use load::{NamedPolicy, PRESETS};

/// A sampling policy, resolved: every value is there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Policy {
    /// Every sample is traced.
    Full,
    /// Similar samples are interpolated.
    Adaptive(Adaptive),
}

impl Policy {
    /// The kind, as `kind = ".."` names it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Adaptive(_) => "adaptive",
        }
    }
}

/// The values of [`Policy::Adaptive`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adaptive {
    /// Block edge n in samples: one R-sample per n x n block.
    pub block: u32,
    /// What happens between dissimilar samples.
    pub refine: Refine,
    /// Who pays for the samples on the far border of a tile.
    pub apron: Apron,
    /// When two samples are similar.
    pub similarity: Similarity,
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

/// When two samples are similar: every test that is on must pass. Tests look at the primary hits only.
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
