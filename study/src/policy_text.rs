//! A policy in words: what a preset does, and every value as the lines of a file.

use rayreel_replay::policy::{POLICIES, Policy};

/// What a policy preset or file does, and why; nothing for a name that is none.
pub fn why(preset: &str) -> String {
    POLICIES.load(preset).map(|loaded| loaded.chain[0].why.clone()).unwrap_or_default()
}

/// What a policy preset does, in one sentence; nothing for a name that is none.
pub fn summary(preset: &str) -> String {
    first_sentence(&why(preset)).to_owned()
}

/// Every value of a policy, as lines of a policy file.
pub fn values(policy: &Policy) -> String {
    policy.values().map(|(key, value)| format!("{} = {value}\n", key.name)).collect()
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
    use rayreel_replay::policy::PRESETS;

    use super::*;

    #[test]
    fn a_sentence_ends_before_a_capital_letter() {
        assert_eq!(first_sentence("As in et al. 2016. Then more."), "As in et al. 2016.");
        assert_eq!(first_sentence("No end"), "No end");
    }

    #[test]
    fn every_preset_says_what_it_does_and_has_values() {
        for (name, _) in PRESETS {
            assert!(!summary(name).is_empty(), "{name}");
        }
        let policy = rayreel_replay::NamedPolicy::load("adaptive", &[]).unwrap().policy;
        assert!(values(&policy).lines().all(|line| line.contains(" = ")));
    }
}
