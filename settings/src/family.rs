//! A family of settings: what machines have in common, or policies.

use crate::error::{Result, SettingsError};
use crate::near::near;
use crate::schema::Schema;

/// A preset: name and TOML text.
pub type Preset = (&'static str, &'static str);

/// What can be loaded by one name: its keys, its presets, and the words of its messages.
#[derive(Debug)]
pub struct Family {
    /// What it describes: "machine".
    pub what: &'static str,
    /// What a text of it is: "a valid machine".
    pub expected: &'static str,
    /// An override, for messages.
    pub example: &'static str,
    /// A preset worth extending, for messages.
    pub base: &'static str,
    /// The presets.
    pub presets: &'static [Preset],
    /// Kinds that have keys of their own; none if all have the same. A kind is the value of the key `kind`, and there is a preset
    /// of its name, which has all its keys: a file that extends nothing extends that.
    pub kinds: &'static [&'static str],
    /// The keys of a kind; of everything if there are no kinds.
    pub schema: fn(&str) -> &'static Schema,
}

impl Family {
    /// Text of a preset.
    pub(crate) fn preset(&self, name: &str) -> Option<Preset> {
        self.presets.iter().copied().find(|(known, _)| *known == name)
    }

    /// The error of a name that is neither.
    pub(crate) fn unknown_preset(&self, name: &str, by: Option<&str>) -> SettingsError {
        let names: Vec<_> = self.presets.iter().map(|(name, _)| *name).collect();
        let by = by.map(str::to_owned);
        SettingsError::UnknownPreset { by, what: self.what, name: name.into(), near: near(name, &names) }
    }

    /// The two sides of an override `key=value`.
    pub(crate) fn split<'a>(&self, text: &'a str) -> Result<(&'a str, &'a str)> {
        let parts = text.split_once('=').map(|(name, value)| (name.trim(), value.trim()));
        let parts = parts.filter(|(name, value)| !name.is_empty() && !value.is_empty());
        parts.ok_or_else(|| SettingsError::Override { text: text.into(), example: self.example })
    }
}

/// Whether `spec` is a path rather than the name of a preset.
pub fn is_path(spec: &str) -> bool {
    spec.ends_with(".toml") || spec.contains(['/', '\\'])
}
