//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where, what, and what to do about it; they do not repeat their source. Every one of
//! them is for the person who wrote the setting.

use std::io;
use std::path::PathBuf;

use toml::Value;

/// Shorthand for results of this crate.
pub type Result<T, E = SettingsError> = std::result::Result<T, E>;

/// Everything that can be wrong with settings. `origin` is the file, the preset or the override.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// A file cannot be read.
    #[error("{}cannot read the {what} file {}", extended(by.as_deref()), path.display())]
    File {
        /// The file that extends it, if one does.
        by: Option<String>,
        /// What it describes: "machine".
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A text is not TOML, or does not have the form of what it describes.
    #[error("{origin} is not {expected}: {detail}")]
    Syntax {
        /// Where.
        origin: String,
        /// What it should be: "valid TOML".
        expected: &'static str,
        /// What the parser says, with line and column.
        detail: String,
    },
    /// No preset of this name, and not a file.
    #[error("{}no {what} preset {name:?}; {near} (or give the path of a .toml file)", extended(by.as_deref()))]
    UnknownPreset {
        /// The file that extends it, if one does.
        by: Option<String>,
        /// What was to be loaded: "machine".
        what: &'static str,
        /// The name asked for.
        name: String,
        /// Names that exist.
        near: String,
    },
    /// What a file extends is no preset and no TOML file.
    #[error("{by}: extends: {spec:?} is no {what} preset and no .toml file; name one")]
    Extends {
        /// The file that extends it.
        by: String,
        /// What was to be loaded: "machine".
        what: &'static str,
        /// What it names.
        spec: String,
    },
    /// Files extend one another in a circle, or in too long a row.
    #[error("{what} files extend one another in a circle or more than {limit} deep: {chain}; remove one `extends`")]
    Circle {
        /// What they describe: "machine".
        what: &'static str,
        /// The files, each extending the next.
        chain: String,
        /// Most files in a row.
        limit: usize,
    },
    /// An override is not of the form `key=value`.
    #[error("cannot read the override {text:?}; write key=value, for example {example}")]
    Override {
        /// The override.
        text: String,
        /// One that would do.
        example: &'static str,
    },
    /// There is no such key.
    #[error("{origin}: no key {key:?} in {of}; {near}")]
    UnknownKey {
        /// Where.
        origin: String,
        /// The key.
        key: String,
        /// What has the keys: "a machine".
        of: String,
        /// Keys that exist.
        near: String,
    },
    /// A key is left out.
    #[error("{origin}: {key} is missing; set it, or write extends = {base:?} to take what is left out from a preset")]
    Missing {
        /// Where.
        origin: String,
        /// The key.
        key: &'static str,
        /// A preset that has it.
        base: &'static str,
    },
    /// A value has the wrong type or is out of range.
    #[error("{origin}: {key} = {} is not allowed; it must be {allowed}", shortened(value))]
    BadValue {
        /// Where.
        origin: String,
        /// The key.
        key: String,
        /// The value, as TOML.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// What a value or a file must say of itself is left out.
    #[error("{origin}: {key} is missing; it must be {allowed}")]
    Unsaid {
        /// Where.
        origin: String,
        /// The key.
        key: String,
        /// What is allowed.
        allowed: String,
    },
    /// Values cannot stand together.
    #[error("{origin}: {detail}")]
    Conflict {
        /// Where.
        origin: String,
        /// Which values, and what they break.
        detail: String,
    },
}

/// A value as messages show it: a number may have hundreds of digits.
fn shortened(value: &str) -> String {
    const MOST: usize = 60;
    match value.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &value[..end]),
        None => value.to_owned(),
    }
}

fn extended(by: Option<&str>) -> String {
    by.map_or_else(String::new, |by| format!("{by}: extends: "))
}

impl SettingsError {
    /// [`SettingsError::BadValue`].
    pub fn bad_value(origin: &str, key: &str, value: &Value, allowed: impl Into<String>) -> Self {
        Self::BadValue { origin: origin.into(), key: key.into(), value: value.to_string(), allowed: allowed.into() }
    }
}
