//! Opens an object as a source of bytes.

use std::io;
use std::sync::Arc;

use rayreel_formats::container::Source;

use super::disk::DiskCache;
use super::object::Object;
use super::source::RemoteSource;
use crate::location::Location;
use crate::options::Options;

/// Bytes read from either end when an object is opened: file header and metadata at one, index at the other.
const END_LEN: u64 = 64 << 10;

/// Opens an object: one request that asks for its end, and so for its length and version, too.
pub(crate) fn connect(url: &str, location: &Location, options: &Options) -> io::Result<Box<dyn Source>> {
    let (object, end) = Object::open(url, END_LEN, options)?;
    let disk = match (&options.cache, object.version()) {
        (Some(folder), Some(version)) => Some(DiskCache::open(folder, &location.to_string(), &version)?),
        _ => None,
    };
    let size = object.size();
    let source = RemoteSource::new(object, size, disk, Arc::clone(&options.traffic));
    source.keep(size - end.len() as u64, end);
    source.announce(0, END_LEN.min(size))?;
    Ok(Box::new(source))
}
