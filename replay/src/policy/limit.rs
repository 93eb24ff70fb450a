//! Thresholds that can be off.

use serde::{Deserialize, Serialize};

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
