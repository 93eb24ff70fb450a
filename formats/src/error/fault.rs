//! What exactly is wrong, within each kind of error.

use std::fmt;

use super::place::Place;
use crate::id::{ChunkId, FormatVersion};
use crate::locks::Holder;

/// What occupies the place of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Occupant {
    /// A file that would be lost.
    #[error("already exists; {hint}")]
    File {
        /// What to do.
        hint: &'static str,
    },
    /// Another process.
    #[error("is being written by {by}; wait until it is done, or stop it")]
    Writer {
        /// Which.
        by: Holder,
    },
}

/// What this build does not know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unknown {
    /// The first bytes are not those of a trace.
    File,
    /// The file is of a version that this build cannot read, or cannot continue to write.
    Version {
        /// The version in the file.
        found: FormatVersion,
        /// The newest version this build knows.
        known: FormatVersion,
    },
    /// A chunk is packed in a way of this code.
    Encoding(u32),
}

impl Unknown {
    /// The whole message: the place stands differently in each.
    pub(super) fn message(self, place: &Place) -> String {
        let path = place.path.display();
        match self {
            Self::File => format!("{path} is not a trace: it does not start with the magic bytes of a Rayreel trace"),
            Self::Version { found, known } => {
                format!("{path} has format version {found}, this build knows {known}; use a newer rayreel")
            }
            Self::Encoding(code) => format!("{place}unknown encoding {code}; use a newer rayreel"),
        }
    }
}

/// What a file lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Missing {
    /// The index: the capture was killed, or the end of the file is lost.
    #[error(
        "has no index: its capture was cut short or its end is lost; \
         continue with `rayreel capture --resume`, or recover with `rayreel repair`"
    )]
    Index,
    /// This chunk.
    #[error("holds no {0}; `rayreel info` tells what it holds")]
    Chunk(ChunkId),
    /// A column of a tile: its writer left it out.
    #[error(
        "holds no {column} in the {tile}; capture it again, or do {} (`rayreel info` tells what it holds)",
        without(column)
    )]
    Column {
        /// The tile.
        tile: ChunkId,
        /// The column.
        column: &'static str,
    },
}

/// How a file is damaged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// It ends too early.
    #[error("file ends early: {needed} bytes needed here, {available} left; try `rayreel repair`")]
    Truncated {
        /// Bytes needed from the place on.
        needed: u64,
        /// Bytes left from there on.
        available: u64,
    },
    /// Bytes changed since they were written.
    #[error("checksum of the {part} does not hold ({stored:08x} stored, {computed:08x} found); try `rayreel repair`")]
    Checksum {
        /// What the checksum covers; the place is where that starts.
        part: Checked,
        /// The checksum in the file.
        stored: u32,
        /// The checksum of the bytes.
        computed: u32,
    },
    /// The checksums hold, but the content breaks the format.
    #[error("corrupt: {0}")]
    Content(String),
    /// A column of a tile cannot be decoded, or does not fit the rest of the tile that is to be written.
    #[error("column {column}: {detail}")]
    Column {
        /// Name of the column.
        column: &'static str,
        /// What is wrong.
        detail: String,
    },
    /// The same fault again, in bytes that were fetched anew.
    #[error("{fault} ({fetched})")]
    Again {
        /// The fault.
        fault: Box<Self>,
        /// From where, and what became of what was kept.
        fetched: String,
    },
    /// A payload cannot be decoded.
    #[error("cannot decode {what}: {detail}")]
    Payload {
        /// What was decoded: "metadata", "bvh".
        what: &'static str,
        /// What is wrong.
        detail: String,
    },
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

/// What can be done without a column.
fn without(column: &str) -> &'static str {
    match column {
        "paths" => "what needs none of them, as `rayreel replay --machine none` where it holds all other columns",
        _ => "what needs none of them",
    }
}
