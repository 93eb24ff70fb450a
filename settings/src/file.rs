//! One file: its head (`extends`, `why`, `kind`) and its leaves.
//!
//! ```text
//! extends = "sgrt-ti2"
//! why = "a sentence on how it differs and why"
//! [ti]
//! trv = { value = 4, class = "memory", source = "Lee et al. 2013 (SGRT, HPG)" }
//! ```
//!
//! A file may also write the bare value; it then counts as an override whose source is the file.

use toml::{Table, Value};

use crate::error::{Result, SettingsError};
use crate::family::Family;
use crate::key::Key;
use crate::near::near;
use crate::rule::Rule;
use crate::schema::Schema;
use crate::source::{Class, Sourced};

/// A file as it is written: nothing of what it extends is in it.
#[derive(Clone, Debug)]
pub(crate) struct File {
    /// Preset name or file stem.
    pub name: String,
    /// What messages call it.
    pub origin: String,
    /// What it extends, if anything.
    pub extends: Option<String>,
    /// How it differs from that, and why.
    pub why: String,
    /// Its kind, if it says so and its family has kinds.
    pub kind: Option<&'static str>,
    table: Table,
}

impl File {
    /// Reads the head of a text.
    pub fn parse(family: &Family, name: &str, origin: &str, text: &str) -> Result<Self> {
        let syntax = |e: toml::de::Error| SettingsError::Syntax {
            origin: origin.into(),
            expected: family.expected,
            detail: e.to_string().trim_end().into(),
        };
        Self::new(family, name, origin, text.parse().map_err(syntax)?)
    }

    /// Reads the head of a table.
    pub fn new(family: &Family, name: &str, origin: &str, mut table: Table) -> Result<Self> {
        let kind = if family.kinds.is_empty() { None } else { kind(family, &table, origin)? };
        let mut head = |name: &str| match table.remove(name) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => Err(SettingsError::bad_value(origin, name, &other, "a text in quotes")),
        };
        let (extends, why) = (head("extends")?, head("why")?.unwrap_or_default());
        Ok(Self { name: name.into(), origin: origin.into(), extends, why, kind, table })
    }

    /// What it sets, checked key by key, in the order of the keys.
    ///
    /// # Errors
    /// An unknown key or class, a value that is not allowed, a leaf without a source, a key that stands twice.
    pub fn values(&self, schema: &'static Schema) -> Result<Vec<Sourced>> {
        let mut values = Vec::new();
        schema.leaves(&self.table, "", &mut |name, value| {
            let key = schema.find(name, value, &self.origin)?;
            values.push(self.leaf(schema, key, value)?);
            Ok(())
        })?;
        values.sort_by_cached_key(|v| schema.place(v.key));
        // TOML takes `"a.b" = 1` and `b = 1` in `[a]` for two keys.
        if let Some(twice) = values.windows(2).find(|pair| pair[0].key == pair[1].key) {
            let detail = format!("{} stands twice", twice[0].key);
            return Err(SettingsError::Conflict { origin: self.origin.clone(), detail });
        }
        Ok(values)
    }

    /// A leaf: `{ value, class, source }`, or the bare value.
    fn leaf(&self, schema: &Schema, key: &Key, value: &Value) -> Result<Sourced> {
        let Value::Table(parts) = value else {
            let value = Schema::accept(key, value, &self.origin)?;
            let source = format!("set in {}", self.name);
            return Ok(Sourced { key: key.name, value, class: Class::Override, source, from: self.name.clone() });
        };
        const PARTS: &[&str] = &["value", "class", "source"];
        if let Some(part) = parts.keys().find(|part| !PARTS.contains(&part.as_str())) {
            return Err(schema.unknown(&format!("{}.{part}", key.name), near(part, PARTS), &self.origin));
        }
        let wrong = |name: &str, allowed: &str| {
            let (origin, key, allowed) = (self.origin.clone(), format!("{}.{name}", key.name), allowed.to_owned());
            match parts.get(name) {
                Some(value) => SettingsError::bad_value(&origin, &key, value, allowed),
                None => SettingsError::Unsaid { origin, key, allowed },
            }
        };
        let class = parts.get("class").and_then(Value::as_str).and_then(Class::parse);
        let class = class.ok_or_else(|| wrong("class", &Class::RULE.describe()))?;
        let source = parts.get("source").and_then(Value::as_str).map(str::trim).filter(|s| !s.is_empty());
        let source = source.ok_or_else(|| wrong("source", "a text that says where the value is from"))?.into();
        let value = parts.get("value").ok_or_else(|| wrong("value", &key.rule.describe()))?;
        let value = Schema::accept(key, value, &self.origin)?;
        Ok(Sourced { key: key.name, value, class, source, from: self.name.clone() })
    }
}

/// The `kind` that a table names.
fn kind(family: &Family, table: &Table, origin: &str) -> Result<Option<&'static str>> {
    let Some(value) = table.get("kind") else { return Ok(None) };
    let known = family.kinds.iter().copied().find(|kind| value.as_str() == Some(kind));
    known.map(Some).ok_or_else(|| wrong_kind(family, value, origin))
}

/// The error of a kind that does not exist.
pub(crate) fn wrong_kind(family: &Family, value: &Value, origin: &str) -> SettingsError {
    SettingsError::bad_value(origin, "kind", value, Rule::Word(family.kinds).describe())
}
