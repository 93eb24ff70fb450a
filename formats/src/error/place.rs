//! Where something was found.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::id::{ChunkId, NONE};

/// Where in which file something was found. Unknown parts are left out when it is printed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file; empty if unknown.
    pub path: PathBuf,
    /// Byte offset from the start of the file, if known.
    pub offset: Option<u64>,
    /// Frame, or [`NONE`].
    pub frame: u32,
    /// Tile, or [`NONE`].
    pub tile: u32,
}

impl Place {
    /// Nothing is known.
    pub fn unknown() -> Self {
        Self { path: PathBuf::new(), offset: None, frame: NONE, tile: NONE }
    }

    /// A byte of a file.
    pub fn new(path: &Path, offset: u64) -> Self {
        Self { path: path.to_path_buf(), offset: Some(offset), frame: NONE, tile: NONE }
    }

    /// A tile of a frame; both may be [`NONE`].
    pub fn in_tile(frame: u32, tile: u32) -> Self {
        Self { frame, tile, ..Self::unknown() }
    }

    /// The same byte, in the frame and tile of a chunk.
    pub fn of(mut self, id: ChunkId) -> Self {
        self.frame = id.frame;
        self.tile = id.tile;
        self
    }

    /// Takes the parts that are still unknown from `other`.
    pub(super) fn complete(&mut self, other: &Self) {
        if self.path.as_os_str().is_empty() {
            self.path.clone_from(&other.path);
        }
        self.offset = self.offset.or(other.offset);
        for (known, part) in [(&mut self.frame, other.frame), (&mut self.tile, other.tile)] {
            if *known == NONE {
                *known = part;
            }
        }
    }
}

/// Prints the known parts, each with its separator, ending in `": "`; prints nothing if nothing is known.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        if !self.path.as_os_str().is_empty() {
            write!(f, "{}", self.path.display())?;
            separator = ", ";
        }
        if let Some(offset) = self.offset {
            write!(f, "{separator}byte {offset}")?;
            separator = ", ";
        }
        for (name, value) in [("frame", self.frame), ("tile", self.tile)] {
            if value != NONE {
                write!(f, "{separator}{name} {value}")?;
                separator = ", ";
            }
        }
        if separator.is_empty() { Ok(()) } else { f.write_str(": ") }
    }
}
