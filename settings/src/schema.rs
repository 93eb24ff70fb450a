//! A table of keys: which exist, and what messages say about those that do not.

use std::collections::BTreeMap;

use toml::{Table, Value};

use crate::error::{Result, SettingsError};
use crate::key::{Entry, Key, flatten};
use crate::near::near;
use crate::source::Sourced;

/// All keys of one thing, such as a machine.
#[derive(Debug)]
pub struct Schema {
    of: String,
    all: Option<&'static str>,
    keys: Vec<Key>,
    places: BTreeMap<&'static str, usize>,
}

impl Schema {
    /// The keys of `entries`; messages call what has them `of`: "a machine".
    pub fn new(of: impl Into<String>, entries: &[Entry]) -> Self {
        let mut keys = Vec::new();
        flatten(entries, "", &mut keys);
        let places = keys.iter().enumerate().map(|(place, key)| (key.name, place)).collect();
        Self { of: of.into(), all: None, keys, places }
    }

    /// For a table that is too long for a message: `all` says where to find the names.
    #[must_use]
    pub fn too_long_to_list(self, all: &'static str) -> Self {
        Self { all: Some(all), ..self }
    }

    /// All keys, in the order of the structs.
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// The key of this name.
    pub fn get(&self, name: &str) -> Option<&Key> {
        self.places.get(name).map(|&place| &self.keys[place])
    }

    /// Place of a key in [`Schema::keys`].
    pub(crate) fn place(&self, name: &str) -> usize {
        self.places.get(name).copied().unwrap_or(usize::MAX)
    }

    /// Whether some key begins with the first part of the override `text` (`table.name=value`).
    pub fn is_override(&self, text: &str) -> bool {
        let table = first(text.split('=').next().unwrap_or_default());
        self.keys.iter().any(|key| first(key.name) == table)
    }

    /// The key of this name, which holds `value`.
    ///
    /// # Errors
    /// A value where a table of keys belongs is a bad value; all else is an unknown key.
    pub(crate) fn find(&self, name: &str, value: &Value, origin: &str) -> Result<&Key> {
        if let Some(key) = self.get(name) {
            return Ok(key);
        }
        if self.is_table(name) {
            let allowed = format!("a table with {}", self.below(name).collect::<Vec<_>>().join(", "));
            return Err(SettingsError::bad_value(origin, name, value, allowed));
        }
        Err(self.unknown(name, self.near(name), origin))
    }

    /// The error of a key that does not exist.
    pub(crate) fn unknown(&self, name: &str, near: String, origin: &str) -> SettingsError {
        SettingsError::UnknownKey { origin: origin.into(), key: name.into(), of: self.of.clone(), near }
    }

    /// `value` as it is kept, if `key` takes it.
    pub(crate) fn accept(key: &Key, value: &Value, origin: &str) -> Result<Value> {
        let wrong = || SettingsError::bad_value(origin, key.name, value, key.rule.describe());
        key.rule.accept(value).ok_or_else(wrong)
    }

    /// Calls `leaf` with the full name of every value in `table`. Depth is bounded by that of the keys: a table that holds none is
    /// a value itself, but for one at the top, whose first value is likelier to be recognised.
    pub(crate) fn leaves(
        &self,
        table: &Table,
        prefix: &str,
        leaf: &mut impl FnMut(&str, &Value) -> Result<()>,
    ) -> Result<()> {
        for (name, value) in table {
            let name = format!("{prefix}{name}");
            let unknown_top = |inner: &Table| prefix.is_empty() && self.get(&name).is_none() && !inner.is_empty();
            match value {
                Value::Table(inner) if self.is_table(&name) || unknown_top(inner) => {
                    self.leaves(inner, &format!("{name}."), leaf)?;
                }
                _ => leaf(&name, value)?,
            }
        }
        Ok(())
    }

    /// Puts `values` over `base`; both stay in the order of the keys.
    pub(crate) fn over(&self, base: &mut Vec<Sourced>, values: Vec<Sourced>) {
        for value in values {
            let place = self.place(value.key);
            match base.binary_search_by_key(&place, |known| self.place(known.key)) {
                Ok(i) => base[i] = value,
                Err(i) => base.insert(i, value),
            }
        }
    }

    /// The keys in the table of this name, without it.
    fn below(&self, name: &str) -> impl Iterator<Item = &'static str> {
        self.keys.iter().filter_map(move |key| key.name.strip_prefix(name)?.strip_prefix('.'))
    }

    fn is_table(&self, name: &str) -> bool {
        self.below(name).next().is_some()
    }

    fn near(&self, name: &str) -> String {
        let names: Vec<_> = self.keys.iter().map(|k| k.name).collect();
        let Some(all) = self.all else { return near(name, &names) };
        // In a large table a slip of the key is likelier than one of its table.
        let table = |name: &str| name.rsplit_once('.').map(|(table, _)| table.to_owned());
        let of_table = |key: &&str| table(key).is_some_and(|of| of == table(name).unwrap_or_default());
        let sisters: Vec<_> = names.iter().copied().filter(of_table).collect();
        let found =
            [sisters, names].iter().map(|names| near(name, names)).find(|text| text.starts_with("did you mean"));
        found.unwrap_or_else(|| all.into())
    }
}

/// The first part of a name, such as that of its table.
fn first(name: &str) -> &str {
    name.split('.').next().unwrap_or_default().trim()
}

/// Values as the nested table that the structs are read from.
pub(crate) fn nest(values: &[Sourced]) -> Table {
    let mut root = Table::new();
    for value in values {
        let mut parts: Vec<&str> = value.key.split('.').collect();
        let leaf = parts.pop().unwrap_or_default();
        let mut table = &mut root;
        for part in parts {
            let inner = table.entry(part).or_insert_with(|| Value::Table(Table::new()));
            let Value::Table(inner) = inner else { unreachable!("no key is the table of another") };
            table = inner;
        }
        table.insert(leaf.into(), value.value.clone());
    }
    root
}
