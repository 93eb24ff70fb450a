//! Quantities with units, as presets write them.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A size in bytes; text may say `16KiB` or `4MiB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bytes(pub u64);

impl Bytes {
    /// Reads `"512"`, `"16KiB"`, `"4MiB"`.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let split = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let (digits, unit) = text.split_at(split);
        let factor = match unit.trim() {
            "" | "B" => 1,
            "KiB" => 1 << 10,
            "MiB" => 1 << 20,
            _ => return None,
        };
        digits.parse::<u64>().ok()?.checked_mul(factor).map(Self)
    }
}

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            b if b > 0 && b.is_multiple_of(1 << 20) => write!(f, "{}MiB", b >> 20),
            b if b > 0 && b.is_multiple_of(1 << 10) => write!(f, "{}KiB", b >> 10),
            b => write!(f, "{b}B"),
        }
    }
}

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_u64(self.0)
    }
}

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Form {
            Number(u64),
            Text(String),
        }
        match Form::deserialize(d)? {
            Form::Number(n) => Ok(Self(n)),
            Form::Text(text) => Self::parse(&text)
                .ok_or_else(|| serde::de::Error::custom(format!("{text:?} is not a size such as 16KiB"))),
        }
    }
}

/// An energy, kept in whole femtojoules so that sums are exact; presets write picojoules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Picojoules {
    /// Femtojoules.
    pub femtojoules: u64,
}

impl Serialize for Picojoules {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_f64(self.femtojoules as f64 / 1000.0)
    }
}

impl<'de> Deserialize<'de> for Picojoules {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Form {
            Whole(u64),
            Real(f64),
        }
        let pj = match Form::deserialize(d)? {
            Form::Whole(n) => n as f64,
            Form::Real(v) => v,
        };
        if !(0.0..=1.0e9).contains(&pj) {
            return Err(serde::de::Error::custom(format!("{pj} pJ is not an energy from 0 to 1e9 pJ")));
        }
        Ok(Self { femtojoules: (pj * 1000.0).round() as u64 })
    }
}
