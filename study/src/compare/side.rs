//! One of the two things to compare, as a person names it.

use std::path::Path;

use crate::analysis::load;
use crate::compare::run;
use crate::error::{Result, StudyError};
use crate::table::Results;
use rayreel_settings::files;

/// Something to compare.
pub enum Side {
    /// The results of a sweep.
    Table(Results),
    /// One run, as a table of one row.
    Run(Results),
}

impl Side {
    /// Reads the folder of a sweep or of a replay, a Parquet file, or a run as JSON. What a file is shows in its first byte, whatever it is called.
    ///
    /// # Errors
    /// A file that is not there, or is none of these.
    pub fn read(path: &Path) -> Result<Self> {
        if path.is_dir() {
            let run = path.join(load::STATS);
            let is_of_sweep = load::is_sweep(path) || path.join(load::RESULTS).is_file();
            return if run.is_file() && !is_of_sweep { Self::read(&run) } else { Ok(Self::Table(load::load(path)?.0)) };
        }
        load::refuse_trace(path)?;
        let bytes = files::read(path, load::RESULTS_MAX).map_err(|source| StudyError::io(path, "read", source))?;
        if load::is_json(&bytes) {
            return Ok(Self::Run(run::decode(&bytes, path)?));
        }
        Ok(Self::Table(load::load(path)?.0))
    }

    /// Its table.
    pub fn results(&self) -> &Results {
        let (Self::Table(results) | Self::Run(results)) = self;
        results
    }

    /// Whether it is a single run.
    pub fn is_run(&self) -> bool {
        matches!(self, Self::Run(_))
    }
}
