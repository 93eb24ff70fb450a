//! Names that were probably meant.

/// "did you mean .." with the names nearest to `name`, or all of them.
pub fn near(name: &str, names: &[&str]) -> String {
    let last = |s: &str| s.rsplit('.').next().unwrap_or_default().to_owned();
    let distance = |other: &str| edits(name, other).min(edits(&last(name), &last(other)));
    let best = names.iter().map(|n| distance(n)).min().unwrap_or(usize::MAX);
    // More than a third of the letters wrong is another word.
    if best <= last(name).chars().count() / 3 + 1 {
        let close: Vec<_> = names.iter().filter(|n| distance(n) == best).copied().collect();
        format!("did you mean {}?", close.join(" or "))
    } else {
        format!("there are {}", names.join(", "))
    }
}

/// Levenshtein distance.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let change = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("abc", "abc"), 0);
    }
}
