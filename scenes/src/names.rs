//! Near names: what a mistyped name may have meant.

use rayreel_settings::one_table;
use strsim::levenshtein;

/// At most three of `known` that look like `name`, best first.
fn near_names<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = name.to_lowercase();
    let budget = (wanted.chars().count() / 3).max(2);
    let mut near: Vec<(usize, &str)> = known
        .filter_map(|candidate| {
            let lower = candidate.to_lowercase();
            let contains =
                wanted.len() >= 3 && (lower.contains(&wanted) || (lower.len() >= 3 && wanted.contains(&lower)));
            let distance = if contains { 1 } else { levenshtein(&wanted, &lower) };
            (distance <= budget).then_some((distance, candidate))
        })
        .collect();
    near.sort();
    near.truncate(3);
    near.into_iter().map(|(_, candidate)| candidate).collect()
}

/// `did you mean ...?` when something is near, else the list of what there is.
pub(crate) fn hint<'a>(name: &str, known: &[&'a str], what: &str) -> String {
    let near = near_names(name, known.iter().copied());
    let quote = |names: &[&'a str]| names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    match (near.is_empty(), known.len()) {
        (false, _) => format!("did you mean {}?", quote(&near)),
        (true, 0) => format!("there are no {what}"),
        (true, 1..=12) => format!("the {what} are {}", quote(known)),
        (true, count) => format!("the {what} are {} and {} more", quote(&known[..12]), count - 12),
    }
}

/// A message of the TOML reader in two parts: what is wrong, and for a key or word that does not exist what to write instead. The reader lists
/// those that exist.
pub(crate) fn of_toml(message: &str) -> (String, Option<String>) {
    if let Some(what) = one_table(message) {
        return (what.to_owned(), Some("write its name in two brackets, such as `[[lights]]`".to_owned()));
    }
    let is_name = |text: &str| text.starts_with("unknown field") || text.starts_with("unknown variant");
    let unknown = message.split_once(", expected ").filter(|(start, _)| is_name(start));
    let Some((what, known)) = unknown else { return (message.to_owned(), None) };
    let quoted = |text: &str| text.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let (name, known) = (quoted(what), quoted(known));
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let fix = name.first().map(|name| hint(name, &known, if what.contains("field") { "keys" } else { "words" }));
    (what.to_owned(), fix)
}
