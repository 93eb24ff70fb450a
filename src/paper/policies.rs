//! What is compared: the two modes, and the policies of each.

use std::sync::Arc;

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

/// How much is done with a policy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Nothing.
    Never,
    /// With `--full` only.
    Full,
    /// Always.
    Always,
}

impl When {
    /// Whether it is done in this run.
    pub fn now(self, full: bool) -> bool {
        self == Self::Always || (self == Self::Full && full)
    }
}

/// A policy and where it is used.
#[derive(Debug)]
pub struct Entry {
    /// Name in results.
    pub name: &'static str,
    /// Preset, and what is changed in it.
    pub preset: (&'static str, &'static [&'static str]),
    /// Whether there are points, by [`MODES`].
    pub modes: [When; 2],
    /// Whether the points are simulated on the whole GPU too, beside the T&I units alone.
    pub whole: bool,
    /// Whether the report shows its pictures.
    pub shown: When,
    /// Whether the animation is replayed under it, if it fits the animation's mode.
    pub animated: When,
    /// Whether frames of the animation are simulated and its maps shown.
    pub mapped: bool,
}

/// A preset with points in both modes.
const fn preset(name: &'static str) -> Entry {
    Entry {
        name,
        preset: (name, &[]),
        modes: [When::Always; 2],
        whole: false,
        shown: When::Never,
        animated: When::Never,
        mapped: false,
    }
}

/// What the paper evaluated in one of the modes.
const fn evaluated(name: &'static str, mode: usize) -> Entry {
    let mut entry = Entry { whole: true, shown: When::Always, animated: When::Always, mapped: true, ..preset(name) };
    entry.modes[1 - mode] = When::Never;
    entry
}

/// A change of `multirate` that only the animation shows.
const fn changed(name: &'static str, rules: &'static [&'static str], animated: When) -> Entry {
    let preset = ("multirate", rules);
    Entry { name, preset, modes: [When::Never; 2], whole: false, shown: When::Never, animated, mapped: false }
}

/// All policies, `full` first: it is what the others are compared with.
pub const POLICIES: &[Entry] = &[
    Entry { whole: true, animated: When::Always, ..preset("full") },
    evaluated("paper-ss", 0),
    evaluated("paper-us", 1),
    Entry { shown: When::Full, ..preset("quality") },
    Entry { whole: true, shown: When::Always, animated: When::Always, mapped: true, ..preset("multirate") },
    Entry { shown: When::Full, ..preset("aggressive") },
    Entry { modes: [When::Always, When::Never], ..preset("foveated") },
    changed("multirate, no hysteresis", &["raise=0.6", "lower=0.6", "alternate=0", "hold=1"], When::Always),
    changed("fixed 2x2", &["finest=2", "start=2", "coarsest=2"], When::Full),
    changed("fixed 4x4", &["finest=4", "start=4", "coarsest=4"], When::Always),
    changed("fixed 8x8", &["finest=8", "start=8", "coarsest=8"], When::Full),
];

/// Name of what the paper evaluated, by mode.
pub const PAPER: [&str; 2] = ["paper-ss", "paper-us"];

impl Entry {
    /// Whether the animation is replayed under it in mode `mode`: of the paper's two policies each has its own.
    pub fn is_animated(&self, mode: usize, full: bool) -> bool {
        self.animated.now(full) && (self.name == PAPER[mode] || !PAPER.contains(&self.name))
    }
}

/// All policies of [`POLICIES`], loaded.
///
/// # Errors
/// Never for presets that exist and keys that they have.
pub fn load() -> Result<Vec<(&'static Entry, Arc<NamedPolicy>)>> {
    let load = |entry: &'static Entry| {
        let (preset, rules) = entry.preset;
        let rules: Vec<String> = rules.iter().map(|rule| (*rule).to_owned()).collect();
        let policy = NamedPolicy::load(preset, &rules)?.policy;
        Ok((entry, Arc::new(NamedPolicy { name: entry.name.into(), policy })))
    };
    POLICIES.iter().map(load).collect()
}
