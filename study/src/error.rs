//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where, what, and what to do about it; they do not repeat their source. Variants
//! are sorted by who must act.

use rayreel_replay::ReplayError;
use std::io;
use std::path::PathBuf;

/// Shorthand for results of this crate.
pub type Result<T, E = StudyError> = std::result::Result<T, E>;

/// Everything that can go wrong in a study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A plan of a sweep that cannot be carried out.
    #[error("{at}: {detail}")]
    Plan {
        /// File, line and column.
        at: String,
        /// What is wrong, and what would be right.
        detail: String,
    },
    /// A folder of a sweep that is not what it should be.
    #[error("{}: {detail}", path.display())]
    Sweep {
        /// The folder or file.
        path: PathBuf,
        /// What is wrong, and what to do.
        detail: String,
    },
    /// Two attempts at one point gave different rows.
    #[error(
        "point {key} has two different results: {detail}; the simulation is not deterministic, or two programs of one model \
             version differ: keep the sweep folder and report this"
    )]
    Conflict {
        /// Its key.
        key: String,
        /// The first value that differs.
        detail: String,
    },
    /// A file of results that cannot be read or written.
    #[error("{}: {detail}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// Why.
        detail: String,
    },
    /// An output file cannot be written.
    #[error("cannot {action} {}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// What was tried, as a verb.
        action: &'static str,
        /// Why it failed.
        source: io::Error,
    },
    /// A signal asked to stop.
    #[error("interrupted")]
    Interrupted,
    /// The calling code broke a rule of the interface.
    #[error("wrong use: {detail}")]
    Usage {
        /// Which rule.
        detail: String,
    },
    /// A replay.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// The machine.
    #[error(transparent)]
    Machine(#[from] rayreel_machine::MachineError),
}

impl StudyError {
    /// [`StudyError::Output`].
    pub(crate) fn output(path: &std::path::Path, action: &'static str, source: io::Error) -> Self {
        Self::Output { path: path.to_path_buf(), action, source }
    }
}
