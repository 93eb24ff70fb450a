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
    /// The same, with what the frame before brought of a place.
    Temporal(Temporal),
    /// The same, with larger blocks away from where the eye looks.
    Foveated(Foveated),
    /// Squares whose corners differ in their colours are subdivided.
    Whitted1980(Whitted1980),
    /// Where the contrast of neighbouring samples is high all are traced.
    Mitchell1987(Mitchell1987),
    /// Attributes with priorities say how many samples of a pixel are traced.
    Jin2009(Jin2009),
}

impl Policy {
    /// The kind, as `kind = ".."` names it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Adaptive(_) => "adaptive",
            Self::Multirate(_) => "multirate",
            Self::Temporal(_) => "temporal",
            Self::Foveated(_) => "foveated",
            Self::Whitted1980(_) => "whitted1980",
            Self::Mitchell1987(_) => "mitchell1987",
            Self::Jin2009(_) => "jin2009",
        }
    }

    /// The edges that tiles must be multiples of: where finer blocks are possible too, they divide these.
    pub(super) fn edges(&self) -> Vec<Edge> {
        let nested = |edge| Edge { key: "coarsest", edge, allowed: NESTED_EDGES };
        match self {
            Self::Full => Vec::new(),
            Self::Adaptive(Adaptive { block, .. })
            | Self::Whitted1980(Whitted1980 { block, .. })
            | Self::Mitchell1987(Mitchell1987 { block, .. })
            | Self::Jin2009(Jin2009 { block, .. }) => vec![Edge { key: "block", edge: *block, allowed: BLOCK_EDGES }],
            Self::Multirate(multirate) => vec![nested(multirate.coarsest)],
            Self::Foveated(foveated) => vec![nested(foveated.coarsest)],
            Self::Temporal(Temporal { multirate, history, .. }) => {
                vec![nested(multirate.coarsest), Edge { key: "history.step", edge: history.step, allowed: STEPS }]
            }
        }
    }

    /// The values by which each tile has a block that follows the frame before, if it has.
    pub(super) fn multirate(&self) -> Option<&Multirate> {
        match self {
            Self::Multirate(multirate) => Some(multirate),
            Self::Temporal(temporal) => Some(&temporal.multirate),
            _ => None,
        }
    }
}

/// An edge that tiles must be a multiple of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// The key that it is set by.
    pub key: &'static str,
    /// Samples.
    pub edge: u32,
    /// What the key may be.
    pub allowed: &'static [i64],
}

/// Block edges where all tiles have the same.
const BLOCK_EDGES: &[i64] = &[2, 3, 4, 8, 16];
const BLOCK: Rule = OneOf(BLOCK_EDGES);

/// Priorities of [`Jin2009`].
const PRIORITY: Rule = OneOf(&[0, 1, 2]);

/// Block edges of tiles that differ in their blocks: each divides the next.
const NESTED_EDGES: &[i64] = &[2, 4, 8, 16];
const NESTED: Rule = OneOf(NESTED_EDGES);

/// From one entry of a history to the next.
const STEPS: &[i64] = &[1, 2, 4];

settings! {
    /// The values of [`Policy::Adaptive`].
    pub struct Adaptive {
        block: u32 = BLOCK, "block edge in samples: one R-sample per block";
        apron: Apron = Apron::RULE, "the far border of a tile: shared with its owner, or traced again";
        ..sampling: Sampling, "what is done within a block";
    }

    /// The values of [`Policy::Multirate`]: as [`Adaptive`], with shared aprons, and a block for each tile.
    pub struct Multirate {
        start: u32 = NESTED, "block edge of a first frame and after a cut", "samples";
        finest: u32 = NESTED, "smallest block edge", "samples";
        coarsest: u32 = NESTED, "largest block edge", "samples";
        /// [`super::rate`] has the rule.
        raise: f64 = Number(1024.0), "a tile asks for a larger block at so many traced I-samples for each R-sample, or fewer";
        lower: f64 = Number(1024.0), "a tile asks for a smaller block at so many traced I-samples for each R-sample, or more";
        /// So a tile near a threshold does not switch its block to and fro (paper, section 3: "we can switch the threshold
        /// values").
        alternate: f64 = Number(10.0), "in odd frames both thresholds lie further out by this share";
        hold: u32 = OneOf(&[1, 2, 3, 4, 5, 6, 7, 8]), "frames in a row that must ask for a change";
        cut_deg: f64 = Number(180.0), "a camera that turns by more than this is a cut", "degrees";
        /// It is seen one frame later.
        cut_change: f64 = Number(1.0), "a mean change of the similarity ratios above this is a cut";
        target: Target, "the picture's quality that the colour limit is moved to hold";
        ..sampling: Sampling, "what is done within a block";
    }

    /// The values of [`Policy::Temporal`]: as [`Multirate`], with a history.
    pub struct Temporal {
        history: HistoryRules, "what is taken from the frame before";
        ..multirate: Multirate, "what is traced of the rest";
    }

    /// Which lights are taken from the frame before: [`super::history`] has the rules.
    #[serde(deny_unknown_fields)]
    pub struct HistoryRules {
        /// Entries stand where both coordinates are multiples of this.
        step: u32 = OneOf(STEPS), "from one entry of the history to the next", "samples";
        depth: u32 = Count(0, 14), "hits below so many bounces are kept of a sample";
        refresh: u32 = Count(1, 1024), "of so many samples one looks for its lights in any case, another one in each frame";
        /// Of the lights of a tile that were known and looked for all the same, so many may be found otherwise.
        trust: f64 = Number(1.0), "largest share of mistaken lights in a tile that looks back";
        age: u32 = Count(1, 255), "frames since an entry looked for its lights, at most";
        cover: f64 = Number(1.0), "least share of the four entries around a place that is of its surface";
        plane: f64 = Number(1.0), "largest distance of an entry from the tangent plane", "fraction of the distance from the eye";
        normal_deg: f64 = Number(180.0), "largest angle between the normals of a hit and of its like in an entry", "degrees";
        distance: f64 = Number(100.0), "hits below: largest difference of the lengths of both rays", "fraction of the length";
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
        first_detail: f64 = Number(1.0), "first frames that miss it: share of a tile's I-samples, traced, from which the one two rows below has half the block";
        first_correct: f64 = Number(1.0), "factor on the limits of correction in first frames and after a cut";
        first_growth: f64 = Number(4.0), "power of first_correct with which the error of first frames is taken to grow";
        decay: f64 = Number(1.0), "weight of a frame, over that of the one after it, in the error and the traced share; of a row of tiles in the error of a first frame";
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

    /// The values of [`Policy::Whitted1980`].
    pub struct Whitted1980 {
        block: u32 = BLOCK, "block edge in samples: one R-sample per block";
        colour: f64 = Number(2.0), "largest difference of two corners' colours as displayed";
        least: u32 = Count(1, 16), "squares are halved where they are longer than this", "samples";
    }

    /// The values of [`Policy::Mitchell1987`].
    pub struct Mitchell1987 {
        block: u32 = BLOCK, "block edge in samples: one R-sample per block";
        red: f64 = Number(1.0), "largest contrast of the corners in red";
        green: f64 = Number(1.0), "largest contrast of the corners in green";
        blue: f64 = Number(1.0), "largest contrast of the corners in blue";
    }

    /// The values of [`Policy::Jin2009`].
    pub struct Jin2009 {
        block: u32 = BLOCK, "block edge in samples: one R-sample per block";
        priority: Priorities, "what a difference asks for: 0 nothing, 1 half of the samples, 2 all";
        threshold: Thresholds, "what a difference is";
    }

    /// The priorities of [`Jin2009`]: his rendering elements.
    #[serde(deny_unknown_fields)]
    pub struct Priorities {
        colour: u32 = PRIORITY, "of the colours of the samples";
        poid: u32 = PRIORITY, "of the objects of primary hits";
        psn: u32 = PRIORITY, "of the normals of primary hits";
        psc: u32 = PRIORITY, "of the shadow counts of primary hits";
        pte: u32 = PRIORITY, "of the textures of primary hits";
        soid: u32 = PRIORITY, "of the objects of secondary hits";
        ssn: u32 = PRIORITY, "of the normals of secondary hits";
        ssc: u32 = PRIORITY, "of the shadow counts of secondary hits";
        ste: u32 = PRIORITY, "of the textures of secondary hits";
    }

    /// The thresholds of [`Jin2009`]; objects and shadow counts must be equal.
    #[serde(deny_unknown_fields)]
    pub struct Thresholds {
        colour: f64 = Number(2.0), "largest difference of the colours as displayed";
        normal_deg: f64 = Number(180.0), "largest angle between the shading normals", "degrees";
        /// It stands for a texture's presence, which traces do not hold.
        texture: f64 = Number(2.0), "largest difference of the hits' local colours as displayed";
    }
}
