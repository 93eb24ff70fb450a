//! A producer that runs a little ahead of its consumer.

use std::sync::mpsc::{SyncSender, sync_channel};

use crate::error::{ReplayError, Result};

/// Finished items that wait; one more is being made.
const AHEAD: usize = 1;

/// Where the producer puts what it made.
pub(crate) struct Output<'a, T>(&'a SyncSender<Result<T>>);

impl<T> Output<'_, T> {
    /// Hands an item over, waiting until there is room.
    ///
    /// # Errors
    /// When the consumer has stopped: nobody sees this error, it only ends the producer.
    pub fn put(&self, item: T) -> Result<()> {
        self.0.send(Ok(item)).map_err(|_| ReplayError::Usage { detail: "the consumer of tiles has stopped".into() })
    }
}

/// Runs `produce` in a thread of its own and gives what it makes to `consume`, in order, in this thread. Items made before an
/// error are consumed before it is returned, whatever the timing; when `consume` fails, its error is returned and the
/// producer ends at its next item.
///
/// # Errors
/// Those of both.
pub(crate) fn ahead<T: Send>(
    produce: impl FnOnce(&Output<'_, T>) -> Result<()> + Send,
    mut consume: impl FnMut(T) -> Result<()>,
) -> Result<()> {
    std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel(AHEAD);
        scope.spawn(move || {
            if let Err(error) = produce(&Output(&sender)) {
                // Fails only if the consumer has stopped, and then has an error of its own.
                let _ = sender.send(Err(error));
            }
        });
        // The receiver goes before the thread is joined, so a producer that waits for room wakes up.
        let mut items = receiver.into_iter();
        let result = items.by_ref().try_for_each(|item| item.and_then(&mut consume));
        drop(items);
        result
    })
}
