//! Traces as arguments: paths and URLs.

use std::ffi::OsString;
use std::sync::{Arc, LazyLock};

use anyhow::Result;
use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_store::{CacheFolder, Location, Options, Traffic};

/// What this process fetched from far away.
static TRAFFIC: LazyLock<Arc<Traffic>> = LazyLock::new(Arc::default);

/// A trace to read.
#[derive(Debug, clap::Args)]
pub struct TraceArgs {
    /// The trace: a file or, in a build with the feature s3, an s3://, gs://, http:// or https:// URL.
    trace: Location,
    #[command(flatten)]
    cache: CacheArgs,
}

impl TraceArgs {
    /// Opens it.
    pub fn open(&self) -> Result<Trace> {
        self.cache.open(&self.trace)
    }

    /// The last part of its path or URL.
    pub fn file_name(&self) -> String {
        self.trace.file_name()
    }
}

/// Where bytes of traces far away are kept.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct CacheArgs {
    /// Folder that keeps what is fetched of a URL, or none; RAYREEL_TRACE_CACHE if not given, else ~/.cache/rayreel/traces.
    #[arg(long, value_name = "DIR|none")]
    trace_cache: Option<OsString>,
}

impl CacheArgs {
    /// The same as arguments of another process.
    pub fn words(&self) -> Vec<String> {
        let folder = self.trace_cache.iter().map(|folder| folder.to_string_lossy().into_owned());
        folder.flat_map(|folder| ["--trace-cache".to_owned(), folder]).collect()
    }

    /// Opens a trace with the default limits.
    pub fn open(&self, location: &Location) -> Result<Trace> {
        let cache = match location {
            Location::Local(_) => None,
            Location::Remote(_) => CacheFolder::choose(self.trace_cache.as_deref()).map_err(anyhow::Error::msg)?,
        };
        let options = Options { limits: Limits::default(), cache, traffic: Arc::clone(&TRAFFIC) };
        Ok(rayreel_store::open(location, &options)?)
    }
}

/// Says on standard error what was fetched, if anything was.
pub fn tell_traffic() {
    if TRAFFIC.requests() > 0 {
        eprintln!("fetched {}", *TRAFFIC);
    }
}
