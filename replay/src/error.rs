//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where, what, and what to do about it; they do not repeat their source. Variants
//! are sorted by who must act.

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
    /// A [`crate::Stop`] was requested. Nothing is wrong: the same call again does the work.
    #[error("interrupted")]
    Interrupted,
    /// The calling code broke a rule of the interface.
    #[error("wrong use: {detail}")]
    Usage {
        /// Which rule.
        detail: String,
    },
    /// The machine.
    #[error(transparent)]
    Machine(#[from] rayreel_machine::MachineError),
}

impl ReplayError {
    /// [`ReplayError::Output`].
    pub(crate) fn output(path: &std::path::Path, action: &'static str, source: io::Error) -> Self {
        Self::Output { path: path.to_path_buf(), action, source }
    }
}
