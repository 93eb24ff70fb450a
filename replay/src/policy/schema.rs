//! The keys of a policy: which exist, what values they take, what they mean. Files, presets and overrides are all checked
//! against this one table, so a wrong key or value is named before anything runs.

use toml::{Table, Value};

use rayreel_settings::near;

use crate::error::{ReplayError, Result};

/// What values a key takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// One of these words.
    Word(&'static [&'static str]),
    /// One of these integers.
    Integer(&'static [i64]),
    /// True or false.
    Flag,
    /// An integer in this range, both ends included.
    Range(i64, i64),
    /// A number from 0 to this.
    Number(f64),
    /// A number from 0 to this, or "off".
    Limit(f64),
}

/// A key of a policy.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Name with dots.
    pub name: &'static str,
    /// Allowed values.
    pub rule: Rule,
    /// Meaning and unit.
    pub doc: &'static str,
}

const fn key(name: &'static str, rule: Rule, doc: &'static str) -> Key {
    Key { name, rule, doc }
}

/// Kinds of policies.
pub const KINDS: &[&str] = &["full", "adaptive", "multirate", "foveated"];

const KIND: Key = key("kind", Rule::Word(KINDS), "kind of the policy");

const FULL: &[Key] = &[KIND];

/// Block edges of tiles with blocks of their own: each divides the next.
const NESTED: Rule = Rule::Integer(&[2, 4, 8, 16]);

const ADAPTIVE: &[Key] = &[
    key("block", Rule::Integer(&[2, 3, 4, 8, 16]), "block edge in samples: one R-sample per block"),
    key("apron", Rule::Word(&["share", "retrace"]), "the far border of a tile: shared with its owner, or traced again"),
];

const MULTIRATE: &[Key] = &[
    key("start", NESTED, "block edge of a first frame and after a cut, samples"),
    key("finest", NESTED, "smallest block edge, samples"),
    key("coarsest", NESTED, "largest block edge, samples"),
    key("raise", Rule::Number(1.0), "a tile asks for a larger block at this similarity ratio or above"),
    key("lower", Rule::Number(1.0), "a tile asks for a smaller block at this similarity ratio or below"),
    key("alternate", Rule::Number(1.0), "in odd frames raise is this much higher and lower this much lower"),
    key("hold", Rule::Integer(&[1, 2, 3, 4, 5, 6, 7, 8]), "frames in a row that must ask for a change"),
    key("cut_deg", Rule::Number(180.0), "a camera that turns by more than this is a cut, degrees"),
    key("cut_change", Rule::Number(1.0), "a mean change of the similarity ratios above this is a cut"),
    key("target.psnr_db", Rule::Limit(99.0), "quality that the colour limit is moved to hold, dB"),
    key("target.audit", Rule::Range(1, 1 << 20), "one pixel in so many is traced whole to estimate the error"),
    key("target.strictest", Rule::Number(1.0), "smallest factor on the colour limit"),
    key("target.loosest", Rule::Number(100.0), "largest factor on the colour limit"),
    key("target.share", Rule::Number(1.0), "no factor below 1 where this share of the samples is traced"),
];

const FOVEATED: &[Key] = &[
    key("gaze_x", Rule::Number(1.0), "where the eye looks, fraction of the width"),
    key("gaze_y", Rule::Number(1.0), "where the eye looks, fraction of the height"),
    key("inner", Rule::Number(4.0), "up to here blocks are the smallest, fraction of the height"),
    key("outer", Rule::Number(4.0), "from here on blocks are the largest, fraction of the height"),
    key("finest", NESTED, "smallest block edge, samples"),
    key("coarsest", NESTED, "largest block edge, samples"),
    key("relax", Rule::Number(100.0), "factor on the colour limit from the outer radius on"),
];

/// The keys that all policies with blocks have.
const SAMPLING: &[Key] = &[
    KIND,
    key("refine", Rule::Word(&["direct", "hierarchical"]), "between dissimilar samples: trace all, or halve the gap"),
    key("secondary", Rule::Flag, "each hit of a ray tree is interpolated or traced by itself"),
    key(
        "stand_in",
        Rule::Flag,
        "with secondary: children of interpolated primary hits are traced from recorded stand-ins",
    ),
    key("similarity.object_id", Rule::Flag, "the objects must be the same"),
    key("similarity.normal_deg", Rule::Limit(180.0), "largest angle between the shading normals, degrees"),
    key("similarity.shadow", Rule::Flag, "the shadow rays must have found the same"),
    key("similarity.position", Rule::Limit(1.0), "largest distance of the hit points, fraction of the shorter ray"),
    key(
        "similarity.plane",
        Rule::Limit(1.0),
        "largest distance from the first tangent plane, fraction of the shorter ray",
    ),
    key("similarity.texture", Rule::Limit(2.0), "largest difference of the hits' local colours as displayed"),
    key(
        "similarity.colour",
        Rule::Limit(2.0),
        "largest difference of the colours as displayed, gap of 2, 3 rays a sample",
    ),
    key("similarity.predict", Rule::Flag, "halves of a well predicted gap pass the colour test"),
    key("similarity.secondary", Rule::Flag, "the tests are made on secondary hits too"),
    key("similarity.unlike", Rule::Limit(1.0), "secondary hits may be unlike below this fraction of the colour limit"),
    key("correct.passes", Rule::Range(0, 64), "most passes of post-correction; 0 is off"),
    key("correct.colour", Rule::Limit(2.0), "contradictions count where the colours as displayed differ by more"),
];

/// The keys of a kind of policy; `None` if there is no such kind.
pub fn keys(kind: &str) -> Option<Vec<Key>> {
    let own = match kind {
        "full" => return Some(FULL.to_vec()),
        "adaptive" => ADAPTIVE,
        "multirate" => MULTIRATE,
        "foveated" => FOVEATED,
        _ => return None,
    };
    Some([&SAMPLING[..1], own, &SAMPLING[1..]].concat())
}

impl Rule {
    /// True when `value` is allowed.
    pub fn allows(&self, value: &Value) -> bool {
        let number = match value {
            Value::Integer(i) => Some(*i as f64),
            Value::Float(f) => Some(*f),
            _ => None,
        };
        match self {
            Self::Word(words) => value.as_str().is_some_and(|word| words.contains(&word)),
            Self::Integer(allowed) => value.as_integer().is_some_and(|i| allowed.contains(&i)),
            Self::Flag => value.is_bool(),
            Self::Range(least, most) => value.as_integer().is_some_and(|i| (*least..=*most).contains(&i)),
            Self::Number(max) => number.is_some_and(|v| (0.0..=*max).contains(&v)),
            Self::Limit(max) => number.is_some_and(|v| (0.0..=*max).contains(&v)) || value.as_str() == Some("off"),
        }
    }

    /// The allowed values, for people.
    pub fn describe(&self) -> String {
        let or = |list: Vec<String>| list.join(" or ");
        match self {
            Self::Word(words) => or(words.iter().map(|w| format!("{w:?}")).collect()),
            Self::Integer(allowed) => or(allowed.iter().map(ToString::to_string).collect()),
            Self::Flag => "true or false".into(),
            Self::Range(least, most) => format!("an integer from {least} to {most}"),
            Self::Number(max) => format!("a number from 0 to {max}"),
            Self::Limit(max) => format!("a number from 0 to {max}, or \"off\""),
        }
    }
}

/// Checks every key and value of `table`; `origin` says where it is from.
///
/// # Errors
/// [`ReplayError::UnknownKey`] and [`ReplayError::BadValue`], the first in the order of the table.
pub fn check(table: &Table, origin: &str) -> Result<()> {
    let kind = kind_of(table, origin)?;
    let keys = keys(kind).unwrap_or_default();
    let mut flat = Vec::new();
    flatten(table, "", &mut flat);
    for (name, value) in flat {
        let Some(key) = keys.iter().find(|k| k.name == name) else {
            return Err(unknown_key(origin, &name, kind, value));
        };
        if !key.rule.allows(value) {
            return Err(bad_value(origin, &name, value, key.rule.describe()));
        }
    }
    check_order(table, origin)
}

/// Checks what one key alone cannot show: that ranges are not empty.
fn check_order(table: &Table, origin: &str) -> Result<()> {
    let number = |name: &str| match table.get(name) {
        Some(Value::Integer(i)) => Some(*i as f64),
        Some(Value::Float(f)) => Some(*f),
        _ => None,
    };
    let ordered =
        [("finest", "coarsest"), ("finest", "start"), ("start", "coarsest"), ("lower", "raise"), ("inner", "outer")];
    for (small, large) in ordered {
        if let (Some(low), Some(high)) = (number(small), number(large))
            && low > high
        {
            let value = table.get(small).cloned().unwrap_or(Value::Float(low));
            return Err(bad_value(origin, small, &value, format!("a value up to that of {large}, which is {high}")));
        }
    }
    Ok(())
}

/// The `kind` of a policy.
///
/// # Errors
/// [`ReplayError::BadValue`] if it is missing or unknown.
pub fn kind_of<'a>(table: &'a Table, origin: &str) -> Result<&'a str> {
    let rule = Rule::Word(KINDS);
    match table.get("kind") {
        Some(Value::String(kind)) if KINDS.contains(&kind.as_str()) => Ok(kind),
        Some(value) => Err(bad_value(origin, "kind", value, rule.describe())),
        None => Err(bad_value(origin, "kind", &Value::String("(missing)".into()), rule.describe())),
    }
}

fn bad_value(origin: &str, key: &str, value: &Value, allowed: String) -> ReplayError {
    ReplayError::BadValue { origin: origin.into(), key: key.into(), value: value.to_string(), allowed }
}

/// A scalar where a table of keys belongs (`similarity = 3`) is a bad value; all else is an unknown key.
fn unknown_key(origin: &str, name: &str, kind: &str, value: &Value) -> ReplayError {
    let keys = keys(kind).unwrap_or_default();
    let names: Vec<_> = keys.iter().map(|k| k.name).collect();
    let inside = format!("{name}.");
    let below: Vec<_> = names.iter().filter_map(|n| n.strip_prefix(inside.as_str())).collect();
    if !below.is_empty() {
        return bad_value(origin, name, value, format!("a table with {}", below.join(", ")));
    }
    ReplayError::UnknownKey { origin: origin.into(), key: name.into(), kind: kind.into(), near: near(name, &names) }
}

/// The leaves of a table under dotted names. An empty inner table has none.
fn flatten<'a>(table: &'a Table, prefix: &str, out: &mut Vec<(String, &'a Value)>) {
    for (name, value) in table {
        let name = format!("{prefix}{name}");
        match value {
            // Keys are two deep; anything deeper is reported under the name of its table.
            Value::Table(inner) if prefix.is_empty() => flatten(inner, &format!("{name}."), out),
            _ => out.push((name, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found_by_their_last_part() {
        let keys = keys("adaptive").unwrap();
        let names: Vec<_> = keys.iter().map(|k| k.name).collect();
        assert_eq!(near("normal_degs", &names), "did you mean similarity.normal_deg?");
        assert_eq!(near("blok", &names), "did you mean block?");
        assert!(near("antialiasing", &names).starts_with("there are kind, block"));
    }
}
