//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where, what, and what to do about it; they do not repeat their source. Variants
//! are sorted by who must act.

/// Shorthand for results of this crate.
pub type Result<T, E = MachineError> = std::result::Result<T, E>;

/// Everything that can go wrong with a machine.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MachineError {
    /// The machine stands still with work left: a fault of the model, or of a configuration that cannot work.
    #[error(
        "the machine makes no progress at cycle {cycle}: {state}; please report this with the trace and the command"
    )]
    Deadlock {
        /// T&I cycle.
        cycle: u64,
        /// What each core is doing.
        state: String,
    },
    /// Settings of a machine.
    #[error(transparent)]
    Settings(#[from] rayreel_settings::SettingsError),
    /// The calling code broke a rule of the interface.
    #[error("wrong use: {detail}")]
    Usage {
        /// Which rule.
        detail: String,
    },
}
