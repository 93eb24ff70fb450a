//! What reading from far away took.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts requests and bytes; shared by all threads and all traces of one [`Options`](crate::Options).
#[derive(Debug, Default)]
pub struct Traffic {
    requests: AtomicU64,
    fetched: AtomicU64,
    cached: AtomicU64,
}

impl Traffic {
    /// Requests answered; what the object store's library tried again counts once.
    pub fn requests(&self) -> u64 {
        self.requests.load(Ordering::Relaxed)
    }

    /// Bytes of objects that these requests brought.
    pub fn fetched_bytes(&self) -> u64 {
        self.fetched.load(Ordering::Relaxed)
    }

    /// Bytes read from the cache folder instead.
    pub fn cached_bytes(&self) -> u64 {
        self.cached.load(Ordering::Relaxed)
    }

    #[cfg(feature = "s3")]
    pub(crate) fn count_request(&self, bytes: u64) {
        self.requests.fetch_add(1, Ordering::Relaxed);
        self.fetched.fetch_add(bytes, Ordering::Relaxed);
    }

    #[cfg(feature = "s3")]
    pub(crate) fn count_cached(&self, bytes: u64) {
        self.cached.fetch_add(bytes, Ordering::Relaxed);
    }
}

impl fmt::Display for Traffic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.requests() == 1 { "" } else { "s" };
        let (fetched, requests, cached) = (self.fetched_bytes(), self.requests(), self.cached_bytes());
        write!(f, "{fetched} bytes in {requests} request{plural}, {cached} bytes from the cache")
    }
}
