//! The one error type of this crate, sorted by who must act.

use std::io;
use std::path::{Path, PathBuf};

/// Shorthand for results of this crate.
pub type Result<T, E = ColumnsError> = std::result::Result<T, E>;

/// Everything that can go wrong when data are made columns or files.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ColumnsError {
    /// Whoever asked: such a thing is not to be had.
    #[error("{0}")]
    Request(String),
    /// Whoever has the trace: it cannot be read, or is damaged.
    #[error(transparent)]
    Trace(#[from] rayreel_formats::Error),
    /// The replay or the simulation failed; the source says why.
    #[error(transparent)]
    Replay(#[from] rayreel_replay::ReplayError),
    /// A path of a trace does not lead through its tree.
    #[error("frame {frame}, tile {tile}, ray {ray}, step {step}: {detail}; check the trace with `rayreel verify`")]
    Path {
        /// The frame.
        frame: u32,
        /// The tile.
        tile: u32,
        /// The ray, as the tile numbers its rays.
        ray: u32,
        /// The step of the ray, from 0.
        step: u32,
        /// What is wrong.
        detail: &'static str,
    },
    /// The output cannot be written.
    #[error("cannot write {}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A writer of files refused what it was given: a fault of this crate.
    #[error("cannot write {format}: {detail}")]
    Writer {
        /// Which format.
        format: &'static str,
        /// What it says.
        detail: String,
    },
}

impl ColumnsError {
    /// [`ColumnsError::Output`].
    pub(crate) fn output(path: &Path, source: io::Error) -> Self {
        Self::Output { path: path.to_path_buf(), source }
    }

    /// Whether the input is to blame, not the question.
    pub fn is_bad_data(&self) -> bool {
        matches!(self, Self::Path { .. })
    }
}
