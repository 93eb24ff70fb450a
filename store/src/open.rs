//! Opens a trace by location.

use std::io;

use rayreel_formats::container::Source;
use rayreel_formats::{Error, Result, Trace};

use crate::location::Location;
use crate::options::Options;
#[cfg(feature = "s3")]
use crate::remote;

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
fn connect(url: &str, location: &Location, options: &Options) -> io::Result<Box<dyn Source>> {
    remote::connect(url, location, options)
}

/// Says how to build a program that can.
#[cfg(not(feature = "s3"))]
fn connect(_: &str, _: &Location, _: &Options) -> io::Result<Box<dyn Source>> {
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
