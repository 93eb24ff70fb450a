//! The one error type of this crate.
//!
//! Messages are lowercase fragments that say where (file, byte, frame, tile), what, and what to do about it. They do
//! not repeat their source: print the chain.

mod fault;
mod place;

use std::io;
use std::path::{Path, PathBuf};

use rayon::iter::IndexedParallelIterator;

use crate::id::ChunkId;

pub use fault::{Checked, Fault, Missing, Occupant, Unknown};
pub use place::Place;

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong with a trace file, by who must act.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Whoever runs the system: it refused, and the source says why.
    #[error("cannot {action} {}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried, as a verb: "read", "create".
        action: &'static str,
        /// Why it failed.
        source: io::Error,
    },
    /// Whoever named the output: something else is there.
    #[error("{} {by}", path.display())]
    Occupied {
        /// The file.
        path: PathBuf,
        /// What is there.
        by: Occupant,
    },
    /// Whoever chose the file or the build: they do not go together.
    #[error("{}", what.message(place))]
    Unsupported {
        /// Where.
        place: Place,
        /// What this build does not know.
        what: Unknown,
    },
    /// Whoever captured: the file is sound, but not all is there.
    #[error("{} {missing}", path.display())]
    Incomplete {
        /// The file.
        path: PathBuf,
        /// What it lacks.
        missing: Missing,
    },
    /// Whoever has the file, or made its tiles: its content is no trace's.
    #[error("{place}{fault}")]
    Damaged {
        /// Where.
        place: Place,
        /// What is wrong.
        fault: Fault,
    },
    /// Whoever set the limits: the file asks for more than the reader is willing to give.
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
    /// Whoever wrote the calling code: it broke a rule of the interface.
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

    /// [`Error::Occupied`].
    pub fn occupied(path: &Path, by: Occupant) -> Self {
        Self::Occupied { path: path.to_path_buf(), by }
    }

    /// [`Error::Unsupported`].
    pub fn unknown(place: Place, what: Unknown) -> Self {
        Self::Unsupported { place, what }
    }

    /// [`Error::Incomplete`]: a chunk is missing.
    pub fn missing(path: &Path, id: ChunkId) -> Self {
        Self::Incomplete { path: path.to_path_buf(), missing: Missing::Chunk(id) }
    }

    /// [`Error::Damaged`].
    pub fn damaged(place: Place, fault: Fault) -> Self {
        Self::Damaged { place, fault }
    }

    /// [`Fault::Content`].
    pub fn corrupt(place: Place, detail: impl Into<String>) -> Self {
        Self::damaged(place, Fault::Content(detail.into()))
    }

    /// [`Fault::Payload`] at an unknown place.
    pub fn decode(what: &'static str, detail: impl Into<String>) -> Self {
        Self::damaged(Place::unknown(), Fault::Payload { what, detail: detail.into() })
    }

    /// [`Fault::Column`]; frame and tile may be [`NONE`](crate::container::NONE) and filled in later by
    /// [`Error::in_tile`].
    pub fn column(frame: u32, tile: u32, column: &'static str, detail: impl Into<String>) -> Self {
        Self::damaged(Place::in_tile(frame, tile), Fault::Column { column, detail: detail.into() })
    }

    /// [`Error::LimitExceeded`] at an unknown place; see [`Error::at`].
    pub fn limit(what: &'static str, value: u64, limit: u64) -> Self {
        Self::LimitExceeded { place: Place::unknown(), what, value, limit }
    }

    /// [`Error::Usage`].
    pub fn usage(detail: impl Into<String>) -> Self {
        Self::Usage { detail: detail.into() }
    }

    /// The same error with the parts of its place that are still unknown taken from `place`.
    pub fn at(mut self, place: &Place) -> Self {
        if let Self::Unsupported { place: known, .. }
        | Self::Damaged { place: known, .. }
        | Self::LimitExceeded { place: known, .. } = &mut self
        {
            known.complete(place);
        }
        self
    }

    /// The same error, said to be of this frame and tile where it does not say so yet.
    pub fn in_tile(self, frame: u32, tile: u32) -> Self {
        self.at(&Place::in_tile(frame, tile))
    }
}

/// [`Error::LimitExceeded`] if `value` is over `limit`.
///
/// # Errors
/// That one.
pub fn check_limit(what: &'static str, value: u64, limit: u64) -> Result<()> {
    if value > limit { Err(Error::limit(what, value, limit)) } else { Ok(()) }
}

/// What parallel work made, or the first error in its order: rayon's own `collect` gives any of them, another each time.
///
/// # Errors
/// That one.
pub fn first_error<T: Send, E: Send>(made: impl IndexedParallelIterator<Item = Result<T, E>>) -> Result<Vec<T>, E> {
    let mut results = Vec::new();
    made.collect_into_vec(&mut results);
    results.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::{FormatVersion, NONE};
    use crate::locks::Holder;

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
    fn the_first_error_is_that_of_the_first_item() {
        use rayon::prelude::*;

        for _ in 0..20 {
            let made = (0..10_000_u32).into_par_iter().map(|i| if i % 700 == 699 { Err(i) } else { Ok(i) });
            assert_eq!(first_error(made), Err(699));
        }
        assert_eq!(first_error((0..9).into_par_iter().map(Ok::<_, ()>)), Ok((0..9).collect()));
    }

    #[test]
    fn a_known_place_is_kept() {
        let error = Error::limit("x", 2, 1).in_tile(3, 4).in_tile(5, 6).at(&Place::new(Path::new("f"), 9));
        assert!(error.to_string().starts_with("f, byte 9, frame 3, tile 4: x is 2"), "{error}");
    }

    #[test]
    fn every_kind_says_where_and_what() {
        let (path, place) = (Path::new("a.rtrace"), || Place::new(Path::new("a.rtrace"), 7).of(ChunkId::tile(3, 4)));
        let version = Unknown::Version { found: FormatVersion { major: 2, minor: 1 }, known: FormatVersion::CURRENT };
        for (error, text) in [
            (Error::occupied(path, Occupant::File { hint: "go" }), "a.rtrace already exists; go"),
            (
                Error::occupied(path, Occupant::Writer { by: Holder(Some(7)) }),
                "a.rtrace is being written by process 7; wait until it is done, or stop it",
            ),
            (
                Error::unknown(place(), version),
                "a.rtrace has format version 2.1, this build knows 1.0; use a newer rayreel",
            ),
            (
                Error::unknown(place(), Unknown::Encoding(9)),
                "a.rtrace, byte 7, frame 3, tile 4: unknown encoding 9; use a newer rayreel",
            ),
            (Error::missing(path, ChunkId::BVH), "a.rtrace holds no BVH chunk; `rayreel info` tells what it holds"),
            (
                Error::damaged(place(), Fault::Truncated { needed: 9, available: 2 }),
                "a.rtrace, byte 7, frame 3, tile 4: file ends early: 9 bytes needed here, 2 left; try `rayreel repair`",
            ),
            (
                Error::damaged(place(), Fault::Checksum { part: Checked::Column(2), stored: 1, computed: 0xabc }),
                "a.rtrace, byte 7, frame 3, tile 4: checksum of the column 2 does not hold \
                 (00000001 stored, 00000abc found); try `rayreel repair`",
            ),
            (Error::decode("bvh", "odd"), "cannot decode bvh: odd"),
            (Error::usage("no"), "wrong use: no"),
        ] {
            assert_eq!(error.to_string(), text);
        }
        let lost = Error::Incomplete { path: path.into(), missing: Missing::Index }.to_string();
        assert!(
            lost.starts_with("a.rtrace has no index: its capture was cut short or its end is lost; continue"),
            "{lost}"
        );
        let other = Error::unknown(place(), Unknown::File).to_string();
        assert!(other.starts_with("a.rtrace is not a trace: it does not start with"), "{other}");
    }

    /// Results are returned by value everywhere.
    #[test]
    fn errors_are_small() {
        assert!(size_of::<Error>() <= 96);
    }
}
