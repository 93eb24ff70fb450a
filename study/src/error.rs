//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where, what, and what to do about it; they do not repeat their source. Variants
//! are sorted by who must act.

use std::io;
use std::path::{Path, PathBuf};

use rayreel_replay::ReplayError;

/// Shorthand for results of this crate.
pub type Result<T, E = StudyError> = std::result::Result<T, E>;

/// Everything that can go wrong in a study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A plan, a folder or a record that whoever named it has to correct.
    #[error("{at}: {detail}")]
    Input {
        /// File, and where it is known line and column; or folder.
        at: String,
        /// What is wrong, and what would be right.
        detail: String,
    },
    /// Neither a machine nor a policy has this name.
    #[error("{detail}")]
    NoPreset {
        /// Which one, and which there are.
        detail: String,
    },
    /// A file of results that does not hold what it should: it has to be made again.
    #[error("{}: {detail}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// Why.
        detail: String,
    },
    /// Two attempts at one point gave different rows: a fault of the program, or two programs.
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
    /// The system refuses a file.
    #[error("cannot {action} {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried, as a verb.
        action: &'static str,
        /// Why it failed.
        source: io::Error,
    },
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
    /// [`StudyError::Input`] about a file or folder.
    pub(crate) fn input(path: &Path, detail: impl Into<String>) -> Self {
        Self::Input { at: path.display().to_string(), detail: detail.into() }
    }

    /// [`StudyError::Io`].
    pub(crate) fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::Io { path: path.to_path_buf(), action, source }
    }

    /// [`StudyError::Usage`] for a value that cannot be written as JSON.
    pub(crate) fn json(error: serde_json::Error) -> Self {
        Self::Usage { detail: error.to_string() }
    }

    /// Whether a [`rayreel_replay::Stop`] ended the work: nothing is wrong.
    pub fn is_interruption(&self) -> bool {
        matches!(self, Self::Replay(ReplayError::Interrupted))
    }

    /// Whether data that were read are bad, and neither the call nor the system.
    pub fn is_bad_data(&self) -> bool {
        matches!(self, Self::Conflict { .. } | Self::Corrupt { .. } | Self::Replay(ReplayError::Corrupt { .. }))
    }
}
