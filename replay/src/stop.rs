//! A request to stop, at which long work looks now and then.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{ReplayError, Result};

/// A handle on one request to stop. Clones share it: one thread (or a signal handler) asks, the others look.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// A request that nobody else can make.
    pub fn never() -> Self {
        Self::default()
    }

    /// Asks everyone who holds a clone to stop. It cannot be taken back.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether stopping was asked for.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Goes on unless stopping was asked for.
    ///
    /// # Errors
    /// [`ReplayError::Interrupted`] if it was.
    pub fn check(&self) -> Result<()> {
        if self.is_requested() { Err(ReplayError::Interrupted) } else { Ok(()) }
    }
}

/// For flags that exist already, such as those that a signal sets.
impl From<Arc<AtomicBool>> for Stop {
    fn from(flag: Arc<AtomicBool>) -> Self {
        Self(flag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_the_request() {
        let (flag, never) = (Arc::new(AtomicBool::new(false)), Stop::never());
        let stop = Stop::from(Arc::clone(&flag));
        let other = stop.clone();
        assert!(!other.is_requested() && other.check().is_ok());
        stop.request();
        assert!(other.is_requested() && flag.load(Ordering::Relaxed));
        assert!(matches!(other.check(), Err(ReplayError::Interrupted)));
        assert!(!never.is_requested(), "another request is not this one");
    }
}
