//! Files that are complete or absent.

use std::fs::{self, File};
use std::path::Path;

use rayreel_formats::durable::{self, PARTIAL};

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

/// Writes a file that never changes, into a folder that is there: whether it was written. It was not if there is one, and of several
/// that write it at once one does. `tag` is in the name of the temporary file and stands for its bytes.
///
/// # Errors
/// When it cannot be written.
pub(crate) fn write_once(path: &Path, tag: &str, bytes: &[u8]) -> Result<bool> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = path.with_file_name(format!(".{name}.{tag}.{}{PARTIAL}", std::process::id()));
    durable::write_whole(&temporary, &[bytes]).map_err(|source| StudyError::io(path, "write", source))?;
    // Unlike a rename it never takes the place of a file.
    let linked = fs::hard_link(&temporary, path);
    // Whoever writes the same at the same moment may have removed it.
    fs::remove_file(&temporary).ok();
    match linked {
        Ok(()) => {
            // So that the name outlives a power cut, where the file system takes part in that.
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            drop(File::open(folder).and_then(|folder| folder.sync_all()));
            Ok(true)
        }
        Err(_) if path.exists() => Ok(false),
        // A file system without second names: the last of several that write at once wins there.
        Err(_) => write_named(path, bytes).map(|()| true),
    }
}
