//! The page of a sweep: what its results say, and the means to look further.
//!
//! Summary, sensitivities and best points are made here, so that the page reads without a script. The scripts draw the rest from
//! the table that the page holds, and draw these again for the points that a reader chooses.

mod best;
mod columns;
mod data;
mod effects;
mod explore;
mod number;
mod order;
mod page;
mod summary;
mod view;

use std::path::Path;

use crate::files::write_named;
use crate::html::{ReportError, Written};
use crate::table::Results;
use crate::table::guard::guarded;

/// Makes the page of results and writes it to `file`.
///
/// # Errors
/// When `file` cannot be written.
pub fn write(results: &Results, file: &Path) -> crate::Result<Written, ReportError> {
    let odd = |why| ReportError::Odd { path: file.into(), why: format!("of its results, {why}") };
    let html = guarded(|| page::page(results)).map_err(odd)?;
    write_named(file, html.as_bytes()).map_err(|e| ReportError::Write { source: Box::new(e) })?;
    Ok(Written { bytes: html.len(), picture_bytes: 0, pictures: 0 })
}

#[cfg(test)]
mod tests;
