//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where (file, byte, frame, tile), what, and what to do about it. They do not
//! repeat their source: print the chain. Variants are sorted by who must act: the system, whoever chose the file, whoever
//! has a damaged file, whoever set a limit, whoever wrote the calling code.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::id::{ChunkId, FormatVersion, NONE};

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

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

    /// The same byte, in the frame and tile of a chunk.
    pub fn of(mut self, id: ChunkId) -> Self {
        self.frame = id.frame;
        self.tile = id.tile;
        self
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

/// What a checksum covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Checked {
    /// The file header.
    FileHeader,
    /// The header of a chunk.
    ChunkHeader,
    /// The payload of a chunk.
    Payload,
    /// The column directory of a tile.
    Directory,
    /// The bytes of the column with this id.
    Column(u8),
    /// The payload of the index.
    Index,
    /// The trailer.
    Trailer,
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FileHeader => f.write_str("file header"),
            Self::ChunkHeader => f.write_str("chunk header"),
            Self::Payload => f.write_str("chunk payload"),
            Self::Directory => f.write_str("column directory"),
            Self::Column(id) => write!(f, "column {id}"),
            Self::Index => f.write_str("index"),
            Self::Trailer => f.write_str("trailer"),
        }
    }
}

/// Everything that can go wrong with a trace file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused; the source says why.
    #[error("cannot {action} {}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried, as a verb: "read", "create".
        action: &'static str,
        /// Why it failed.
        source: io::Error,
    },
    /// The file is there already and would be lost.
    #[error("{} already exists; {hint}", path.display())]
    AlreadyExists {
        /// The file.
        path: PathBuf,
        /// What to do.
        hint: &'static str,
    },
    /// Another process is writing this file.
    #[error("{} is being written by another process", path.display())]
    Busy {
        /// The unfinished file.
        path: PathBuf,
    },
    /// The first bytes are not those of a trace.
    #[error("{} is not a trace: it does not start with the magic bytes of a Rayreel trace", path.display())]
    NotATrace {
        /// The file.
        path: PathBuf,
    },
    /// The file is of a version that this build cannot read, or cannot continue to write.
    #[error("{} has format version {found}, this build knows {known}; use a newer rayreel", path.display())]
    UnsupportedVersion {
        /// The file.
        path: PathBuf,
        /// The version in the file.
        found: FormatVersion,
        /// The newest version this build knows.
        known: FormatVersion,
    },
    /// A chunk is packed in a way that this build does not know.
    #[error("{place}unknown encoding {encoding}; use a newer rayreel")]
    UnsupportedEncoding {
        /// Where.
        place: Place,
        /// The code found.
        encoding: u32,
    },
    /// The file has no index: its capture was killed, or its end is lost.
    #[error(
        "{} has no index: its capture was cut short or its end is lost; continue with `rayreel capture --resume`, \
         or recover with `rayreel repair`", path.display()
    )]
    MissingIndex {
        /// The file.
        path: PathBuf,
    },
    /// The trace does not hold this chunk.
    #[error("{} holds no {id}", path.display())]
    MissingChunk {
        /// The file.
        path: PathBuf,
        /// The chunk looked for.
        id: ChunkId,
    },
    /// The file ends too early.
    #[error("{place}file ends early: {needed} bytes needed here, {available} left; try `rayreel repair`")]
    Truncated {
        /// Where.
        place: Place,
        /// Bytes needed from there on.
        needed: u64,
        /// Bytes left from there on.
        available: u64,
    },
    /// Bytes changed since they were written.
    #[error(
        "{place}checksum of the {part} does not hold ({stored:08x} stored, {computed:08x} found); try `rayreel repair`"
    )]
    ChecksumMismatch {
        /// Where the checked bytes start.
        place: Place,
        /// What the checksum covers.
        part: Checked,
        /// The checksum in the file.
        stored: u32,
        /// The checksum of the bytes.
        computed: u32,
    },
    /// The checksums hold, but the content breaks the format.
    #[error("{place}corrupt: {detail}")]
    Corrupt {
        /// Where.
        place: Place,
        /// What is wrong.
        detail: String,
    },
    /// A column of a tile cannot be decoded.
    #[error("{}column {column}: {detail}", Place { frame: *frame, tile: *tile, ..Place::unknown() })]
    Column {
        /// Frame, or [`NONE`].
        frame: u32,
        /// Tile, or [`NONE`].
        tile: u32,
        /// Name of the column.
        column: &'static str,
        /// What is wrong.
        detail: String,
    },
    /// A payload cannot be decoded.
    #[error("cannot decode {what}: {detail}")]
    Decode {
        /// What was decoded: "metadata", "bvh".
        what: &'static str,
        /// What is wrong.
        detail: String,
    },
    /// The file asks for more than the reader is willing to give.
    #[error("{place}{what} is {value}, over the limit of {limit}; if the file can be trusted, raise the limit")]
    LimitExceeded {
        /// Where.
        place: Place,
        /// What is too large, with its unit.
        what: &'static str,
        /// The value found.
        value: u64,
        /// The value allowed.
        limit: u64,
    },
    /// The calling code broke a rule of the interface.
    #[error("wrong use: {detail}")]
    Usage {
        /// Which rule.
        detail: String,
    },
}

impl Error {
    /// [`Error::Io`].
    pub fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::Io { path: path.to_path_buf(), action, source }
    }

    /// [`Error::Corrupt`].
    pub fn corrupt(place: Place, detail: impl Into<String>) -> Self {
        Self::Corrupt { place, detail: detail.into() }
    }

    /// [`Error::Decode`].
    pub fn decode(what: &'static str, detail: impl Into<String>) -> Self {
        Self::Decode { what, detail: detail.into() }
    }

    /// [`Error::Column`]; frame and tile may be [`NONE`] and filled in later by [`Error::in_tile`].
    pub fn column(frame: u32, tile: u32, column: &'static str, detail: impl Into<String>) -> Self {
        Self::Column { frame, tile, column, detail: detail.into() }
    }

    /// [`Error::LimitExceeded`] at an unknown place; see [`Error::at`].
    pub fn limit(what: &'static str, value: u64, limit: u64) -> Self {
        Self::LimitExceeded { place: Place::unknown(), what, value, limit }
    }

    /// [`Error::MissingChunk`].
    pub fn missing(path: &Path, id: ChunkId) -> Self {
        Self::MissingChunk { path: path.to_path_buf(), id }
    }

    /// [`Error::Usage`].
    pub fn usage(detail: impl Into<String>) -> Self {
        Self::Usage { detail: detail.into() }
    }

    /// The same error with the parts of its place that are still unknown taken from `place`.
    pub fn at(mut self, place: &Place) -> Self {
        match &mut self {
            Self::UnsupportedEncoding { place: own, .. }
            | Self::Truncated { place: own, .. }
            | Self::ChecksumMismatch { place: own, .. }
            | Self::Corrupt { place: own, .. }
            | Self::LimitExceeded { place: own, .. } => {
                if own.path.as_os_str().is_empty() {
                    own.path.clone_from(&place.path);
                }
                own.offset = own.offset.or(place.offset);
                fill(&mut own.frame, place.frame);
                fill(&mut own.tile, place.tile);
            }
            Self::Column { frame, tile, .. } => {
                fill(frame, place.frame);
                fill(tile, place.tile);
            }
            _ => {}
        }
        self
    }

    /// The same error, said to be of this frame and tile where it does not say so yet.
    pub fn in_tile(self, frame: u32, tile: u32) -> Self {
        self.at(&Place { frame, tile, ..Place::unknown() })
    }
}

fn fill(own: &mut u32, other: u32) {
    if *own == NONE {
        *own = other;
    }
}

/// [`Error::LimitExceeded`] if `value` is over `limit`.
///
/// # Errors
/// That one.
pub fn check_limit(what: &'static str, value: u64, limit: u64) -> Result<()> {
    if value > limit { Err(Error::limit(what, value, limit)) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_parts_are_not_printed() {
        assert_eq!(Error::limit("columns", 40, 32).to_string(), {
            "columns is 40, over the limit of 32; if the file can be trusted, raise the limit"
        });
        let error = Error::column(NONE, NONE, "hits", "too short");
        assert_eq!(error.to_string(), "column hits: too short");
        assert_eq!(error.in_tile(3, 4).to_string(), "frame 3, tile 4: column hits: too short");
        let place = Place::new(Path::new("a.rtrace"), 7);
        assert_eq!(Error::corrupt(place, "odd").to_string(), "a.rtrace, byte 7: corrupt: odd");
    }

    #[test]
    fn a_known_place_is_kept() {
        let error = Error::limit("x", 2, 1).in_tile(3, 4).in_tile(5, 6).at(&Place::new(Path::new("f"), 9));
        assert!(error.to_string().starts_with("f, byte 9, frame 3, tile 4: x is 2"), "{error}");
    }

    /// Results are returned by value everywhere.
    #[test]
    fn errors_are_small() {
        assert!(size_of::<Error>() <= 96);
    }
}
