//! What a target is.

use crate::random::Random;

/// One kind of input.
pub struct Target {
    /// Its name.
    pub name: &'static str,
    /// Its first inputs.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Reads an input to its end. Gives what is said of it: the first words of a message, or that all is well. Panics if a promise
    /// is broken.
    pub read: fn(&[u8]) -> String,
    /// Changes an input in a way of its own; the general one is used where there is none.
    pub change: Option<fn(&mut Vec<u8>, &mut Random)>,
    /// Mends what would turn every changed input away at the door: lengths, checksums.
    pub mend: Option<fn(&mut Vec<u8>)>,
}

impl std::fmt::Debug for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// What is said of a result.
///
/// # Panics
/// When an error says nothing.
pub fn told<T, E: std::fmt::Display>(result: &Result<T, E>) -> String {
    match result {
        Ok(_) => "well".into(),
        Err(error) => {
            let text = error.to_string();
            assert!(!text.trim().is_empty(), "an error that says nothing");
            text
        }
    }
}

/// Bytes as text, if they are; else something near.
pub fn text(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}
