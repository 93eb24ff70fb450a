//! Traces as arguments: paths and URLs.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use anyhow::Result;
use rayreel_formats::trace::Trace;
use rayreel_scenes::builtin_names;
use rayreel_store::{CacheFolder, Location, Options, Traffic};
use rayreel_study::cluster::shell::line;

use crate::memory;

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

    /// Its path, if it is a file on this machine.
    pub fn path(&self) -> Option<&Path> {
        match &self.trace {
            Location::Local(path) => Some(path),
            Location::Remote(_) => None,
        }
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

    /// Opens a trace.
    pub fn open(&self, location: &Location) -> Result<Trace> {
        let location = &whole(location);
        let cache = match location {
            Location::Local(_) => None,
            Location::Remote(_) => CacheFolder::choose(self.trace_cache.as_deref()).map_err(anyhow::Error::msg)?,
        };
        let options = Options { limits: memory::limits(), cache, traffic: Arc::clone(&TRAFFIC), ..Options::default() };
        let opened = rayreel_store::open(location, &options);
        opened.map_err(|error| scene_hint(location, error.into()))
    }
}

/// An error of opening, with a word before it where a scene was named for a trace.
fn scene_hint(location: &Location, error: anyhow::Error) -> anyhow::Error {
    let Location::Local(path) = location else { return error };
    let text = path.display().to_string();
    let ends =
        |kinds: &[&str]| path.extension().is_some_and(|end| kinds.iter().any(|kind| end.eq_ignore_ascii_case(kind)));
    let what = match path.is_file() {
        true if ends(&["obj", "gltf", "glb"]) => "is a model and no trace;",
        true if ends(&["toml"]) => "is no trace; if it is a scene,",
        false if builtin_names().contains(&text.as_str()) => "is a scene and no trace;",
        _ => return error,
    };
    let trace = path.file_stem().unwrap_or_default().to_string_lossy().into_owned() + ".rtrace";
    let record = line(&["rayreel", "capture", &text, "-o", &trace]);
    error.context(format!("{text} {what} `{record}` records it"))
}

/// URLs with what may not be written down of them, by what may: those that this process was given.
static WHOLE: Mutex<BTreeMap<String, String>> = Mutex::new(BTreeMap::new());

/// The variable with whole URLs, blanks between them: of traces that plans name without user, password and query.
const URLS: &str = "RAYREEL_TRACE_URLS";

/// The URL to ask for. One with a user, a password or a query is remembered for as long as the process lives; one without is looked
/// up there, and in the environment.
fn whole(location: &Location) -> Location {
    let Location::Remote(url) = location else { return location.clone() };
    let mut known = WHOLE.lock().unwrap_or_else(PoisonError::into_inner);
    if location.has_secret() {
        known.insert(location.to_string(), url.clone());
        return location.clone();
    }
    let given = std::env::var(URLS).unwrap_or_default();
    let found = given.split_whitespace().find(|given| Location::from(*given).to_string() == *url);
    found.or_else(|| known.get(url).map(String::as_str)).map_or_else(|| location.clone(), Location::from)
}

/// Says on standard error what was fetched, if anything was.
pub fn tell_traffic() {
    if TRAFFIC.requests() > 0 {
        tell!("fetched {}", *TRAFFIC);
    }
}
