//! Warnings about odd input. The same oddity a thousand times is one warning with a count.

use std::collections::BTreeMap;

/// Something odd in the input that was handled, with how often it occurred.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What, where and what was done about it.
    pub message: String,
    /// Number of occurrences.
    pub count: u64,
}

/// Collects warnings; occurrences with the same key are counted, the message of the first is kept.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    index: BTreeMap<String, usize>,
    list: Vec<Warning>,
}

impl Warnings {
    /// Counts one occurrence of `key`.
    pub fn add(&mut self, key: &str, message: impl FnOnce() -> String) {
        if let Some(&at) = self.index.get(key) {
            self.list[at].count += 1;
        } else {
            self.index.insert(key.to_owned(), self.list.len());
            self.list.push(Warning { message: message(), count: 1 });
        }
    }

    /// The warnings in the order of their first occurrence.
    pub fn into_list(self) -> Vec<Warning> {
        self.list
    }
}
