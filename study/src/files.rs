//! Files that are complete or absent.

use std::path::Path;

use rayreel_formats::durable;

use crate::error::{Result, StudyError};

/// Writes a file as a whole ([`durable::write_whole`]) into a folder that is there: for files that users name.
///
/// # Errors
/// When it cannot be written.
pub fn write_named(path: &Path, bytes: &[u8]) -> Result<()> {
    durable::write_whole(path, &[bytes]).map_err(|source| StudyError::io(path, "write", source))
}

/// The same for files of our own folders; makes the folder if there is none.
///
/// # Errors
/// When it cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.map_or(Ok(()), durable::create_folders).map_err(|source| StudyError::io(path, "write", source))?;
    write_named(path, bytes)
}

/// Writes a file that never changes ([`durable::write_once`]) into a folder that is there: whether it was written.
///
/// # Errors
/// When it cannot be written.
pub(crate) fn write_once(path: &Path, bytes: &[u8]) -> Result<bool> {
    durable::write_once(path, bytes).map_err(|source| StudyError::io(path, "write", source))
}
