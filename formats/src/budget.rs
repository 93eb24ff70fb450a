//! One budget of memory for all that is decoded at a time, whatever the number of threads.

use std::sync::{Condvar, Mutex, PoisonError};

/// Bytes that decoders share. A decoder takes what its input says that it will need, before it begins, and gives it back when it is
/// done; if others have it, it waits for them. It holds one share at a time, so nobody waits for ever.
#[derive(Debug)]
pub struct Budget {
    total: u64,
    left: Mutex<u64>,
    freed: Condvar,
}

/// A share of a [`Budget`], until it is dropped.
#[derive(Debug)]
pub(crate) struct Share<'a> {
    of: &'a Budget,
    bytes: u64,
}

impl Budget {
    /// So many bytes.
    pub fn new(bytes: u64) -> Self {
        Self { total: bytes, left: Mutex::new(bytes), freed: Condvar::new() }
    }

    /// All of it.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Takes a share, after a wait if others have too much. Nothing if the whole is less.
    pub(crate) fn take(&self, bytes: u64) -> Option<Share<'_>> {
        if bytes > self.total {
            return None;
        }
        let left = self.left.lock().unwrap_or_else(PoisonError::into_inner);
        let mut left = self.freed.wait_while(left, |left| *left < bytes).unwrap_or_else(PoisonError::into_inner);
        *left -= bytes;
        Some(Share { of: self, bytes })
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        *self.of.left.lock().unwrap_or_else(PoisonError::into_inner) += self.bytes;
        self.of.freed.notify_all();
    }
}

/// Budgets are the same if they grant the same.
impl PartialEq for Budget {
    fn eq(&self, other: &Self) -> bool {
        self.total == other.total
    }
}

impl Eq for Budget {}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    #[test]
    fn threads_together_never_hold_more_than_there_is() {
        let (budget, held, most) = (Budget::new(10), AtomicU64::new(0), AtomicU64::new(0));
        std::thread::scope(|scope| {
            for bytes in [1, 3, 4, 7, 10, 10] {
                let (budget, held, most) = (&budget, &held, &most);
                scope.spawn(move || {
                    for _ in 0..200 {
                        let share = budget.take(bytes).unwrap();
                        let now = held.fetch_add(bytes, Ordering::SeqCst) + bytes;
                        most.fetch_max(now, Ordering::SeqCst);
                        std::thread::yield_now();
                        held.fetch_sub(bytes, Ordering::SeqCst);
                        drop(share);
                    }
                });
            }
        });
        assert!((1..=10).contains(&most.into_inner()), "some worked, and never too many");
        assert!(budget.take(11).is_none() && budget.take(10).is_some());
    }
}
