//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where, what, and what to do about it; they do not repeat their source. Variants
//! are sorted by who must act.

use std::io;
use std::path::PathBuf;

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
    /// No machine preset of this name, and not a file.
    #[error("no machine preset {name:?}; {near}, or give the path of a .toml file")]
    UnknownMachine {
        /// The name asked for.
        name: String,
        /// Names that exist.
        near: String,
    },
    /// A machine file cannot be read.
    #[error("cannot read the machine file {}", path.display())]
    MachineFile {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A machine is not TOML.
    #[error("{origin} is not a valid machine: {detail}")]
    MachineSyntax {
        /// The file or the preset.
        origin: String,
        /// What the parser says, with line and column.
        detail: String,
    },
    /// Machines extend one another in a circle, or in too long a row.
    #[error("machine files extend one another in a circle or more than {limit} deep: {chain}; remove one `extends`")]
    MachineCircle {
        /// The files, each extending the next.
        chain: String,
        /// Most files in a row.
        limit: usize,
    },
    /// A machine override is not of the form `key=value`.
    #[error("cannot read the override {text:?}; write key=value, for example ti.trv_l1.size=32KiB")]
    BadMachineOverride {
        /// The override.
        text: String,
    },
    /// A machine has no such key.
    #[error("{origin}: no key {key:?} in a machine; {near}")]
    UnknownMachineKey {
        /// The file, the preset or the override.
        origin: String,
        /// The key.
        key: String,
        /// Keys that exist.
        near: String,
    },
    /// A machine file leaves out a key.
    #[error(
        "{origin}: {key} is missing; set it, or write extends = \"sgrt-ti2\" to take what is left out from a preset"
    )]
    MissingMachineKey {
        /// The file.
        origin: String,
        /// The key.
        key: &'static str,
    },
    /// A policy value has the wrong type or is out of range.
    #[error("{origin}: {key} = {value} is not allowed; it must be {allowed}")]
    BadValue {
        /// The file, the preset or the override.
        origin: String,
        /// The key.
        key: String,
        /// The value, as TOML.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// Values of a machine cannot stand together.
    #[error("{origin}: {detail}")]
    MachineConflict {
        /// The file or the preset.
        origin: String,
        /// Which values, and what they break.
        detail: String,
    },
    /// The calling code broke a rule of the interface.
    #[error("wrong use: {detail}")]
    Usage {
        /// Which rule.
        detail: String,
    },
}
