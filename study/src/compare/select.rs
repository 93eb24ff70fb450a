//! Which columns are compared.

use std::collections::BTreeSet;

use glob::Pattern;
use rayreel_settings::nearest;

use crate::error::{Result, StudyError};

/// Names that a message lists.
const LISTED: usize = 8;

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

    /// Refuses patterns that match no name: whoever mistypes one would compare nothing, and be told that nothing changed.
    ///
    /// # Errors
    /// The first such pattern, with the names that were probably meant.
    pub fn check(&self, names: &BTreeSet<String>) -> Result<()> {
        let options = [("--only", &self.only), ("--ignore", &self.ignore)];
        let all = options.into_iter().flat_map(|(option, patterns)| patterns.iter().map(move |p| (option, p)));
        for (option, pattern) in all {
            if !names.iter().any(|name| pattern.matches(name)) {
                let (pattern, meant) = (pattern.as_str(), meant(pattern.as_str(), names));
                let detail = format!("{option} {pattern:?} matches no column and no key of a configuration; {meant}");
                return Err(StudyError::Usage { detail });
            }
        }
        Ok(())
    }
}

/// What a pattern that matches nothing was probably meant to be: a name near to its letters, or one that has part of them.
fn meant(pattern: &str, names: &BTreeSet<String>) -> String {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let letters: String = pattern.chars().filter(|c| !"*?[]!".contains(*c)).collect();
    let part = |name: &&str| letters.len() > 2 && (name.contains(&letters) || letters.contains(*name));
    let mut near = nearest(&letters, &names);
    near.extend(names.iter().copied().filter(part));
    let mut seen = BTreeSet::new();
    near.retain(|name| seen.insert(*name));
    match near.as_slice() {
        [] if names.is_empty() => "there are none".into(),
        [] => {
            let (few, more) = names.split_at(names.len().min(LISTED));
            let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
            format!("there are {}{more}", few.join(", "))
        }
        near => format!("did you mean {}?", near[..near.len().min(LISTED)].join(" or ")),
    }
}
