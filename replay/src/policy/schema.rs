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

/// Checks what one key alone cannot show: that ranges are not empty, and that values go together. `get` knows the values.
///
/// # Errors
/// [`SettingsError::BadValue`].
pub(super) fn check_order<'a>(get: impl Fn(&str) -> Option<&'a Value>, origin: &str) -> Result<()> {
    let number = |name: &str| match get(name)? {
        Value::Integer(i) => Some(*i as f64),
        value => value.as_float(),
    };
    let ordered =
        [("finest", "coarsest"), ("finest", "start"), ("start", "coarsest"), ("raise", "lower"), ("inner", "outer")];
    for (small, large) in ordered {
        if let (Some(low), Some(high), Some(value)) = (number(small), number(large), get(small))
            && low > high
        {
            let allowed = format!("a value up to that of {large}, which is {high}");
            return Err(SettingsError::bad_value(origin, small, value, allowed));
        }
    }
    let is_shaded = get("shade").and_then(Value::as_str) == Some(Shade::Attributes.name());
    if let Some(ambient) = get("shade_ambient").filter(|_| is_shaded && number("shade_ambient") == Some(0.0)) {
        let allowed = "above 0 with shade = \"attributes\"";
        return Err(SettingsError::bad_value(origin, "shade_ambient", ambient, allowed));
    }
    if let Some(secondary) = get("secondary").filter(|on| is_shaded && on.as_bool() == Some(true)) {
        let allowed = "false with shade = \"attributes\", which shades whole samples";
        return Err(SettingsError::bad_value(origin, "secondary", secondary, allowed));
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
