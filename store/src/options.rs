//! How traces are opened.

use std::sync::Arc;

use rayreel_formats::Limits;

use crate::cache::CacheFolder;
use crate::traffic::Traffic;

/// How traces are opened. By default with the limits of [`Limits::default`], and nothing is kept.
#[derive(Debug, Clone)]
pub struct Options {
    /// What a reader is willing to spend.
    pub limits: Limits,
    /// Where fetched bytes are kept; nothing is kept on disk without it.
    pub cache: Option<CacheFolder>,
    /// Counts what is fetched for all traces that these options open; local files do not count.
    pub traffic: Arc<Traffic>,
    /// How often a request is made again after a fault that may pass. Default 6, within a minute.
    pub retries: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { limits: Limits::default(), cache: None, traffic: Arc::default(), retries: 6 }
    }
}
