//! Files that are complete or absent.

use std::fs;
use std::path::Path;

use rayreel_formats::durable;

use crate::error::{Result, StudyError};

/// Writes a file as a whole ([`durable::write_whole`]), and makes its folder if there is none.
///
/// # Errors
/// When it cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let made = folder.map_or(Ok(()), fs::create_dir_all);
    made.and_then(|()| durable::write_whole(path, &[bytes])).map_err(|source| StudyError::io(path, "write", source))
}
