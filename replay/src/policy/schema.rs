//! The tables of keys of the policies, one for each kind, and the presets. Files, presets and overrides are all checked against
//! them, so a wrong key or value is named before anything runs.

use std::sync::LazyLock;

use rayreel_settings::{Entry, Family, Key, Preset, Result, Rule, Schema, Settings, SettingsError};
use toml::Value;

use super::kinds::{Adaptive, Foveated, Jin2009, Mitchell1987, Multirate, Temporal, Whitted1980};
use super::sampling::Shade;

macro_rules! presets {
    ($($name:literal)*) => { &[$(($name, include_str!(concat!("../presets/", $name, ".toml"))),)*] };
}

/// The compiled-in presets: name and TOML text.
pub const PRESETS: &[Preset] = presets! {
    "full" "adaptive" "adaptive-4" "adaptive-8" "paper-ss" "paper-us" "multirate" "quality" "aggressive" "temporal" "foveated"
    "whitted1980" "mitchell1987" "jin2009" "kim2016"
};

/// Kinds of policies.
pub const KINDS: &[&str] =
    &["full", "adaptive", "multirate", "temporal", "foveated", "whitted1980", "mitchell1987", "jin2009"];

const KIND: Entry = Entry::Key(Key { name: "kind", rule: Rule::Word(KINDS), unit: "", meaning: "kind of the policy" });

static SCHEMAS: LazyLock<Vec<Schema>> = LazyLock::new(|| {
    let entries = |kind: &str| match kind {
        "adaptive" => Adaptive::ENTRIES,
        "multirate" => Multirate::ENTRIES,
        "temporal" => Temporal::ENTRIES,
        "foveated" => Foveated::ENTRIES,
        "whitted1980" => Whitted1980::ENTRIES,
        "mitchell1987" => Mitchell1987::ENTRIES,
        "jin2009" => Jin2009::ENTRIES,
        _ => &[],
    };
    let schema = |kind: &&str| Schema::new(format!("a policy of kind {kind:?}"), &[&[KIND], entries(kind)].concat());
    KINDS.iter().map(schema).collect()
});

/// What all policies have in common.
pub static POLICIES: Family = Family {
    what: "policy",
    expected: "valid TOML",
    example: "similarity.normal_deg=12",
    base: "full",
    presets: PRESETS,
    kinds: KINDS,
    schema: |kind| &SCHEMAS[KINDS.iter().position(|known| *known == kind).unwrap_or(0)],
};

/// The keys of a kind of policy; `None` if there is no such kind.
pub fn keys(kind: &str) -> Option<&'static [Key]> {
    KINDS.contains(&kind).then(|| (POLICIES.schema)(kind).keys())
}

/// Least ambient light of `shade = "attributes"`: colours are divided by it where no light is seen, and stay numbers.
const AMBIENT_MIN: f64 = 1e-6;

/// Checks what one key alone cannot show: that ranges are not empty, and that values go together. `get` knows the values;
/// `origin` says where they are from, and `set` what set a single one, if something did.
///
/// # Errors
/// [`SettingsError::BadValue`].
pub(super) fn check_order<'a>(
    get: impl Fn(&str) -> Option<&'a Value>,
    origin: &str,
    set: impl Fn(&str) -> Option<String>,
) -> Result<()> {
    let number = |name: &str| match get(name)? {
        Value::Integer(i) => Some(*i as f64),
        value => value.as_float(),
    };
    // The first key is at fault; what set one of the two by itself is where that is from.
    let bad = |keys: [&str; 2], allowed: String| {
        let said = keys.iter().find_map(|key| set(key)).unwrap_or_else(|| origin.to_owned());
        get(keys[0]).map_or(Ok(()), |value| Err(SettingsError::bad_value(&said, keys[0], value, allowed)))
    };
    let ordered =
        [("finest", "coarsest"), ("finest", "start"), ("start", "coarsest"), ("raise", "lower"), ("inner", "outer")];
    for (small, large) in ordered {
        if let (Some(low), Some(high)) = (number(small), number(large))
            && low > high
        {
            if set(small).is_none() && set(large).is_some() {
                bad([large, small], format!("a value not below that of {small}, which is {low}"))?;
            }
            bad([small, large], format!("a value up to that of {large}, which is {high}"))?;
        }
    }
    if get("shade").and_then(Value::as_str) != Some(Shade::Attributes.name()) {
        return Ok(());
    }
    if number("shade_ambient").is_some_and(|ambient| ambient < AMBIENT_MIN) {
        bad(["shade_ambient", "shade"], format!("{AMBIENT_MIN} or more with shade = \"attributes\""))?;
    }
    if get("secondary").and_then(Value::as_bool) == Some(true) {
        bad(["secondary", "shade"], "false with shade = \"attributes\", which shades whole samples".into())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use rayreel_settings::near;

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
