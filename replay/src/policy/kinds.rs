//! The kinds of policies and their settings.

use rayreel_settings::Rule::{Count, Limit as LimitUpTo, Number, OneOf};
use rayreel_settings::{Rule, settings};
use serde::{Deserialize, Serialize};

use super::limit::Limit;
use super::sampling::{Apron, Sampling};

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

/// Block edges of tiles that differ in their blocks: each divides the next.
const NESTED: Rule = OneOf(&[2, 4, 8, 16]);

settings! {
    /// The values of [`Policy::Adaptive`].
    pub struct Adaptive {
        block: u32 = OneOf(&[2, 3, 4, 8, 16]), "block edge in samples: one R-sample per block";
        apron: Apron = Apron::RULE, "the far border of a tile: shared with its owner, or traced again";
        ..sampling: Sampling, "what is done within a block";
    }

    /// The values of [`Policy::Multirate`]: as [`Adaptive`], with shared aprons, and a block for each tile.
    pub struct Multirate {
        start: u32 = NESTED, "block edge of a first frame and after a cut", "samples";
        finest: u32 = NESTED, "smallest block edge", "samples";
        coarsest: u32 = NESTED, "largest block edge", "samples";
        raise: f64 = Number(1.0), "a tile asks for a larger block at this similarity ratio or above";
        lower: f64 = Number(1.0), "a tile asks for a smaller block at this similarity ratio or below";
        /// So a ratio near a threshold does not switch the block to and fro (paper, section 3: "we can switch the threshold
        /// values").
        alternate: f64 = Number(1.0), "in odd frames raise is this much higher and lower this much lower";
        hold: u32 = OneOf(&[1, 2, 3, 4, 5, 6, 7, 8]), "frames in a row that must ask for a change";
        cut_deg: f64 = Number(180.0), "a camera that turns by more than this is a cut", "degrees";
        /// It is seen one frame later.
        cut_change: f64 = Number(1.0), "a mean change of the similarity ratios above this is a cut";
        target: Target, "the picture's quality that the colour limit is moved to hold";
        ..sampling: Sampling, "what is done within a block";
    }

    /// The quality to hold, and how far the colour limit may be moved for it: [`super::target`] has the rules.
    #[serde(deny_unknown_fields)]
    pub struct Target {
        /// PSNR of the picture against `full`; off: the limit stays, and nothing is audited.
        psnr_db: Limit = LimitUpTo(99.0), "quality that the colour limit is moved to hold", "dB";
        audit: u32 = Count(1, 1 << 20), "one pixel in so many is traced whole to estimate the error";
        strictest: f64 = Number(1.0), "smallest factor on the colour limit";
        loosest: f64 = Number(100.0), "largest factor on the colour limit";
        share: f64 = Number(1.0), "no factor below 1 where this share of the samples is traced";
    }

    /// The values of [`Policy::Foveated`]: as [`Adaptive`], with shared aprons, and the block by distance from the gaze point.
    pub struct Foveated {
        gaze_x: f64 = Number(1.0), "where the eye looks", "fraction of the width";
        gaze_y: f64 = Number(1.0), "where the eye looks", "fraction of the height";
        inner: f64 = Number(4.0), "up to here blocks are the smallest", "fraction of the height";
        outer: f64 = Number(4.0), "from here on blocks are the largest", "fraction of the height";
        finest: u32 = NESTED, "smallest block edge", "samples";
        coarsest: u32 = NESTED, "largest block edge", "samples";
        /// It grows linearly from 1 at `inner`.
        relax: f64 = Number(100.0), "factor on the colour limit from the outer radius on";
        ..sampling: Sampling, "what is done within a block";
    }
}
