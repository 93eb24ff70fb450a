//! What the columns of rows are, kept beside the rows: one file for all rows that have the same.
//!
//! A file is named by a hash of what it holds.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

use crate::error::{Result, StudyError};
use crate::files::write_whole;
use crate::point::row::Column;
use rayreel_settings::files;

/// Most bytes of what columns are: some hundreds for each.
const COLUMNS_MAX: u64 = 1 << 24;

/// Keeps in `folder` what columns are.
///
/// # Errors
/// When the folder cannot be written.
pub fn write_columns(folder: &Path, columns: &[Column]) -> Result<()> {
    let bytes = serde_json::to_vec(columns).map_err(StudyError::json)?;
    let path = folder.join(format!("{}.json", name(&bytes)));
    // A file that was damaged is written again.
    let whole = files::read(&path, COLUMNS_MAX).is_ok_and(|held| held == bytes);
    if whole { Ok(()) } else { write_whole(&path, &bytes) }
}

/// What all columns in `folder` are, by name; none where there is no folder.
///
/// # Errors
/// When the folder cannot be read; a file of it that is no list of columns.
pub fn read_columns(folder: &Path) -> Result<BTreeMap<String, Column>> {
    let mut all = BTreeMap::new();
    for file in listing(folder, "json")? {
        let bytes = files::read(&file, COLUMNS_MAX).map_err(|e| StudyError::io(&file, "read", e))?;
        let damaged = |why: String| {
            let detail = format!(
                "does not say what columns are: {why}; remove it: results then lack the units and meanings of columns that no point \
                 computed from now on has"
            );
            StudyError::Corrupt { path: file.clone(), detail }
        };
        let columns: Vec<Column> = serde_json::from_slice(&bytes).map_err(|e| damaged(e.to_string()))?;
        if file.file_stem().is_none_or(|stem| stem != name(&bytes).as_str()) {
            return Err(damaged("its name is the checksum of other bytes".into()));
        }
        all.extend(columns.into_iter().map(|column| (column.name.clone(), column)));
    }
    Ok(all)
}

fn name(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..16].to_owned()
}

/// The files of a folder whose names end in `.extension`, by name; none where there is no folder.
///
/// # Errors
/// When the folder cannot be read.
pub(crate) fn listing(folder: &Path, extension: &str) -> Result<Vec<std::path::PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(StudyError::io(folder, "read", e)),
    };
    let mut all = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| StudyError::io(folder, "read", e))?.path();
        let hidden = path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'));
        if !hidden && path.extension().is_some_and(|found| found == extension) {
            all.push(path);
        }
    }
    all.sort();
    Ok(all)
}
