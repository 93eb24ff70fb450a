//! Policies by preset name or file, with overrides.

use rayreel_settings::{Key, Loaded};
use toml::{Table, Value};

use super::kinds::Policy;
use super::schema::{self, POLICIES, check_order};
use crate::error::{ReplayError, Result};

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
    /// taken from what it extends, or else from the preset named like its kind.
    ///
    /// # Errors
    /// An unknown preset, an unreadable file, a circle of `extends`, a key that does not exist, a value out of range.
    pub fn load(spec: &str, overrides: &[String]) -> Result<Self> {
        Self::resolve(POLICIES.load(spec)?, overrides)
    }

    /// The policy that [`NamedPolicy::to_toml`] wrote, or any other text of a policy file, with overrides as in
    /// [`NamedPolicy::load`].
    ///
    /// # Errors
    /// As there.
    pub fn parse(name: &str, text: &str, overrides: &[String]) -> Result<Self> {
        Self::resolve(POLICIES.parse(name, text)?, overrides)
    }

    fn resolve(mut loaded: Loaded, overrides: &[String]) -> Result<Self> {
        let mut name = loaded.chain[0].name.clone();
        for text in overrides {
            loaded.set(text)?;
            name = format!("{name}+{text}");
        }
        check_order(|key| loaded.get(key), &loaded.origin, |key| loaded.overridden(key))?;
        Ok(Self { name, policy: loaded.build()? })
    }

    /// A policy file that gives this policy whatever the presets become.
    ///
    /// # Errors
    /// Never for a policy that was loaded.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string(&self.policy).map_err(|e| ReplayError::Usage { detail: e.to_string() })
    }

    /// The same for people: each value with its meaning.
    pub fn page(&self) -> String {
        let head = self.name.replace(char::is_control, " ");
        let line = |(key, value): (&Key, Value)| {
            let value = format!("{} = {value}", key.name);
            format!("{value:<40}  # {}\n", key.about())
        };
        format!("# {head}\n{}", self.policy.values().map(line).collect::<String>())
    }
}

impl Policy {
    /// Every value with its key, in the order of the structs.
    pub fn values(&self) -> impl Iterator<Item = (&'static Key, Value)> {
        // A policy is made of words and numbers: it has a form as TOML.
        let table = Value::try_from(self).unwrap_or_else(|_| Value::Table(Table::new()));
        let value = move |key: &Key| key.name.split('.').try_fold(&table, |value, part| value.get(part)).cloned();
        schema::keys(self.kind()).unwrap_or_default().iter().filter_map(move |key| Some((key, value(key)?)))
    }

    /// Checks a policy that was made by code rather than loaded.
    ///
    /// # Errors
    /// A value out of range, with the name of its key.
    pub fn check(&self) -> Result<()> {
        let table = Table::try_from(self).map_err(|e| ReplayError::Usage { detail: e.to_string() })?;
        POLICIES.check(table.clone())?;
        Ok(check_order(|key| table.get(key), "policy", |_| None)?)
    }
}
