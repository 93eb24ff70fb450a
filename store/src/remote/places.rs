//! How what lies in a cache folder is called.

use std::fs;
use std::ops::Range;
use std::path::Path;

/// Digits of the name of an object's folder.
pub(super) const KEY_LEN: usize = 32;
/// The file that says what the object is.
pub(super) const LABEL: &str = "object";

/// The name of a block.
pub(super) fn name(range: &Range<u64>) -> String {
    format!("{:x}-{:x}", range.start, range.end - range.start)
}

/// The range of a block, by its name.
pub(super) fn range_of(name: &str) -> Option<Range<u64>> {
    let (start, len) = name.split_once('-')?;
    let (start, len) = (u64::from_str_radix(start, 16).ok()?, u64::from_str_radix(len, 16).ok()?);
    (len > 0).then_some(start..start.checked_add(len)?)
}

/// The names of what lies in a folder; none if it cannot be read. What is no UTF-8 has one that is like none of the cache's.
pub(super) fn names(folder: &Path) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().into_string().unwrap_or_else(|_| char::REPLACEMENT_CHARACTER.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        assert_eq!(range_of(&name(&(255..1000))), Some(255..1000));
        assert_eq!(
            ["object", ".12-3", ".64-4.77-1.partial", "5-0", "ffffffffffffffff-1", "x-1", ""].map(range_of),
            [const { None }; 7]
        );
    }
}
