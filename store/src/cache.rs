//! Which folder keeps what was fetched, and how much of it.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// Bytes that a cache may hold if nothing else is said.
const MAX_BYTES: u64 = 20_000_000_000;
/// The variable that says otherwise, in 10^9 bytes.
const SIZE: &str = "RAYREEL_TRACE_CACHE_GB";

/// A folder for fetched bytes. It may be deleted at any time, as a whole or in part, also while it is in use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CacheFolder {
    /// The folder; made when it is first needed.
    pub path: PathBuf,
    /// Bytes it may hold. Past that, the objects that were not opened for longest are dropped; if only the present one
    /// is left, no more of it is kept. Several processes that fill it at once may each add that much.
    pub max_bytes: u64,
}

impl CacheFolder {
    /// The folder that a user names (`--trace-cache`), else that of `RAYREEL_TRACE_CACHE`, else `rayreel/traces` in
    /// `XDG_CACHE_HOME` or `~/.cache`. `none` is no folder. `RAYREEL_TRACE_CACHE_GB` is its size in 10^9 bytes; 20 if
    /// not set.
    ///
    /// # Errors
    /// When that is not a number.
    pub fn choose(named: Option<&OsStr>) -> Result<Option<Self>, CacheSizeError> {
        let path = named.map(OsStr::to_os_string).or_else(|| variable("RAYREEL_TRACE_CACHE")).or_else(usual);
        let Some(path) = path.filter(|path| path != "none") else { return Ok(None) };
        let max_bytes = match variable(SIZE) {
            None => MAX_BYTES,
            Some(text) => gigabytes(&text).ok_or(CacheSizeError { variable: SIZE, text })?,
        };
        Ok(Some(Self { path: path.into(), max_bytes }))
    }
}

/// A size of the cache that cannot be understood; whoever set the variable must mend it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{variable}: give a number of gigabytes, such as 20 or 0.5")]
pub struct CacheSizeError {
    /// The variable of the environment.
    pub variable: &'static str,
    /// What it holds.
    pub text: OsString,
}

/// A variable of the environment that is set and not empty.
fn variable(name: &str) -> Option<OsString> {
    std::env::var_os(name).filter(|value| !value.is_empty())
}

/// The folder where programs of this user keep what they can fetch again.
fn usual() -> Option<OsString> {
    let folder = variable("XDG_CACHE_HOME").map(PathBuf::from).filter(|folder| folder.is_absolute());
    let folder = folder.or_else(|| Some(PathBuf::from(variable("HOME")?).join(".cache")))?;
    Some(folder.join("rayreel").join("traces").into_os_string())
}

fn gigabytes(text: &OsStr) -> Option<u64> {
    let number: f64 = text.to_str()?.trim().parse().ok()?;
    // Past 2^64 bytes the conversion saturates, which is as good as no bound.
    (number >= 0.0).then_some((number * 1e9) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        assert_eq!(gigabytes(OsStr::new("20")), Some(MAX_BYTES));
        assert_eq!(gigabytes(OsStr::new(" 0.5")), Some(500_000_000));
        assert_eq!(["-1", "x", "", "nan"].map(|text| gigabytes(OsStr::new(text))), [None; 4]);
    }

    #[test]
    fn a_size_that_is_no_number_names_its_variable() {
        let error = CacheSizeError { variable: SIZE, text: "much".into() };
        assert_eq!(error.to_string(), "RAYREEL_TRACE_CACHE_GB: give a number of gigabytes, such as 20 or 0.5");
    }

    #[test]
    fn none_is_no_folder() {
        assert_eq!(CacheFolder::choose(Some(OsStr::new("none"))), Ok(None));
        let named = CacheFolder::choose(Some(OsStr::new("/x"))).unwrap().unwrap();
        assert_eq!(named.path, PathBuf::from("/x"));
    }
}
