//! What a remote source reads from.

use std::io;
use std::ops::Range;

/// Something that gives ranges of bytes: an object, or what a test puts in its place.
pub(super) trait Fetch: Send + Sync + std::fmt::Debug {
    /// Exactly these bytes.
    fn fetch(&self, range: Range<u64>) -> io::Result<Vec<u8>>;
}
