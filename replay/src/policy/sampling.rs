//! What all policies with blocks have: the settings of a block, whatever its size.

use rayreel_settings::Rule::{Count, Flag, Limit as LimitUpTo, Number};
use rayreel_settings::{settings, words};

use super::limit::Limit;

words! {
    /// What happens between two dissimilar samples.
    pub enum Refine {
        /// All samples between are traced.
        Direct = "direct",
        /// The middle one is traced, and both halves are tested again.
        Hierarchical = "hierarchical",
    }

    /// What a test of two samples looks at first. It decides nothing, but says how much has to be looked at.
    pub enum First {
        /// Their primary hits; the colours of hits that are alike.
        Hits = "hits",
        /// Their colours; the hits where colours alone do not decide.
        Colours = "colours",
    }

    /// Where the colour of an interpolated sample comes from.
    pub enum Shade {
        /// It is interpolated.
        Colour = "colour",
        /// It is computed from the interpolated attributes: [`super::shade`] has the rule.
        Attributes = "attributes",
    }

    /// When the attributes of an interpolated hit are made: object, normal, shadow bits and what else tests read.
    pub enum Attributes {
        /// With the sample, if a later step may read them.
        Eager = "eager",
        /// When a test first reads them.
        Lazy = "lazy",
    }

    /// Who pays for the closing row and column of a tile: the samples of the next tiles that its tests read.
    pub enum Apron {
        /// They are traced once, by the tile that owns them, and shared.
        Share = "share",
        /// Each tile traces what it needs of them again. The picture is the same; the rays count as apron rays.
        Retrace = "retrace",
    }
}

settings! {
    /// What all policies but `full` do with the samples of a block, whatever its size. A key that does not exist is refused before
    /// this is read.
    pub struct Sampling {
        refine: Refine = Refine::RULE, "between dissimilar samples: trace all, or halve the gap";
        secondary: bool = Flag, "each hit of a ray tree is interpolated or traced by itself";
        /// Else such a primary hit is traced with its children. [`super::reuse`] says what a stand-in means for a replay.
        stand_in: bool = Flag,
            "with secondary: children of interpolated primary hits are traced from recorded stand-ins";
        /// Attributes are for whole samples: not with `secondary`.
        shade: Shade = Shade::RULE, "interpolated samples: colours are interpolated, or shaded from attributes";
        /// It changes no picture, only what the SRP computes and the tile buffer holds.
        attributes: Attributes = Attributes::RULE, "attributes of interpolated hits: made with the sample, or when a test reads them";
        /// Above 0 if that is used: a trace does not hold it.
        shade_ambient: f64 = Number(10.0), "with shade = attributes: ambient light, beside the lights of the trace";
        similarity: Similarity, "when two samples are similar";
        correct: Correct, "what is traced after all";
    }

    /// When two samples are similar: every test that is on must pass.
    #[serde(deny_unknown_fields)]
    pub struct Similarity {
        object_id: bool = Flag, "the objects must be the same";
        normal_deg: Limit = LimitUpTo(180.0), "largest angle between the shading normals", "degrees";
        shadow: bool = Flag, "the shadow rays must have found the same";
        position: Limit = LimitUpTo(1.0), "largest distance of the hit points", "fraction of the shorter ray";
        plane: Limit = LimitUpTo(1.0), "largest distance from the first tangent plane", "fraction of the shorter ray";
        /// The lean of a normal is its part along the line between both hits. Where a surface bends one way, both lean apart or
        /// together; the same way they lean on an S-bend and over a step.
        convexity: Limit = LimitUpTo(1.0), "largest lean of both normals to the same side", "fraction of the distance";
        /// Where object, normal and shadows agree, texture is what is left to differ.
        texture: Limit = LimitUpTo(2.0), "largest difference of the hits' local colours as displayed";
        /// [`super::similarity::Tests::colour_limit`] has the rule for other gaps and numbers of rays.
        colour: Limit = LimitUpTo(2.0), "largest difference of the colours as displayed, gap of 2, 3 rays a sample";
        /// A traced middle sample that was predicted within the colour limit passes the colour test for both its halves.
        predict: bool = Flag, "halves of a well predicted gap pass the colour test";
        secondary: bool = Flag, "the tests are made on secondary hits too";
        unlike: Limit = LimitUpTo(1.0), "secondary hits may be unlike below this fraction of the colour limit";
        /// A hit and a miss are never similar.
        unlike_primary: Limit = LimitUpTo(1.0), "primary hits, and what lies below, may be unlike below this fraction of the colour limit";
        first: First = First::RULE, "what a test looks at first: hits or colours";
    }

    /// Which interpolated samples are traced after all (after Kim et al. 2016).
    #[serde(deny_unknown_fields)]
    pub struct Correct {
        passes: u32 = Count(0, 64), "most passes of post-correction; 0 is off";
        /// Off: attributes that contradict always count. [`super::similarity::costs`] has the rule of `weighed`.
        colour: Limit = LimitUpTo(2.0), "contradictions count where the colours as displayed differ by more";
        colour_alone: Limit = LimitUpTo(2.0), "beyond this difference of colours nothing else need contradict";
        weighed: bool = Flag, "both limits grow with the rays of a sample: they are for three";
    }
}

impl Similarity {
    /// No test: all hits are alike.
    pub const NONE: Self = Self {
        object_id: false,
        normal_deg: Limit::Off,
        shadow: false,
        position: Limit::Off,
        plane: Limit::Off,
        convexity: Limit::Off,
        texture: Limit::Off,
        colour: Limit::Off,
        predict: false,
        secondary: false,
        unlike: Limit::Off,
        unlike_primary: Limit::Off,
        first: First::Hits,
    };
}

impl Sampling {
    /// No test, no correction; whole samples.
    pub const NONE: Self = Self {
        refine: Refine::Direct,
        secondary: false,
        stand_in: false,
        shade: Shade::Colour,
        attributes: Attributes::Eager,
        shade_ambient: 0.0,
        similarity: Similarity::NONE,
        correct: Correct { passes: 0, colour: Limit::Off, colour_alone: Limit::Off, weighed: false },
    };
}
