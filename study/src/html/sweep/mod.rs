//! The page of a sweep: what its results say, and the means to look further.
//!
//! Summary, sensitivities and best points are made here, so that the page reads without a script. The scripts draw the rest from
//! the table that the page holds, and draw these again for the points that a reader chooses.

mod best;
mod columns;
mod data;
mod drawn;
mod effects;
mod explore;
mod number;
mod order;
mod page;
mod summary;
mod view;

use std::path::Path;

use crate::files::write_named;
use crate::html::{ReportError, Written, keep};
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

/// Writes the charts of the page of the results in `input` into `to`, as they first show; those that its script draws are among
/// them. Gives their names.
///
/// # Errors
/// When there are no charts, or a file cannot be written.
pub fn write_charts(results: &Results, input: &Path, to: &Path) -> crate::Result<Vec<String>, ReportError> {
    let odd = |why| ReportError::Odd { path: input.into(), why };
    let drawn = guarded(|| {
        let view = view::SweepView::new(results);
        // What the sections draw is kept; their text is not asked for.
        let _ = order::section(&view);
        drawn::keep(&view);
        view.charts.into_saved()
    });
    keep(drawn.map_err(odd)?, input, to)
}

#[cfg(test)]
mod tests;
