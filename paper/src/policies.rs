//! What is compared: the two modes, and the policies of each.

use std::sync::Arc;

use rayreel_replay::NamedPolicy;

use crate::error::Result;

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
pub struct Contender {
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
    /// Whether the paper's frames of the animation are simulated and its maps shown.
    pub mapped: bool,
    /// Whether the whole animation is simulated, or estimated from a sample of its frames, with `--full`.
    pub flown: bool,
}

/// A preset with points in both modes.
const fn preset(name: &'static str) -> Contender {
    Contender {
        name,
        preset: (name, &[]),
        modes: [When::Always; 2],
        whole: false,
        shown: When::Never,
        animated: When::Never,
        mapped: false,
        flown: false,
    }
}

/// What the paper evaluated in one of the modes.
const fn evaluated(name: &'static str, mode: usize) -> Contender {
    let mut contender = Contender {
        whole: true,
        shown: When::Always,
        animated: When::Always,
        mapped: true,
        flown: true,
        ..preset(name)
    };
    contender.modes[1 - mode] = When::Never;
    contender
}

/// A change of `multirate` that only the animation shows.
const fn changed(name: &'static str, rules: &'static [&'static str], animated: When) -> Contender {
    Contender { preset: ("multirate", rules), modes: [When::Never; 2], animated, ..preset(name) }
}

/// The same with one block for all tiles.
const fn fixed(name: &'static str, rules: &'static [&'static str], animated: When) -> Contender {
    Contender { flown: true, ..changed(name, rules, animated) }
}

/// All policies, `full` first: it is what the others are compared with.
pub const POLICIES: &[Contender] = &[
    Contender { whole: true, animated: When::Always, flown: true, ..preset("full") },
    evaluated("paper-ss", 0),
    evaluated("paper-us", 1),
    Contender { shown: When::Full, ..preset("quality") },
    Contender {
        whole: true,
        shown: When::Always,
        animated: When::Always,
        mapped: true,
        flown: true,
        ..preset("multirate")
    },
    Contender { shown: When::Full, ..preset("aggressive") },
    Contender { modes: [When::Always, When::Never], ..preset("foveated") },
    changed("multirate, no hysteresis", &["raise=2", "lower=2", "alternate=0"], When::Always),
    fixed("fixed 2x2", &["finest=2", "start=2", "coarsest=2"], When::Full),
    fixed("fixed 4x4", &["finest=4", "start=4", "coarsest=4"], When::Always),
    fixed("fixed 8x8", &["finest=8", "start=8", "coarsest=8"], When::Full),
];

/// Name of what the paper evaluated, by mode.
pub const PAPER: [&str; 2] = ["paper-ss", "paper-us"];

impl Contender {
    /// Whether the animation is replayed under it in mode `mode`: the paper evaluated one policy in each.
    pub fn is_animated(&self, mode: usize, full: bool) -> bool {
        self.animated.now(full) && (self.name == PAPER[mode] || !PAPER.contains(&self.name))
    }

    /// Whether a machine simulates frames of the animation under it.
    pub fn is_simulated(&self, full: bool) -> bool {
        if full { self.flown } else { self.mapped || self.name == "full" }
    }
}

/// All policies of [`POLICIES`], loaded.
///
/// # Errors
/// Never for presets that exist and keys that they have.
pub fn load() -> Result<Vec<(&'static Contender, Arc<NamedPolicy>)>> {
    let load = |contender: &'static Contender| {
        let (preset, rules) = contender.preset;
        let rules: Vec<String> = rules.iter().map(|rule| (*rule).to_owned()).collect();
        let policy = NamedPolicy::load(preset, &rules)?.policy;
        Ok((contender, Arc::new(NamedPolicy { name: contender.name.into(), policy })))
    };
    POLICIES.iter().map(load).collect()
}

/// What a mode is called.
pub fn word(mode: &str) -> &str {
    MODES.iter().find(|known| known.name == mode).map_or(mode, |known| known.word)
}
