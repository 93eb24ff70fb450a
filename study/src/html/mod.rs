//! One page of HTML from a study or from the results of a sweep: `rayreel report`.
//!
//! The page needs no network and no other file. Charts are SVG made here; the script adds what only makes sense on a screen
//! (the image viewer, tooltips, search), and the page reads and prints without it. The same study gives the same bytes.

mod charts;
mod error;
mod load;
pub mod magnitude;
mod modes;
mod page;
mod parts;
pub mod replay;
mod sections;
mod shell;
pub mod sweep;
mod text;
mod view;

use std::path::Path;

use charts::file::Saved;
pub use error::ReportError;
pub use load::load;
pub use view::has_counterpart;

use crate::analysis::load as results;
use crate::files::{write_named, write_whole};
use crate::schema::{FILE, Study};
use crate::table::guard::guarded;

/// A page that was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Size of the file.
    pub bytes: usize,
    /// Size of the pictures in it, as files.
    pub picture_bytes: usize,
    /// How many they are.
    pub pictures: usize,
}

/// Whether a path holds results of a sweep: any file does, and a folder that has a plan or a table and no study.
pub fn is_of_sweep(path: &Path) -> bool {
    let has_table = || results::is_sweep(path) || path.join(results::RESULTS).is_file();
    path.is_file() || (!path.join(FILE).exists() && has_table())
}

/// Makes the page of the study in `folder` and writes it to `file`.
///
/// # Errors
/// When the study or one of its pictures is missing or damaged, or `file` cannot be written.
pub fn write(folder: &Path, file: &Path) -> crate::Result<Written, ReportError> {
    let study = load(folder)?;
    write_study(&study, folder, file)
}

/// Makes the page of a study whose pictures lie in `folder` and writes it to `file`.
///
/// # Errors
/// When a picture is missing or damaged, or `file` cannot be written.
pub fn write_study(study: &Study, folder: &Path, file: &Path) -> crate::Result<Written, ReportError> {
    let pictures = sections::viewer::Pictures::load(study, |name| load::picture(folder, name))?;
    // A study may be a stranger's: whatever its numbers are, there is a page or one error.
    let odd = |why| ReportError::Odd { path: folder.join(FILE), why };
    let (html, _) = guarded(|| page::page(study, &pictures)).map_err(odd)?;
    write_named(file, html.as_bytes()).map_err(|e| ReportError::Write { source: Box::new(e) })?;
    Ok(Written { bytes: html.len(), picture_bytes: pictures.bytes(), pictures: pictures.len() })
}

/// Writes the study in `folder` without its pictures into the folder `to`: a study like any other, small enough to keep. Gives its
/// bytes.
///
/// # Errors
/// When the study cannot be read, or the file cannot be written.
pub fn write_figures(folder: &Path, to: &Path) -> crate::Result<usize, ReportError> {
    let json = serde_json::to_string(&load(folder)?.without_pictures()).map(|json| json + "\n");
    let file = to.join(FILE);
    let json =
        json.map_err(|_| ReportError::Odd { path: folder.join(FILE), why: "it cannot be written again".into() })?;
    write_whole(&file, json.as_bytes()).map_err(|e| ReportError::Write { source: Box::new(e) })?;
    Ok(json.len())
}

/// Writes every chart of the page of a study or of a replay into `to`, as `NAME.svg` and `NAME.csv`. Gives their names.
///
/// # Errors
/// When the results cannot be read, have no charts, or a file cannot be written.
pub fn write_charts(input: &Path, to: &Path) -> crate::Result<Vec<String>, ReportError> {
    let odd = |why| ReportError::Odd { path: input.to_path_buf(), why };
    let saved = if replay::is_of_replay(input) {
        replay::charts(input)?
    } else {
        let study = load(input)?;
        let pictures = sections::viewer::Pictures::load(&study, |name| load::picture(input, name))?;
        guarded(|| page::page(&study, &pictures)).map_err(odd)?.1
    };
    keep(saved, input, to)
}

/// Writes charts; gives their names.
fn keep(saved: Vec<Saved>, input: &Path, to: &Path) -> crate::Result<Vec<String>, ReportError> {
    if saved.is_empty() {
        return Err(ReportError::NoCharts { path: input.to_path_buf() });
    }
    charts::file::write(to, &saved)?;
    Ok(saved.into_iter().map(|chart| chart.name).collect())
}
