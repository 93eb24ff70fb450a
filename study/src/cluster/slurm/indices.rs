//! Index lists as `sbatch --array` reads them.

/// Increasing indices as `3,7,9-12`.
pub fn list(indices: &[usize]) -> String {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for &index in indices {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == index => *last = index,
            _ => runs.push((index, index)),
        }
    }
    let text = |(first, last): &(usize, usize)| match last - first {
        0 => first.to_string(),
        _ => format!("{first}-{last}"),
    };
    runs.iter().map(text).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_ranges() {
        assert_eq!(list(&[]), "");
        assert_eq!(list(&[3]), "3");
        assert_eq!(list(&[3, 7, 9, 10, 11, 12]), "3,7,9-12");
        assert_eq!(list(&[0, 1, 3]), "0-1,3");
        assert_eq!(list(&(0..1000).collect::<Vec<_>>()), "0-999");
    }
}
