//! Reading results from the folder of a sweep or from a Parquet file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::error::{Result, StudyError};
use crate::sweep::folder::PLAN;
use crate::table::Results;
use rayreel_formats::container::MAGIC;
use rayreel_settings::files;

/// The results in the folder of a sweep.
pub const RESULTS: &str = "results.parquet";

/// Most bytes of a file of results.
pub(crate) const RESULTS_MAX: u64 = 8 << 30;

/// The figures of a replay in its folder.
pub(crate) const STATS: &str = "stats.json";

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
        } else if path.join(STATS).is_file() {
            format!("it is the folder of a replay; name {} in it", path.join(STATS).display())
        } else {
            format!("neither {RESULTS} nor {PLAN}: not the folder of a sweep")
        };
        return Err(missing(path, detail));
    }
    refuse_trace(&file)?;
    let bytes = files::read(&file, RESULTS_MAX).map_err(|e| match e.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::InvalidInput | ErrorKind::InvalidData => {
            missing(&file, format!("cannot read it: {e}"))
        }
        _ => StudyError::io(&file, "read", e),
    })?;
    if is_json(&bytes) {
        let detail =
            "it is JSON, and no Parquet file; give the folder that it lies in, or a file of `rayreel sweep merge`";
        return Err(missing(&file, detail.into()));
    }
    Ok((decode(bytes, &file)?, file))
}

/// Whether bytes are a run or a study, as far as the first of them tells.
pub(crate) fn is_json(bytes: &[u8]) -> bool {
    bytes.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'{')
}

/// Refuses a trace in the place of results, before all of it is read.
///
/// # Errors
/// The file begins as a trace does.
pub(crate) fn refuse_trace(file: &Path) -> Result<()> {
    // What cannot be read is said when all of it is read.
    if !files::begins_with(file, &MAGIC) {
        return Ok(());
    }
    let detail =
        "it is a trace, and holds no results; `rayreel replay` makes results of it, `rayreel diff` compares two traces";
    Err(StudyError::input(file, detail))
}

#[cfg(feature = "parquet")]
fn decode(bytes: Vec<u8>, file: &Path) -> Result<Results> {
    crate::table::parquet::decode(bytes, file)
}

#[cfg(not(feature = "parquet"))]
fn decode(_: Vec<u8>, file: &Path) -> Result<Results> {
    Err(StudyError::input(file, "this program was built without the feature parquet of rayreel-study"))
}
