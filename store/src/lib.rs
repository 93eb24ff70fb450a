//! Opens Rayreel traces by location: a local path or, with the feature `s3`, an object at `s3://`, `gs://`, `http://`
//! or `https://`.
//!
//! - [`open`] takes a path or a URL, or a [`Location`] that was told apart before, and gives a [`Trace`].
//! - [`Options`] say what a reader may spend and where fetched bytes are kept.
//! - [`CacheFolder`] is such a place: a folder that several processes share.
//! - [`Traffic`] counts what was fetched.
//!
//! A remote trace is read by ranges. Opening it costs a few requests; from then on only the tiles that are asked for
//! are fetched, each whole tile in one request, a run of neighbours in fewer.
//!
//! This crate only brings bytes. What they mean is in [`rayreel_formats`]; it uploads nothing and lists no bucket.
//!
//! Invariants: bytes of two versions of an object are never mixed. A block in the cache is complete or absent, and
//! checked when it is read: a damaged one is fetched again. No error or file name holds the query of a URL, which may
//! be a signature.
//!
//! ```
//! use rayreel_store::{Location, Options};
//!
//! let location = Location::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../traces/v1_0_cornell.rtrace"));
//! let options = Options::default();
//! let trace = rayreel_store::open(&location, &options)?;
//! assert_eq!(location.file_name(), "v1_0_cornell.rtrace");
//! assert!(trace.missing_tiles().is_empty());
//! assert_eq!(options.traffic.requests(), 0, "nothing is fetched for a local file");
//! # Ok::<(), rayreel_formats::Error>(())
//! ```
//!
//! [`Trace`]: rayreel_formats::Trace

mod cache;
mod location;
mod open;
mod options;
#[cfg(feature = "s3")]
mod remote;
mod traffic;
mod unavailable;

pub use cache::{CacheFolder, CacheSizeError};
pub use location::{Location, in_folder, is_remote};
pub use open::open;
pub use options::Options;
pub use traffic::Traffic;
pub use unavailable::Unavailable;
