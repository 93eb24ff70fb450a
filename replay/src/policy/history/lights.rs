//! What a history knows of a hit's lights, and how often that was right.

use rayreel_formats::math::Vec3;
use rayreel_formats::tile::Shadows;

/// What is known of a hit's lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownLights {
    /// Those that are known: the low bit of each.
    pub lights: u32,
    /// What the shadow rays to them would find; of other lights it says nothing.
    pub shadows: Shadows,
    /// The colour that the nearest entry had.
    pub local: Vec3,
}

/// Lights that were known and looked for all the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightChecks {
    /// How many.
    pub lights: u32,
    /// Those that shadow rays found otherwise.
    pub mistaken: u32,
}
