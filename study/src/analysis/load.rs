//! Reading results from the folder of a sweep or from a Parquet file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::error::{Result, StudyError};
use crate::sweep::folder::PLAN;
use crate::table::Results;
use rayreel_settings::files;

/// The results in the folder of a sweep.
pub const RESULTS: &str = "results.parquet";

/// Most bytes of a file of results.
pub(crate) const RESULTS_MAX: u64 = 8 << 30;

/// Whether a path is the folder of a sweep.
pub fn is_sweep(path: &Path) -> bool {
    path.join(PLAN).is_file()
}

/// The results of a Parquet file or of the folder of a sweep, and which file it was.
///
/// # Errors
/// Nothing there, a sweep that was not merged, a file that is no table of ours.
pub fn load(path: &Path) -> Result<(Results, PathBuf)> {
    let missing = |path: &Path, detail: String| StudyError::input(path, detail);
    let file = if path.is_dir() { path.join(RESULTS) } else { path.into() };
    if path.is_dir() && !file.is_file() {
        let detail = if is_sweep(path) {
            format!("no {RESULTS}; `rayreel sweep merge {}` makes it", path.display())
        } else {
            format!("neither {RESULTS} nor {PLAN}: not the folder of a sweep")
        };
        return Err(missing(path, detail));
    }
    let bytes = files::read(&file, RESULTS_MAX).map_err(|e| match e.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::InvalidInput | ErrorKind::InvalidData => {
            missing(&file, format!("cannot read it: {e}"))
        }
        _ => StudyError::io(&file, "read", e),
    })?;
    Ok((decode(bytes, &file)?, file))
}

#[cfg(feature = "parquet")]
fn decode(bytes: Vec<u8>, file: &Path) -> Result<Results> {
    crate::table::parquet::decode(bytes, file)
}

#[cfg(not(feature = "parquet"))]
fn decode(_: Vec<u8>, file: &Path) -> Result<Results> {
    Err(StudyError::input(file, "this program was built without the feature parquet of rayreel-study"))
}
