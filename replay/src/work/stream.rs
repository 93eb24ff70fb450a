//! A producer that runs a little ahead of its consumer, as far as memory allows.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::error::{ReplayError, Result};

/// Something that takes memory while it waits.
pub(crate) trait Weigh {
    /// Its bytes, about.
    fn bytes(&self) -> usize;
}

/// Where the producer puts what it made.
pub(crate) struct Output<'a, T> {
    sender: Sender<(Result<T>, usize)>,
    memory: &'a QueueMemory,
}

impl<T: Weigh> Output<'_, T> {
    /// Hands an item over, waiting until there is room. An item heavier than the whole limit waits until nothing else does.
    ///
    /// # Errors
    /// When the consumer has stopped: nobody sees this error, it only ends the producer.
    pub fn put(&self, item: T) -> Result<()> {
        let bytes = item.bytes();
        self.memory.take(bytes);
        self.sender
            .send((Ok(item), bytes))
            .map_err(|_| ReplayError::Usage { detail: "the consumer of tiles has stopped".into() })
    }
}

/// The memory of what waits.
struct QueueMemory {
    limit: usize,
    /// Bytes in use. `None` lifts the limit: the consumer has gone, and nobody would make room.
    used: Mutex<Option<usize>>,
    freed: Condvar,
}

impl QueueMemory {
    fn lock(&self) -> MutexGuard<'_, Option<usize>> {
        self.used.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self, bytes: usize) {
        let full = |used: &mut Option<usize>| used.is_some_and(|used| used > 0 && used + bytes > self.limit);
        let mut used = self.freed.wait_while(self.lock(), full).unwrap_or_else(PoisonError::into_inner);
        *used = used.map(|used| used + bytes);
    }

    fn give(&self, bytes: usize) {
        let mut used = self.lock();
        *used = used.map(|used| used - bytes);
        self.freed.notify_one();
    }
}

/// Runs `produce` in a thread of its own and gives what it makes to `consume`, in order, in this thread; what waits takes
/// `limit` bytes at most, or is one item. Items made before an error are consumed before it is returned, whatever the timing;
/// when `consume` fails, its error is returned and the producer ends at its next item.
///
/// # Errors
/// Those of both.
pub(crate) fn ahead<T: Weigh + Send>(
    limit: usize,
    produce: impl FnOnce(&Output<'_, T>) -> Result<()> + Send,
    mut consume: impl FnMut(T) -> Result<()>,
) -> Result<()> {
    let memory = &QueueMemory { limit, used: Mutex::new(Some(0)), freed: Condvar::new() };
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        scope.spawn(move || {
            let output = Output { sender, memory };
            if let Err(error) = produce(&output) {
                // Fails only if the consumer has stopped, and then has an error of its own.
                let _ = output.sender.send((Err(error), 0));
            }
        });
        // The receiver goes first, then the limit: a producer that waits for room wakes up and finds nobody to send to.
        let _open = Open(memory);
        let mut items = receiver.into_iter();
        items.by_ref().try_for_each(|(item, bytes)| {
            memory.give(bytes);
            item.and_then(&mut consume)
        })
    })
}

/// Takes the limit away when it goes.
struct Open<'a>(&'a QueueMemory);

impl Drop for Open<'_> {
    fn drop(&mut self) {
        *self.0.lock() = None;
        self.0.freed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    use super::*;

    impl Weigh for usize {
        fn bytes(&self) -> usize {
            *self
        }
    }

    fn failed() -> ReplayError {
        ReplayError::Usage { detail: "a test".into() }
    }

    /// Sums count what `put` has returned for, so they are never more than what waits. No item is without weight: it could wait
    /// before a heavy one, which finds the queue empty.
    #[test]
    fn what_waits_fits_the_limit_or_is_one_item() {
        const LIMIT: usize = 40;
        let items: Vec<usize> = (0..2000).map(|i| if i % 50 == 7 { 100 } else { 1 + i * 7 % 13 }).collect();
        let (put, far) = (AtomicUsize::new(0), channel());
        let produce = |output: &Output<'_, usize>| {
            for (i, &item) in items.iter().enumerate() {
                output.put(item)?;
                put.fetch_add(item, Ordering::SeqCst);
                if i == 6 {
                    far.0.send(()).unwrap();
                }
            }
            Ok(())
        };
        let mut taken = Vec::new();
        ahead(LIMIT, produce, |item| {
            if taken.is_empty() {
                // Seven fit, so the producer gets there although only one is taken.
                far.1.recv_timeout(Duration::from_secs(60)).expect("the producer runs ahead");
            }
            taken.push(item);
            let waiting = put.load(Ordering::SeqCst).saturating_sub(taken.iter().sum());
            assert!(waiting <= LIMIT || items[taken.len()] == waiting, "{waiting} bytes wait");
            Ok(())
        })
        .unwrap();
        assert_eq!(taken, items);
    }

    #[test]
    fn items_before_an_error_are_consumed() {
        let mut taken = Vec::new();
        let produce = |output: &Output<'_, usize>| {
            (1..=5).try_for_each(|item| output.put(item))?;
            Err(failed())
        };
        let result = ahead(100, produce, |item| {
            taken.push(item);
            Ok(())
        });
        assert!(matches!(result, Err(ReplayError::Usage { .. })));
        assert_eq!(taken, [1, 2, 3, 4, 5]);
    }

    /// It waits for room when that happens, and would wait for ever.
    #[test]
    fn a_consumer_that_fails_ends_the_producer() {
        let put = AtomicUsize::new(0);
        let produce = |output: &Output<'_, usize>| {
            loop {
                output.put(60)?;
                put.fetch_add(1, Ordering::SeqCst);
            }
        };
        let mut taken = 0;
        let result = ahead(100, produce, |_| {
            taken += 1;
            if taken == 3 { Err(failed()) } else { Ok(()) }
        });
        assert!(matches!(result, Err(ReplayError::Usage { .. })));
        // The three that were taken; at most one more waited.
        assert!((3..=4).contains(&put.load(Ordering::SeqCst)), "{put:?}");
    }
}
