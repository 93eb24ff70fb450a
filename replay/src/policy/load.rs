//! Policies by preset name or file, with overrides.

use std::path::Path;

use serde::Deserialize;
use toml::{Table, Value};

use super::{Policy, schema};
use crate::error::{ReplayError, Result};

/// The compiled-in presets: name and TOML text.
pub const PRESETS: &[(&str, &str)] = &[
    ("full", include_str!("../presets/full.toml")),
    ("adaptive", include_str!("../presets/adaptive.toml")),
    ("adaptive-4", include_str!("../presets/adaptive-4.toml")),
    ("adaptive-8", include_str!("../presets/adaptive-8.toml")),
    ("paper-ss", include_str!("../presets/paper-ss.toml")),
    ("paper-us", include_str!("../presets/paper-us.toml")),
    ("multirate", include_str!("../presets/multirate.toml")),
    ("quality", include_str!("../presets/quality.toml")),
    ("aggressive", include_str!("../presets/aggressive.toml")),
    ("foveated", include_str!("../presets/foveated.toml")),
];

/// A policy and what results call it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPolicy {
    /// Preset or file stem, then `+key=value` per override.
    pub name: String,
    /// The policy.
    pub policy: Policy,
}

impl NamedPolicy {
    /// The policy of a preset, or of a TOML file if `spec` ends in `.toml` or contains a path separator, with each of
    /// `overrides` (`key=value`, dotted key, TOML value; words need no quotes) applied in order. What a file leaves out is
    /// taken from the preset named like its kind.
    ///
    /// # Errors
    /// An unknown preset, an unreadable file, a key that does not exist, a value out of range.
    pub fn load(spec: &str, overrides: &[String]) -> Result<Self> {
        let (name, origin, text) = read(spec)?;
        Self::build(name, &origin, &text, overrides)
    }

    /// The policy that [`NamedPolicy::to_toml`] wrote, or any other text of a policy file, with overrides as in
    /// [`NamedPolicy::load`].
    ///
    /// # Errors
    /// As there.
    pub fn parse(name: &str, text: &str, overrides: &[String]) -> Result<Self> {
        Self::build(name.into(), &format!("policy {name}"), text, overrides)
    }

    fn build(mut name: String, origin: &str, text: &str, overrides: &[String]) -> Result<Self> {
        let mut table: Table = parse(text, origin)?;
        schema::check(&table, origin)?;
        for text in overrides {
            apply(&mut table, text)?;
            name = format!("{name}+{text}");
        }
        Ok(Self { name, policy: resolve(table, origin)? })
    }

    /// A policy file that gives this policy whatever the presets become.
    ///
    /// # Errors
    /// Never for a policy that was loaded.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string(&self.policy).map_err(|e| ReplayError::Usage { detail: e.to_string() })
    }
}

impl Policy {
    /// Checks a policy that was made by code rather than loaded.
    ///
    /// # Errors
    /// [`ReplayError::BadValue`] names key, value and the allowed range.
    pub fn check(&self) -> Result<()> {
        let table = Table::try_from(self).map_err(|e| ReplayError::Usage { detail: e.to_string() })?;
        schema::check(&table, "policy")
    }
}

/// Name, origin for messages, and text of a policy.
fn read(spec: &str) -> Result<(String, String, String)> {
    if let Some((name, text)) = PRESETS.iter().find(|(name, _)| *name == spec) {
        return Ok(((*name).into(), format!("preset {name}"), (*text).into()));
    }
    if !(spec.ends_with(".toml") || spec.contains(['/', '\\'])) {
        let names: Vec<_> = PRESETS.iter().map(|(name, _)| *name).collect();
        return Err(ReplayError::UnknownPreset { name: spec.into(), near: rayreel_settings::near(spec, &names) });
    }
    let path = Path::new(spec);
    let text =
        std::fs::read_to_string(path).map_err(|source| ReplayError::PolicyFile { path: path.to_path_buf(), source })?;
    let name = path.file_stem().map_or_else(|| spec.into(), |stem| stem.to_string_lossy().into_owned());
    Ok((name, spec.into(), text))
}

fn parse(text: &str, origin: &str) -> Result<Table> {
    text.parse().map_err(|e: toml::de::Error| ReplayError::PolicySyntax {
        origin: origin.into(),
        detail: e.to_string().trim_end().into(),
    })
}

/// Puts `key=value` into `table`. Changing the kind drops all other keys: they belong to the old kind.
fn apply(table: &mut Table, text: &str) -> Result<()> {
    let bad = || ReplayError::BadOverride { text: text.into() };
    let (key, value) = text.split_once('=').ok_or_else(bad)?;
    let (key, value) = (key.trim(), value.trim());
    if key.is_empty() || value.is_empty() {
        return Err(bad());
    }
    // A word that is not TOML by itself is taken as a string, so that `refine=hierarchical` needs no quotes in a shell.
    let value = value.parse::<Value>().unwrap_or_else(|_| Value::String(value.into()));
    let mut change = Table::new();
    if key == "kind" {
        change.insert(key.into(), value);
        schema::check(&change, &origin_of(text))?;
        if table.get("kind") != change.get("kind") {
            *table = change;
        }
        return Ok(());
    }
    let parent = match key.split_once('.') {
        Some((outer, inner)) => {
            change.insert(outer.into(), Value::Table(Table::from_iter([(inner.to_owned(), value)])));
            outer
        }
        None => {
            change.insert(key.into(), value);
            key
        }
    };
    // Checked by itself first, so that the message names the override and not the file.
    let mut checked = change.clone();
    checked.extend(table.get_key_value("kind").map(|(k, v)| (k.clone(), v.clone())));
    schema::check(&checked, &origin_of(text))?;
    match (table.get_mut(parent), change.remove(parent)) {
        (Some(Value::Table(old)), Some(Value::Table(new))) => old.extend(new),
        (_, Some(new)) => {
            table.insert(parent.into(), new);
        }
        _ => {}
    }
    Ok(())
}

fn origin_of(text: &str) -> String {
    format!("override {text:?}")
}

/// The policy of a checked table, completed from the preset of its kind.
fn resolve(table: Table, origin: &str) -> Result<Policy> {
    let kind = schema::kind_of(&table, origin)?;
    let base = PRESETS.iter().find(|(name, _)| *name == kind).map_or("", |(_, text)| text);
    let mut full = parse(base, kind)?;
    for (name, value) in table {
        match (full.get_mut(&name), value) {
            (Some(Value::Table(old)), Value::Table(new)) => old.extend(new),
            (_, value) => {
                full.insert(name, value);
            }
        }
    }
    schema::check(&full, origin)?;
    Policy::deserialize(full).map_err(|e| ReplayError::PolicySyntax { origin: origin.into(), detail: e.to_string() })
}
