//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where, what, and what to do about it; they do not repeat their source. Variants
//! are sorted by who must act: whoever has the trace, whoever chose the policy, whoever chose the output, whoever wrote the
//! calling code.

use std::io;
use std::path::PathBuf;

/// Shorthand for results of this crate.
pub type Result<T, E = ReplayError> = std::result::Result<T, E>;

/// Everything that can go wrong in a replay.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The trace cannot be read; the source says why.
    #[error("cannot read {what} of frame {frame}")]
    Trace {
        /// What was read: "the camera", "tile 7".
        what: String,
        /// The frame.
        frame: u32,
        /// Why it failed.
        #[source]
        source: Box<rayreel_formats::Error>,
    },
    /// A tile does not hold what its metadata promise.
    #[error("frame {frame}, tile {tile}: {detail}; check the trace with `rayreel verify`")]
    BadTile {
        /// The frame.
        frame: u32,
        /// The tile.
        tile: u32,
        /// What is wrong.
        detail: String,
    },
    /// A recorded path does not lead through the tree.
    #[error(
        "frame {frame}, tile {tile}, sample ({x}, {y}), ray {ray}, step {step}: {detail}; check the trace with \
         `rayreel verify`"
    )]
    BadPath {
        /// The frame.
        frame: u32,
        /// The tile.
        tile: u32,
        /// The sample: column of the frame's grid.
        x: u32,
        /// The sample: row of the frame's grid.
        y: u32,
        /// The ray, as the tile numbers its recorded rays.
        ray: u32,
        /// The step of the ray, from 0.
        step: u32,
        /// What is wrong there.
        detail: &'static str,
    },
    /// The trace does not hold this frame.
    #[error("frame {frame} is not in the trace, which holds frames {first} to {last}; choose one of these")]
    NoSuchFrame {
        /// The frame asked for.
        frame: u32,
        /// First frame of the trace.
        first: u32,
        /// Last frame of the trace.
        last: u32,
    },
    /// The machine has no kernel that the policy needs.
    #[error(
        "machine {machine} has no kernel {kernels}, which the policy needs; use policy full, another machine, or give it one \
         (--set srp.kernels.similarity.ii_cycles=2)"
    )]
    MissingKernel {
        /// The machine.
        machine: String,
        /// What is missing.
        kernels: String,
    },
    /// The machine stands still with work left: a fault of the model, or of a configuration that cannot work.
    #[error(
        "the machine makes no progress at cycle {cycle}: {state}; please report this with the trace and the command"
    )]
    Stuck {
        /// T&I cycle.
        cycle: u64,
        /// What each core is doing.
        state: String,
    },
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
    /// A signal asked to stop.
    #[error("interrupted")]
    Interrupted,
    /// There is nothing to replay.
    #[error("{what}; there is nothing to replay")]
    Nothing {
        /// What is empty.
        what: &'static str,
    },
    /// The blocks of the policy do not fit the tiles of the trace.
    #[error(
        "blocks of {block} samples do not fill tiles of {tile} samples; choose a block that divides {tile} ({blocks}), or \
         capture with a tile size that is a multiple of {block} (such as {tiles})"
    )]
    TileSize {
        /// Tile edge of the trace, samples.
        tile: u32,
        /// Block edge of the policy, samples.
        block: u32,
        /// The blocks that would work.
        blocks: String,
        /// Some tile sizes that would work.
        tiles: String,
    },
    /// No preset of this name, and not a file.
    #[error("no policy preset {name:?}; {near}, or give the path of a .toml file")]
    UnknownPreset {
        /// The name asked for.
        name: String,
        /// Names that exist.
        near: String,
    },
    /// A policy file cannot be read.
    #[error("cannot read the policy file {}", path.display())]
    PolicyFile {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A policy is not TOML.
    #[error("{origin} is not valid TOML: {detail}")]
    PolicySyntax {
        /// The file or the preset.
        origin: String,
        /// What the parser says, with line and column.
        detail: String,
    },
    /// An override is not of the form `key=value`.
    #[error("cannot read the override {text:?}; write key=value, for example similarity.normal_deg=12")]
    BadOverride {
        /// The override.
        text: String,
    },
    /// A policy has no such key.
    #[error("{origin}: no key {key:?} in a policy of kind {kind:?}; {near}")]
    UnknownKey {
        /// The file, the preset or the override.
        origin: String,
        /// The key.
        key: String,
        /// Kind of the policy.
        kind: String,
        /// Keys that exist.
        near: String,
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
    /// Values of a machine cannot stand together.
    #[error("{origin}: {detail}")]
    MachineConflict {
        /// The file or the preset.
        origin: String,
        /// Which values, and what they break.
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
    /// A picture file cannot be read.
    #[error("cannot read the picture {}: {detail}", path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// What the decoder says.
        detail: String,
    },
    /// The calling code broke a rule of the interface.
    #[error("wrong use: {detail}")]
    Usage {
        /// Which rule.
        detail: String,
    },
}

impl ReplayError {
    /// [`ReplayError::Output`].
    pub(crate) fn output(path: &std::path::Path, action: &'static str, source: io::Error) -> Self {
        Self::Output { path: path.to_path_buf(), action, source }
    }
}
