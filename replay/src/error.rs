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
    /// A tile contradicts itself: its metadata, its columns, or a path that does not lead through the tree. The trace must be
    /// captured again.
    #[error("frame {frame}, tile {tile}{}: {detail}; check the trace with `rayreel verify`", ray_step(.ray))]
    Corrupt {
        /// The frame.
        frame: u32,
        /// The tile.
        tile: u32,
        /// Where in the tile, if one step of a path is wrong.
        ray: Option<RayStep>,
        /// What is wrong.
        detail: String,
    },
    /// What was asked for does not suit the trace or the machine. Ask for something else.
    #[error(transparent)]
    Request(#[from] RequestError),
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
    /// A stop was requested. Nothing is wrong: the same call again does the work.
    #[error("interrupted")]
    Interrupted,
    /// The calling code broke a rule of the interface.
    #[error("wrong use: {detail}")]
    Usage {
        /// Which rule.
        detail: String,
    },
    /// Settings of a policy.
    #[error(transparent)]
    Settings(#[from] rayreel_settings::SettingsError),
    /// The machine.
    #[error(transparent)]
    Machine(#[from] rayreel_machine::MachineError),
}

impl ReplayError {
    /// [`ReplayError::Trace`], of a tile of a frame.
    pub fn tile((frame, index): (u32, u32), source: rayreel_formats::Error) -> Self {
        Self::Trace { what: format!("tile {index}"), frame, source: Box::new(source) }
    }

    /// [`ReplayError::Output`].
    pub(crate) fn output(path: &std::path::Path, action: &'static str, source: io::Error) -> Self {
        Self::Output { path: path.to_path_buf(), action, source }
    }
}

/// A step of a ray of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayStep {
    /// The sample: column of the frame's grid.
    pub x: u32,
    /// The sample: row of the frame's grid.
    pub y: u32,
    /// The ray, as the tile numbers its recorded rays.
    pub ray: u32,
    /// The step of the ray, from 0.
    pub step: u32,
}

fn ray_step(at: &Option<RayStep>) -> String {
    at.map_or_else(String::new, |RayStep { x, y, ray, step }| format!(", sample ({x}, {y}), ray {ray}, step {step}"))
}

/// Why a request does not suit the trace or the machine.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
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
         (srp.kernels.*.stages)"
    )]
    MissingKernel {
        /// The machine.
        machine: String,
        /// What is missing.
        kernels: String,
    },
    /// A memory wants to be told what units look for, and none of the machine's tells.
    #[error(
        "no unit of machine {machine} tells what it looks for ray by ray: it looks things up for several rays at once; use a machine \
         whose ti.pipeline is parallel, single or unified, or let Memory::wants_lookups be false"
    )]
    NothingTold {
        /// The machine.
        machine: String,
    },
    /// There is nothing to replay.
    #[error("{what}; there is nothing to replay")]
    Nothing {
        /// What is empty.
        what: &'static str,
    },
    /// The blocks of the policy, or the entries of its history, do not fit the tiles of the trace.
    #[error(
        "{key} = {edge} does not divide tiles of {tile} samples; choose one that does ({edges}), or capture with a tile size \
         that is a multiple of {multiple} (such as {tiles})"
    )]
    TileSize {
        /// The key of the policy.
        key: &'static str,
        /// Its value, samples.
        edge: u32,
        /// Tile edge of the trace, samples.
        tile: u32,
        /// The values that would do.
        edges: String,
        /// What suits all that the policy has, samples.
        multiple: u32,
        /// Some tile sizes that would do.
        tiles: String,
    },
}
