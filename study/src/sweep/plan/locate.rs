//! Where in a plan file something is wrong.

use std::ops::Range;

use crate::error::StudyError;

/// A file with its text.
#[derive(Clone, Copy, Debug)]
pub struct Text<'a> {
    /// Name for messages.
    pub name: &'a str,
    /// Content.
    pub text: &'a str,
}

impl Text<'_> {
    /// The error that `detail` is wrong at byte `span.start`.
    pub fn error(&self, span: &Range<usize>, detail: impl Into<String>) -> StudyError {
        let (line, column) = self.position(span.start);
        StudyError::Input { at: format!("{}:{line}:{column}", self.name), detail: detail.into() }
    }

    /// Line and column of a byte, from 1; columns are counted in characters.
    fn position(&self, byte: usize) -> (usize, usize) {
        let before = &self.text.as_bytes()[..byte.min(self.text.len())];
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        let start = before.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        (line, String::from_utf8_lossy(&before[start..]).chars().count() + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_those_of_an_editor() {
        let text = Text { name: "p", text: "ab\ncé x\n" };
        assert_eq!(text.position(0), (1, 1));
        assert_eq!(text.position(3), (2, 1));
        assert_eq!(text.position(7), (2, 4), "characters, not bytes");
        assert_eq!(text.position(99), (3, 1), "the end");
    }
}
