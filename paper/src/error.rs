//! The one error type of this crate, sorted by who must act.

use rayreel_study::StudyError;

/// Shorthand for results of this crate.
pub type Result<T, E = PaperError> = std::result::Result<T, E>;

/// Everything that can go wrong in the experiment.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PaperError {
    /// A scene that no tree can be built over.
    #[error("cannot build the BVH of scene {scene}: {detail}")]
    Scene {
        /// Name of the scene.
        scene: String,
        /// Why.
        detail: String,
    },
    /// A trace that cannot be captured or read.
    #[error(transparent)]
    Trace(#[from] rayreel_formats::Error),
    /// A point, its result, or a file of the experiment; or an interruption.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The experiment went wrong in itself: a fault of this crate.
    #[error("internal fault, please report it: {detail}")]
    Fault {
        /// What.
        detail: &'static str,
    },
}

impl PaperError {
    /// Somebody asked to stop.
    pub(crate) fn interrupted() -> Self {
        Self::Study(rayreel_replay::ReplayError::Interrupted.into())
    }

    /// Whether a [`rayreel_replay::Stop`] ended the work: nothing is wrong, and the next run goes on there.
    pub fn is_interruption(&self) -> bool {
        matches!(self, Self::Study(error) if error.is_interruption())
    }
}

impl From<rayreel_replay::ReplayError> for PaperError {
    fn from(error: rayreel_replay::ReplayError) -> Self {
        Self::Study(error.into())
    }
}

impl From<rayreel_machine::MachineError> for PaperError {
    fn from(error: rayreel_machine::MachineError) -> Self {
        Self::Study(error.into())
    }
}
