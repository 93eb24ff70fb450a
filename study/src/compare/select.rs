//! Which columns are compared.

use glob::Pattern;

use crate::error::{Result, StudyError};

/// Patterns over names of columns and keys, such as `gpu_*`.
#[derive(Clone, Debug, Default)]
pub struct Select {
    only: Vec<Pattern>,
    ignore: Vec<Pattern>,
}

impl Select {
    /// Names that match one of `only`, if there is any, and none of `ignore`.
    ///
    /// # Errors
    /// What is no pattern.
    pub fn new(only: &[String], ignore: &[String]) -> Result<Self> {
        let parse = |text: &String| {
            Pattern::new(text).map_err(|e| StudyError::Usage { detail: format!("{text:?} is no pattern: {e}") })
        };
        let all = |texts: &[String]| texts.iter().map(parse).collect::<Result<Vec<_>>>();
        Ok(Self { only: all(only)?, ignore: all(ignore)? })
    }

    /// Whether a name is compared.
    pub fn takes(&self, name: &str) -> bool {
        let any = |patterns: &[Pattern]| patterns.iter().any(|pattern| pattern.matches(name));
        (self.only.is_empty() || any(&self.only)) && !any(&self.ignore)
    }
}
