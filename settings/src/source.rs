//! Where a value comes from: no number of a machine stands without it.

use std::fmt;

use toml::Value;

crate::words! {
    /// How far a value can be trusted.
    #[derive(PartialOrd, Ord)]
    pub enum Class {
        /// Stated by the paper that is modelled (Lee et al. 2016).
        Paper = "paper",
        /// Read in another public source.
        Source = "source",
        /// Recalled from a publication that could not be read again.
        Memory = "memory",
        /// Estimated, with the derivation given.
        Estimate = "estimate",
        /// Computed from cited sources.
        Computed = "computed",
        /// A modelling choice of ours, not a fact about hardware.
        Choice = "choice",
        /// Set by the user, on the command line or in a file that gives no source.
        Override = "override",
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A value with all that is known about it.
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
