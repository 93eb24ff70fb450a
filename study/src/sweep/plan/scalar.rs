//! A value of an axis as constraints and results see it.

use serde::{Deserialize, Serialize};
use toml::Value;

use rayreel_machine::config::units::Bytes;

/// A number, a word or a flag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Scalar {
    /// True or false.
    Flag(bool),
    /// A whole number; a size in bytes.
    Integer(i64),
    /// Any other number.
    Float(f64),
    /// A word.
    Word(String),
}

impl Scalar {
    /// The value as a plan writes it: a size is its bytes. None for lists, tables, dates, and what is not finite.
    pub fn of(value: &Value) -> Option<Self> {
        Some(match value {
            Value::Boolean(flag) => Self::Flag(*flag),
            Value::Integer(i) => Self::Integer(*i),
            Value::Float(f) if f.is_finite() => Self::Float(*f),
            Value::String(word) => match Bytes::parse(word).and_then(|b| i64::try_from(b.0).ok()) {
                Some(bytes) => Self::Integer(bytes),
                None => Self::Word(word.clone()),
            },
            _ => return None,
        })
    }

    /// Whether both are the same number, however it is written, or the same word or flag.
    pub fn equals(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Integer(integer), Self::Float(float)) | (Self::Float(float), Self::Integer(integer)) => {
                *integer as f64 == *float
            }
            _ => self == other,
        }
    }
}
