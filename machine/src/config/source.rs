//! Where a value comes from: no number of a machine stands without it.

use std::fmt;

use serde::{Deserialize, Serialize};
use toml::Value;

/// How far a value can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Stated by the paper that is modelled (Lee et al. 2016).
    Paper,
    /// Read in another public source.
    Source,
    /// Recalled from a publication that could not be read again.
    Memory,
    /// Estimated, with the derivation given.
    Estimate,
    /// Computed from cited sources.
    Computed,
    /// A modelling choice of ours, not a fact about hardware.
    Choice,
    /// Set by the user, on the command line or in a file that gives no source.
    Override,
}

impl Class {
    /// All classes.
    pub const ALL: [Self; 7] =
        [Self::Paper, Self::Source, Self::Memory, Self::Estimate, Self::Computed, Self::Choice, Self::Override];

    /// The name, as presets write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Source => "source",
            Self::Memory => "memory",
            Self::Estimate => "estimate",
            Self::Computed => "computed",
            Self::Choice => "choice",
            Self::Override => "override",
        }
    }

    /// The class of this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A value of a machine with all that is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sourced {
    /// Name with dots.
    pub key: &'static str,
    /// Value: sizes in bytes, energies in pJ.
    pub value: Value,
    /// How far it can be trusted.
    pub class: Class,
    /// The document it is from, or how it was derived.
    pub source: String,
    /// The preset or file that set it; `override` for the command line.
    pub from: String,
}
