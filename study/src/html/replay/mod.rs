//! The page of a replay: the folder that `rayreel replay --out` wrote, with its pictures over the frames.

mod apng;
mod charts;
mod folder;
mod page;

use std::path::Path;

pub use apng::animate;
pub use folder::is_of_replay;

use crate::files::write_named;
use crate::html::charts::file::Saved;
use crate::html::{ReportError, Written};
use crate::table::guard::guarded;

/// Makes the page of the replay in `folder` and writes it to `file`.
///
/// # Errors
/// When `stats.json` or a picture is missing or damaged, or `file` cannot be written.
pub fn write(folder: &Path, file: &Path) -> crate::Result<Written, ReportError> {
    let replay = folder::Folder::read(folder)?;
    let (html, _) = drawn(folder, &replay)?;
    write_named(file, html.as_bytes()).map_err(|e| ReportError::Write { source: Box::new(e) })?;
    Ok(Written { bytes: html.len(), picture_bytes: replay.bytes(), pictures: replay.pictures.len() })
}

/// The charts of the page of a replay.
pub(super) fn charts(folder: &Path) -> crate::Result<Vec<Saved>, ReportError> {
    Ok(drawn(folder, &folder::Folder::read(folder)?)?.1)
}

/// The page and its charts. Whatever the numbers of a stranger's replay are, there is a page or one error.
fn drawn(folder: &Path, replay: &folder::Folder) -> crate::Result<(String, Vec<Saved>), ReportError> {
    guarded(|| page::page(replay)).map_err(|why| ReportError::Odd { path: folder.join(folder::STATS), why })
}

#[cfg(test)]
mod tests;
