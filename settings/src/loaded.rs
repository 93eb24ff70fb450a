//! Settings that were loaded: values with their sources, overrides on top.

use std::path::PathBuf;

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::chain::{self, Ancestor};
use crate::error::{Result, SettingsError};
use crate::family::Family;
use crate::file::File;
use crate::schema::{Schema, nest};
use crate::source::{Class, Sourced};

/// [`Sourced::from`] of what was set over presets and files.
const OVERRIDE: &str = "override";

/// The values of a preset or file, those of what it extends under them, and overrides over them.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The preset or file itself, what it extends, and so on to the base.
    pub chain: Vec<Ancestor>,
    /// Every value with its class and source, in the order of the structs.
    pub values: Vec<Sourced>,
    /// What messages call it.
    pub origin: String,
    family: &'static Family,
    schema: &'static Schema,
}

impl Family {
    /// The settings of a preset, or of a TOML file if `spec` ends in `.toml` or contains a path separator.
    ///
    /// # Errors
    /// An unknown preset, an unreadable file, a circle of `extends`, a key that does not exist, a value that is not allowed.
    pub fn load(&'static self, spec: &str) -> Result<Loaded> {
        Loaded::new(self, chain::load(self, spec)?)
    }

    /// The settings of the text of a file; messages call it by what it describes and `name`.
    ///
    /// # Errors
    /// As for [`Family::load`].
    pub fn parse(&'static self, name: &str, text: &str) -> Result<Loaded> {
        let first = File::parse(self, name, &format!("{} {name}", self.what), text)?;
        Loaded::new(self, chain::follow(self, first, PathBuf::new())?)
    }

    /// Checks values that were made by code rather than loaded, key by key.
    ///
    /// # Errors
    /// An unknown key, a value that is not allowed.
    pub fn check(&'static self, values: Table) -> Result<()> {
        let file = File::new(self, self.what, self.what, values)?;
        file.values((self.schema)(file.kind.unwrap_or_default())).map(drop)
    }

    /// Whether `spec` is one of the family's presets, or a file that leads to one or names one of its kinds.
    pub fn owns(&self, spec: &str) -> bool {
        chain::leads_to(self, spec)
    }
}

impl Loaded {
    fn new(family: &'static Family, files: Vec<File>) -> Result<Self> {
        let schema = (family.schema)(chain::kind(&files)?);
        let mut layers = files.iter().map(|file| file.values(schema)).collect::<Result<Vec<_>>>()?;
        let mut values = Vec::new();
        while let Some(layer) = layers.pop() {
            schema.over(&mut values, layer);
        }
        let origin = files[0].origin.clone();
        let chain = files.into_iter().map(|file| Ancestor { name: file.name, why: file.why }).collect();
        Ok(Self { chain, values, origin, family, schema })
    }

    /// Sets one value: `text` is `key=value`, the value in TOML; words and sizes need no quotes. Another `kind` takes all values
    /// of its preset: the others belong to the old kind.
    ///
    /// # Errors
    /// Not of that form, an unknown key, a value that is not allowed; another `kind` after other keys, which it would undo.
    pub fn set(&mut self, text: &str) -> Result<()> {
        let (name, value) = self.family.split(text)?;
        let value = value.parse::<Value>().unwrap_or_else(|_| Value::String(value.into()));
        let origin = format!("override {text:?}");
        let mut changes = Vec::new();
        self.schema.leaves(&Table::from_iter([(name.to_owned(), value)]), "", &mut |name, value| {
            let key = self.schema.find(name, value, &origin)?;
            let value = Schema::accept(key, value, &origin)?;
            let (class, source) = (Class::Override, "command line".into());
            changes.push(Sourced { key: key.name, value, class, source, from: OVERRIDE.into() });
            Ok(())
        })?;
        let kind = changes.iter().find(|v| !self.family.kinds.is_empty() && v.key == "kind");
        if let Some(kind) = kind.filter(|kind| self.get("kind") != Some(&kind.value)) {
            if let Some(before) = self.values.iter().find(|v| v.from == OVERRIDE && v.key != "kind") {
                let detail =
                    format!("it takes all values of its preset, and {} was set before; set kind first", before.key);
                return Err(SettingsError::Conflict { origin, detail });
            }
            let other = self.family.load(kind.value.as_str().unwrap_or_default())?;
            (self.values, self.schema) = (other.values, other.schema);
            return Ok(());
        }
        self.schema.over(&mut self.values, changes);
        Ok(())
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.values.iter().find(|v| v.key == key).map(|v| &v.value)
    }

    /// The override that set a key, as errors say it; nothing if none did.
    pub fn overridden(&self, key: &str) -> Option<String> {
        let found = self.values.iter().find(|v| v.key == key && v.from == OVERRIDE)?;
        // Sizes as they are written, and neither these nor words in quotes.
        let value = self.schema.get(key)?.rule.show(&found.value);
        Some(format!("override \"{key}={}\"", value.trim_matches('"')))
    }

    /// The struct of all values.
    ///
    /// # Errors
    /// The first key that is missing.
    pub fn build<T: DeserializeOwned>(&self) -> Result<T> {
        // Both are in the order of the structs.
        let mut values = self.values.iter().map(|value| value.key).peekable();
        let missing = |key: &&str| values.next_if_eq(key).is_none();
        if let Some(key) = self.schema.keys().iter().map(|key| key.name).find(missing) {
            return Err(SettingsError::Missing { origin: self.origin.clone(), key, base: self.family.base });
        }
        let wrong = |e: toml::de::Error| SettingsError::Syntax {
            origin: self.origin.clone(),
            expected: self.family.expected,
            detail: e.to_string(),
        };
        T::deserialize(nest(&self.values)).map_err(wrong)
    }
}
