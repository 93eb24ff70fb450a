//! What values a key takes.

use toml::Value;

use crate::units::Bytes;

/// What values a key takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// One of these words.
    Word(&'static [&'static str]),
    /// One of these integers.
    OneOf(&'static [i64]),
    /// A whole number from the first to the second.
    Integer(i64, i64),
    /// The same, for a setting that counts something; messages speak of an integer.
    Count(i64, i64),
    /// A size in bytes from the first to the second; text may say `16KiB`.
    Size(u64, u64),
    /// True or false.
    Flag,
    /// Picojoules from 0 to this, kept to the femtojoule; what would be kept as 0 must be 0.
    Energy(u32),
    /// A number from 0 to this.
    Number(f64),
    /// A number from 0 to this, or `"off"`.
    Limit(f64),
}

impl Rule {
    /// The value as it is kept (sizes in bytes, energies as pJ of whole femtojoules), if it is allowed.
    pub fn accept(&self, value: &Value) -> Option<Value> {
        let keep = |allowed: bool| allowed.then(|| value.clone());
        match self {
            Self::Word(words) => keep(value.as_str().is_some_and(|word| words.contains(&word))),
            Self::OneOf(allowed) => keep(value.as_integer().is_some_and(|i| allowed.contains(&i))),
            Self::Integer(low, high) | Self::Count(low, high) => {
                keep(value.as_integer().is_some_and(|i| (*low..=*high).contains(&i)))
            }
            Self::Size(low, high) => size(value, *low, *high),
            Self::Flag => keep(value.is_bool()),
            Self::Energy(max) => {
                let pj = number(value).filter(|pj| (0.0..=f64::from(*max)).contains(pj))?;
                let kept = (pj * 1000.0).round() / 1000.0;
                // An event that was given an energy must not turn into a free one.
                (kept > 0.0 || pj == 0.0).then_some(Value::Float(kept))
            }
            Self::Number(max) => keep(number(value).is_some_and(|v| (0.0..=*max).contains(&v))),
            Self::Limit(max) => {
                keep(value.as_str() == Some("off") || number(value).is_some_and(|v| (0.0..=*max).contains(&v)))
            }
        }
    }

    /// The allowed values, for people.
    pub fn describe(&self) -> String {
        match self {
            Self::Word(words) => words.iter().map(|w| format!("{w:?}")).collect::<Vec<_>>().join(" or "),
            Self::OneOf(allowed) => allowed.iter().map(ToString::to_string).collect::<Vec<_>>().join(" or "),
            Self::Integer(low, high) => format!("a whole number from {low} to {high}"),
            Self::Count(low, high) => format!("an integer from {low} to {high}"),
            Self::Size(low, high) => format!("a size from {} to {}, such as 16KiB", Bytes(*low), Bytes(*high)),
            Self::Flag => "true or false".into(),
            Self::Energy(max) => format!("a number of picojoules from 0 to {max} in steps of 0.001 pJ"),
            Self::Number(max) => format!("a number from 0 to {max}"),
            Self::Limit(max) => format!("a number from 0 to {max}, or \"off\""),
        }
    }

    /// An accepted value, for people and for a TOML file.
    pub fn show(&self, value: &Value) -> String {
        match (self, value) {
            (Self::Size(..), Value::Integer(bytes)) => format!("\"{}\"", Bytes(*bytes as u64)),
            _ => value.to_string(),
        }
    }
}

/// A whole or real number.
pub(crate) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(i) => Some(*i as f64),
        Value::Float(f) => Some(*f),
        _ => None,
    }
}

fn size(value: &Value, low: u64, high: u64) -> Option<Value> {
    let bytes = match value {
        Value::Integer(i) => u64::try_from(*i).ok()?,
        Value::String(text) => Bytes::parse(text)?.0,
        _ => return None,
    };
    (low..=high).contains(&bytes).then_some(())?;
    i64::try_from(bytes).ok().map(Value::Integer)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn accept(rule: Rule, text: &str) -> Option<String> {
        rule.accept(&text.parse().unwrap()).map(|value| value.to_string())
    }

    #[test]
    fn limits_are_inclusive() {
        for rule in [Rule::Integer(2, 9), Rule::Count(2, 9), Rule::Size(2, 9)] {
            let taken: Vec<_> = (0..12).filter(|i| rule.accept(&Value::Integer(*i)).is_some()).collect();
            assert_eq!(taken, (2..=9).collect::<Vec<_>>(), "{rule:?}");
        }
        for rule in [Rule::Number(2.0), Rule::Limit(2.0), Rule::Energy(2)] {
            assert!(accept(rule, "0").is_some() && accept(rule, "2.0").is_some(), "{rule:?}");
            assert!(accept(rule, "-0.1").is_none() && accept(rule, "2.1").is_none(), "{rule:?}");
            assert!(accept(rule, "nan").is_none() && accept(rule, "true").is_none(), "{rule:?}");
        }
    }

    #[test]
    fn values_are_kept_in_one_form() {
        assert_eq!(accept(Rule::Size(1, 1 << 20), "\"16KiB\"").unwrap(), "16384");
        assert_eq!(accept(Rule::Energy(100), "1.23456").unwrap(), "1.235");
        assert_eq!(accept(Rule::Energy(100), "7").unwrap(), "7.0");
        assert_eq!(accept(Rule::Energy(100), "0.0005").unwrap(), "0.001");
        assert_eq!(accept(Rule::Energy(100), "0.0004"), None, "half a step is not free");
        assert_eq!(accept(Rule::Energy(100), "0.0").unwrap(), "0.0");
        assert_eq!(accept(Rule::OneOf(&[2, 4]), "4").unwrap(), "4");
        assert_eq!(accept(Rule::OneOf(&[2, 4]), "3"), None);
        assert_eq!(accept(Rule::Limit(1.0), "\"off\"").unwrap(), "\"off\"");
        assert_eq!(accept(Rule::Number(1.0), "\"off\""), None);
        assert_eq!(Rule::Size(1, 1 << 20).show(&Value::Integer(16_384)), "\"16KiB\"");
    }
}
