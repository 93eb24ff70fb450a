//! Policies and machines that a command names, with a word where one is taken for the other.

use anyhow::{Error, Result};
use rayreel_machine::NamedMachine;
use rayreel_machine::config::MACHINES;
use rayreel_machine::config::schema::KEYS;
use rayreel_replay::NamedPolicy;
use rayreel_replay::policy::POLICIES;

/// The policy of `--policy` and `--set`.
///
/// # Errors
/// As [`NamedPolicy::load`].
pub fn policy(spec: &str, overrides: &[String]) -> Result<NamedPolicy> {
    NamedPolicy::load(spec, overrides).map_err(|error| {
        let error = Error::from(error);
        if MACHINES.owns(spec) {
            return error.context(format!("{spec} is a machine and no policy; give it to --machine"));
        }
        let words = error.to_string();
        let is_unknown = words.contains("no key") && !words.contains("did you mean");
        let hint = if is_unknown { overrides.iter().find_map(of_machine) } else { None };
        match hint {
            Some(hint) => error.context(hint),
            None => error,
        }
    })
}

/// The machine of `--machine` and `--set`.
///
/// # Errors
/// As [`NamedMachine::load`].
pub fn machine(spec: &str, overrides: &[String]) -> Result<NamedMachine> {
    NamedMachine::load(spec, overrides).map_err(|error| {
        let is_policy = POLICIES.owns(spec);
        let error = Error::from(error);
        if is_policy { error.context(format!("{spec} is a policy and no machine; give it to --policy")) } else { error }
    })
}

/// The keys of a machine that end as that of an override does, in words.
fn of_machine(text: &String) -> Option<String> {
    let key = text.split('=').next()?.trim();
    // A word alone is the whole last part of a key: `block` does not mean `layout.texture_block`.
    let before: &[char] = if key.contains(['.', '_']) { &['.', '_'] } else { &['.'] };
    let ends = |name: &&str| name.strip_suffix(key).is_some_and(|begin| begin.ends_with(before));
    let near: Vec<&str> = KEYS.iter().map(|known| known.name).filter(ends).take(6).collect();
    (!near.is_empty()).then(|| format!("--set {text}: a machine has {}", near.join(", ")))
}
