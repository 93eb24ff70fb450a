//! A policy in words: what a preset does, and every value as the lines of a file.

use serde_json::Value;

use crate::error::{Result, StudyError};
use rayreel_replay::policy::{PRESETS, Policy, schema};

/// What a policy preset does, in one sentence; nothing for a name that is none.
pub fn summary(preset: &str) -> String {
    let text = PRESETS.iter().find(|(name, _)| *name == preset).map_or("", |(_, text)| text);
    first_sentence(&comment(text)).to_owned()
}

/// Every value of a policy, one line each.
///
/// # Errors
/// Never: the numbers of a policy are finite.
pub fn values(policy: &Policy) -> Result<String> {
    let values = serde_json::to_value(policy).map_err(StudyError::json)?;
    let keys = schema::keys(policy.kind()).unwrap_or_default();
    Ok(keys.iter().map(|key| format!("{} = {}\n", key.name, value_of(&values, key.name))).collect())
}

/// The value of a key such as `similarity.normal_deg`.
pub fn value_of<'a>(values: &'a Value, key: &str) -> &'a Value {
    key.split('.').try_fold(values, |value, part| value.get(part)).unwrap_or(&Value::Null)
}

/// The comment at the head of a file.
pub fn comment(text: &str) -> String {
    let lines = text.lines().map_while(|line| line.strip_prefix('#'));
    lines.map(str::trim).collect::<Vec<_>>().join(" ")
}

/// The first sentence of a text.
pub fn first_sentence(text: &str) -> &str {
    // "et al. 2016" and "2.0:" are no ends: a sentence ends where a capital letter follows.
    let ends = text.match_indices(". ").map(|(i, _)| i);
    let mut ends = ends.filter(|i| text[i + 2..].starts_with(|c: char| c.is_ascii_uppercase()));
    ends.next().map_or(text, |end| &text[..=end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_ends_before_a_capital_letter() {
        assert_eq!(first_sentence("As in et al. 2016. Then more."), "As in et al. 2016.");
        assert_eq!(first_sentence("No end"), "No end");
        assert_eq!(comment("# One\n# two\nkey = 1\n# three"), "One two");
    }

    #[test]
    fn every_preset_says_what_it_does_and_has_values() {
        for (name, _) in PRESETS {
            assert!(!summary(name).is_empty(), "{name}");
        }
        let policy = rayreel_replay::NamedPolicy::load("adaptive", &[]).unwrap().policy;
        assert!(values(&policy).unwrap().lines().all(|line| line.contains(" = ")));
    }
}
