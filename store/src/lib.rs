//! Opens traces where they are: at a local path and, with the feature `s3`, at `s3://`, `gs://`, `http://` and `https://`.
//!
//! A trace far away is read by ranges: opening it costs a few requests, and from then on only the tiles that are asked for are
//! fetched, each whole tile in one request, a run of neighbours in fewer. What was fetched is kept in a [`CacheFolder`], which
//! several processes share.
//!
//! Invariants: bytes of two versions of an object are never mixed. A block in the cache is complete or absent, and checked
//! when it is read: a damaged one is fetched again. No error or file name holds the query of a URL, which may be a signature.

mod cache;
mod location;
#[cfg(feature = "s3")]
mod remote;
mod traffic;

use std::io;
use std::sync::Arc;

use rayreel_formats::trace::Trace;
use rayreel_formats::{Error, Limits, Result};

pub use cache::CacheFolder;
pub use location::{Location, is_remote};
pub use traffic::Traffic;

/// How traces are opened.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// What a reader is willing to spend.
    pub limits: Limits,
    /// Where fetched bytes are kept; nothing is kept on disk without it.
    pub cache: Option<CacheFolder>,
    /// Counts what is fetched for all traces that these options open; local files do not count.
    pub traffic: Arc<Traffic>,
}

/// Opens a finished trace: reads its index, metadata and BVH, and no tile.
///
/// # Errors
/// [`Error::Io`] if there is no such file or object, it may not be read, or this build knows no URLs; otherwise as
/// [`Trace::open`]. Errors name the location.
pub fn open(location: impl Into<Location>, options: &Options) -> Result<Trace> {
    let location = location.into();
    match &location {
        Location::Local(path) => Trace::open(path, options.limits.clone()),
        Location::Remote(url) => {
            let source = connect(url, &location, options).map_err(|e| Error::io(&location.as_name(), "open", e))?;
            Trace::from_source(source, &location.as_name(), options.limits.clone())
        }
    }
}

/// An object, ready to be read.
#[cfg(feature = "s3")]
fn connect(
    url: &str,
    location: &Location,
    options: &Options,
) -> io::Result<Box<dyn rayreel_formats::container::Source>> {
    remote::connect(url, location, options)
}

/// Says how to build a program that can.
#[cfg(not(feature = "s3"))]
fn connect(_: &str, _: &Location, _: &Options) -> io::Result<Box<dyn rayreel_formats::container::Source>> {
    let how = "this build reads local files only; build rayreel with `cargo build --release --features s3`";
    Err(io::Error::new(io::ErrorKind::Unsupported, how))
}

#[cfg(all(test, not(feature = "s3")))]
mod tests {
    use super::*;

    #[test]
    fn a_url_says_how_to_build() {
        let Err(Error::Io { path, source, .. }) = open("s3://bucket/a.rtrace?key=secret", &Options::default()) else {
            panic!("a URL without the feature");
        };
        assert_eq!(path.to_str(), Some("s3://bucket/a.rtrace"));
        assert!(source.to_string().contains("--features s3"), "{source}");
    }
}
