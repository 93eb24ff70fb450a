//! Threads that take items in order, and one that takes what comes of them.
//!
//! Results go to the calling thread as they come, so no worker waits for a disk. Which worker does an item, and when, is in no
//! result.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use rayreel_replay::Stop;

/// How often the calling thread looks up while no result comes.
const LOOK: Duration = Duration::from_millis(50);

/// How many threads there are, and what ends them early.
#[derive(Clone, Debug)]
pub struct Pool {
    /// Items at a time.
    pub threads: usize,
    /// Once it is requested no other item is begun.
    pub stop: Stop,
}

/// What the calling thread is told.
#[derive(Debug)]
pub enum Event<R> {
    /// Item `index` is done.
    Done {
        /// Which item.
        index: usize,
        /// What came of it.
        result: R,
    },
    /// Nothing came for a moment.
    Idle,
}

impl Pool {
    /// Runs `work` on `items`, begun in their order, and gives what comes of them to `take` in this thread. `work` is also told
    /// which worker it is on. After an error of `take` no other item is begun.
    ///
    /// # Errors
    /// The error of `take`.
    pub fn run<T: Sync, R: Send, E>(
        &self,
        items: &[T],
        work: impl Fn(usize, &T) -> R + Sync,
        mut take: impl FnMut(Event<R>) -> Result<(), E>,
    ) -> Result<(), E> {
        let (next, broken) = (AtomicUsize::new(0), AtomicBool::new(false));
        let (sender, receiver) = channel();
        let run = |worker: usize, sender: &Sender<(usize, R)>| {
            while !broken.load(Ordering::Relaxed) && !self.stop.is_requested() {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(item) = items.get(index) else { return };
                if sender.send((index, work(worker, item))).is_err() {
                    return;
                }
            }
        };
        std::thread::scope(|scope| {
            for worker in 0..self.threads.min(items.len()) {
                let (run, sender) = (&run, sender.clone());
                scope.spawn(move || run(worker, &sender));
            }
            drop(sender);
            let mut ended = Ok(());
            while ended.is_ok() {
                ended = match receiver.recv_timeout(LOOK) {
                    Ok((index, result)) => take(Event::Done { index, result }),
                    Err(RecvTimeoutError::Timeout) => take(Event::Idle),
                    Err(RecvTimeoutError::Disconnected) => break,
                };
            }
            // Nobody waits for the workers any more: they are to end too.
            broken.store(ended.is_err(), Ordering::Relaxed);
            ended
        })
    }

    /// Runs `work`, which may fail, on `items`. After an error no item behind it is begun.
    ///
    /// It also ends well when [`Self::stop`] was requested, with items that were never begun: whoever needs them all looks at that.
    ///
    /// # Errors
    /// The first error in the order of the items.
    pub fn each<T: Sync, E: Send>(&self, items: &[T], work: impl Fn(&T) -> Result<(), E> + Sync) -> Result<(), E> {
        let items: Vec<(usize, &T)> = items.iter().enumerate().collect();
        let failed = Failed(AtomicUsize::new(usize::MAX));
        let mut first: Option<(usize, E)> = None;
        let attempt = |_, (index, item): &(usize, &T)| {
            if failed.is_before(*index) {
                return Ok(());
            }
            work(item).inspect_err(|_| failed.add(*index))
        };
        let ended: Result<(), std::convert::Infallible> = self.run(&items, attempt, |event| {
            if let Event::Done { index, result: Err(error) } = event
                && first.as_ref().is_none_or(|(known, _)| index < *known)
            {
                first = Some((index, error));
            }
            Ok(())
        });
        ended.unwrap_or_else(|never| match never {});
        first.map_or(Ok(()), |(_, error)| Err(error))
    }
}

/// The first item that is known to have failed.
struct Failed(AtomicUsize);

impl Failed {
    /// Whether an item need not be begun. One in front of the first may have been taken and not begun; it can fail as well, and is the first
    /// then.
    fn is_before(&self, index: usize) -> bool {
        self.0.load(Ordering::Relaxed) < index
    }

    fn add(&self, index: usize) {
        self.0.fetch_min(index, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    fn pool(threads: usize) -> Pool {
        Pool { threads, stop: Stop::never() }
    }

    #[test]
    fn every_item_is_done_once() {
        for threads in [1, 2, 7] {
            let items: Vec<usize> = (0..100).collect();
            let mut sums = vec![0; 100];
            let ended: Result<(), ()> = pool(threads).run(
                &items,
                |worker, item| {
                    assert!(worker < threads);
                    item * 2
                },
                |event| {
                    if let Event::Done { index, result } = event {
                        sums[index] += result;
                    }
                    Ok(())
                },
            );
            ended.unwrap();
            assert!((0..100).all(|i| sums[i] == 2 * i));
        }
    }

    #[test]
    fn an_error_ends_it_and_the_first_is_told() {
        let begun = Mutex::new(Vec::new());
        let items: Vec<usize> = (0..1000).collect();
        let ended = pool(1).each(&items, |item| {
            begun.lock().unwrap().push(*item);
            if *item == 5 { Err("five") } else { Ok(()) }
        });
        assert_eq!(ended, Err("five"));
        assert_eq!(*begun.lock().unwrap(), [0, 1, 2, 3, 4, 5]);
        // One that was taken before and is begun later may be the first.
        let failed = Failed(AtomicUsize::new(usize::MAX));
        assert!(!failed.is_before(9));
        [5, 7].into_iter().for_each(|index| failed.add(index));
        assert_eq!([4, 5, 6, 8].map(|index| failed.is_before(index)), [false, false, true, true]);
        failed.add(3);
        assert!(failed.is_before(4));
        // Whoever takes results may end it as well.
        let ended = pool(2).run(
            &items,
            |_, item| *item,
            |event| match event {
                Event::Done { .. } => Err("full"),
                Event::Idle => Ok(()),
            },
        );
        assert_eq!(ended, Err("full"));
    }

    #[test]
    fn a_request_to_stop_begins_nothing_more() {
        let stop = Stop::never();
        let pool = Pool { threads: 1, stop: stop.clone() };
        let mut done = 0;
        let items = [(); 100];
        let ended: Result<(), ()> = pool.run(
            &items,
            |_, ()| stop.request(),
            |event| {
                done += usize::from(matches!(event, Event::Done { .. }));
                Ok(())
            },
        );
        ended.unwrap();
        assert_eq!(done, 1);
    }
}
