//! Near names: what a mistyped name may have meant.

/// At most three of `known` that look like `name`, best first.
fn near_names<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = name.to_lowercase();
    let budget = (wanted.chars().count() / 3).max(2);
    let mut near: Vec<(usize, &str)> = known
        .filter_map(|candidate| {
            let lower = candidate.to_lowercase();
            let contains =
                wanted.len() >= 3 && (lower.contains(&wanted) || (lower.len() >= 3 && wanted.contains(&lower)));
            let distance = if contains { 1 } else { edit_distance(&wanted, &lower) };
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

/// Levenshtein distance, capped by giving up on long words: names are short.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().take(64).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
