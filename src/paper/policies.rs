//! What is compared: the two modes, and the policies of each.

use anyhow::Result;
use rayreel_replay::NamedPolicy;

/// A way to use the sample grid.
#[derive(Debug)]
pub struct Mode {
    /// Name in results.
    pub name: &'static str,
    /// The paper's word for adaptive sampling on it.
    pub word: &'static str,
    /// Samples per pixel and axis.
    pub samples: u32,
}

/// The paper's two.
pub const MODES: [Mode; 2] =
    [Mode { name: "2x2", word: "supersampling", samples: 2 }, Mode { name: "1x1", word: "undersampling", samples: 1 }];

/// A preset and where it is used.
pub struct Entry {
    /// Name of the preset.
    pub name: &'static str,
    /// In which of [`MODES`].
    pub modes: [bool; 2],
    /// Whether the report shows its pictures.
    pub shown: bool,
    /// Whether the animation is replayed under it.
    pub animated: bool,
    /// Whether its maps are shown over the frames.
    pub mapped: bool,
}

const fn entry(name: &'static str, modes: [bool; 2], shown: bool, animated: bool, mapped: bool) -> Entry {
    Entry { name, modes, shown, animated, mapped }
}

/// All policies, `full` first: it is what the others are compared with. `paper-ss` and `paper-us` are what the paper evaluated in
/// either mode.
pub const POLICIES: &[Entry] = &[
    entry("full", [true, true], false, true, false),
    entry("paper-ss", [true, false], true, true, true),
    entry("paper-us", [false, true], true, false, false),
    entry("quality", [true, true], false, true, false),
    entry("multirate", [true, true], true, true, true),
    entry("aggressive", [true, true], true, true, false),
    entry("foveated", [true, true], false, false, false),
];

/// Name of what the paper evaluated, by mode.
pub const PAPER: [&str; 2] = ["paper-ss", "paper-us"];

/// The presets, loaded, in the order of [`POLICIES`].
///
/// # Errors
/// Never for presets that exist.
pub fn load() -> Result<Vec<(&'static Entry, NamedPolicy)>> {
    POLICIES.iter().map(|entry| Ok((entry, NamedPolicy::load(entry.name, &[])?))).collect()
}
