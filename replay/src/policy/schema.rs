//! The keys of a policy: which exist, what values they take, what they mean. Files, presets and overrides are all checked
//! against this one table, so a wrong key or value is named before anything runs.

use toml::{Table, Value};

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
pub const KINDS: &[&str] = &["full", "adaptive"];

const FULL: &[Key] = &[key("kind", Rule::Word(KINDS), "kind of the policy")];

const ADAPTIVE: &[Key] = &[
    key("kind", Rule::Word(KINDS), "kind of the policy"),
    key("block", Rule::Integer(&[2, 3, 4, 8]), "block edge in samples: one R-sample per block"),
    key("refine", Rule::Word(&["direct", "hierarchical"]), "between dissimilar samples: trace all, or halve the gap"),
    key("apron", Rule::Word(&["share", "retrace"]), "the far border of a tile: shared with its owner, or traced again"),
    key("similarity.object_id", Rule::Flag, "the objects must be the same"),
    key("similarity.normal_deg", Rule::Limit(180.0), "largest angle between the shading normals, degrees"),
    key("similarity.shadow", Rule::Flag, "the shadow rays must have found the same"),
    key("similarity.position", Rule::Limit(1.0), "largest distance of the hit points, fraction of the shorter ray"),
    key(
        "similarity.plane",
        Rule::Limit(1.0),
        "largest distance from the first tangent plane, fraction of the shorter ray",
    ),
];

/// The keys of a kind of policy; `None` if there is no such kind.
pub fn keys(kind: &str) -> Option<&'static [Key]> {
    match kind {
        "full" => Some(FULL),
        "adaptive" => Some(ADAPTIVE),
        _ => None,
    }
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
    let names: Vec<_> = keys(kind).unwrap_or_default().iter().map(|k| k.name).collect();
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

/// "did you mean .." with the names nearest to `name`, or all of them.
pub(crate) fn near(name: &str, names: &[&str]) -> String {
    let last = |s: &str| s.rsplit('.').next().unwrap_or_default().to_owned();
    let distance = |other: &str| edits(name, other).min(edits(&last(name), &last(other)));
    let best = names.iter().map(|n| distance(n)).min().unwrap_or(usize::MAX);
    // More than a third of the letters wrong is another word.
    if best <= last(name).chars().count() / 3 + 1 {
        let close: Vec<_> = names.iter().filter(|n| distance(n) == best).copied().collect();
        format!("did you mean {}?", close.join(" or "))
    } else {
        format!("there are {}", names.join(", "))
    }
}

/// Levenshtein distance.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let change = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("abc", "abc"), 0);
    }

    #[test]
    fn near_names_are_found_by_their_last_part() {
        let names: Vec<_> = ADAPTIVE.iter().map(|k| k.name).collect();
        assert_eq!(near("normal_degs", &names), "did you mean similarity.normal_deg?");
        assert_eq!(near("blok", &names), "did you mean block?");
        assert!(near("antialiasing", &names).starts_with("there are kind, block"));
    }
}
