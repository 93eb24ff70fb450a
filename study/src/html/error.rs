//! What can be wrong with a study's folder.

use std::io;
use std::path::PathBuf;

/// Why a report cannot be made. Messages are lowercase fragments that say where, what, and what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// There is no study.
    #[error("no study.json, no stats.json and no results of a sweep in {}; give the folder that `rayreel paper` or `rayreel replay --out` wrote its results to, the folder of a sweep, or a .parquet file", folder.display())]
    NoStudy {
        /// The folder.
        folder: PathBuf,
    },
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// The page cannot be written.
    #[error("the report is not written")]
    Write {
        /// Why.
        #[source]
        source: Box<crate::StudyError>,
    },
    /// The study is not JSON, or lacks something.
    #[error("{} is damaged at line {line}, column {column}: {detail}; write it again with the command that made it", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong there.
        detail: String,
    },
    /// Values that no page can be made of.
    #[error("{}: no page can be made of what stands in it: {why}; write it again with the command that made it", path.display())]
    Odd {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        why: String,
    },
    /// The study is of another version.
    #[error(
        "{} has schema {found}, and this program reads {}; write it again with this version",
        path.display(),
        crate::schema::SCHEMA
    )]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its schema.
        found: u64,
    },
    /// A picture that the study names is not there.
    #[error("picture {name:?} of {} is not there; run the command that made the folder again", path.display())]
    NoPicture {
        /// The study.
        path: PathBuf,
        /// The picture.
        name: String,
    },
    /// There is nothing to draw.
    #[error("{} has no charts: they show what is simulated and varies, and of a replay several frames", path.display())]
    NoCharts {
        /// The results.
        path: PathBuf,
    },
    /// A picture cannot be embedded.
    #[error("picture {name:?} of {}: {detail}; run the command that made the folder again", path.display())]
    BadPicture {
        /// The study.
        path: PathBuf,
        /// The picture.
        name: String,
        /// What is wrong.
        detail: &'static str,
    },
}

impl ReportError {
    /// Whether a file is there and bad, rather than missing or out of reach.
    pub fn is_bad_data(&self) -> bool {
        matches!(
            self,
            Self::Damaged { .. }
                | Self::Odd { .. }
                | Self::Schema { .. }
                | Self::NoPicture { .. }
                | Self::BadPicture { .. }
        )
    }
}
