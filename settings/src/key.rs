//! Keys: what a struct of settings declares about its fields.

use crate::rule::Rule;

/// One setting: what it is called, what it takes, what it means.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Name with dots; within its struct when it stands in an [`Entry`].
    pub name: &'static str,
    /// Allowed values.
    pub rule: Rule,
    /// Unit; empty for words, flags and pure numbers.
    pub unit: &'static str,
    /// Meaning, a fragment.
    pub meaning: &'static str,
}

impl Key {
    /// Meaning and unit, as one fragment.
    pub fn about(&self) -> String {
        if self.unit.is_empty() { self.meaning.into() } else { format!("{}, {}", self.meaning, self.unit) }
    }
}

/// A field of a struct of settings.
#[derive(Clone, Copy, Debug)]
pub enum Entry {
    /// A value.
    Key(Key),
    /// A table of further settings, under the name of the field.
    Table(&'static str, &'static [Entry]),
    /// Further settings under names without a table.
    Flat(&'static [Entry]),
}

impl Entry {
    /// A value that takes other values.
    #[must_use]
    pub const fn with_rule(self, rule: Rule) -> Self {
        match self {
            Self::Key(key) => Self::Key(Key { rule, ..key }),
            table => table,
        }
    }
}

/// A struct of settings. [`settings!`](crate::settings) implements it.
pub trait Settings {
    /// Its fields, in order.
    const ENTRIES: &'static [Entry];
}

/// All keys of `entries` with dotted names, in order. Names are made once and live as long as the program.
pub(crate) fn flatten(entries: &[Entry], prefix: &str, out: &mut Vec<Key>) {
    for entry in entries {
        match entry {
            Entry::Key(key) if prefix.is_empty() => out.push(*key),
            Entry::Key(key) => out.push(Key { name: format!("{prefix}{}", key.name).leak(), ..*key }),
            Entry::Table(name, inner) => flatten(inner, &format!("{prefix}{name}."), out),
            Entry::Flat(inner) => flatten(inner, prefix, out),
        }
    }
}
