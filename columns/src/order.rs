//! Batches made in parallel and taken in order, few at a time.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc;
use std::time::Duration;

use rayon::prelude::*;

use crate::error::Result;
use crate::schema::Batch;

/// Rows of a batch at most; a batch is a row group of a Parquet file.
pub const ROWS: usize = 1 << 17;

/// Calls `make` for 0 to `count` - 1 in parallel and gives what comes of it to `take` in this order, which meanwhile is made for the
/// next ones. So much is in memory at a time as two numbers a thread, and what is being taken.
///
/// # Errors
/// The first in order; what comes before it was taken.
pub fn ordered<T: Send>(
    count: usize,
    make: impl Fn(usize) -> Result<T> + Sync,
    take: &mut impl FnMut(T) -> Result<()>,
) -> Result<()> {
    let (send, made) = mpsc::channel();
    rayon::in_place_scope(|scope| {
        let start = |number: usize| {
            let (send, make) = (send.clone(), &make);
            scope.spawn(move |_| {
                // Who takes must hear of a panic too, or would wait for ever. After an error nobody takes.
                let _ = send.send((number, catch_unwind(AssertUnwindSafe(|| make(number)))));
            });
        };
        let under_way = (2 * rayon::current_num_threads()).min(count);
        (0..under_way).for_each(start);
        let mut early = BTreeMap::new();
        for number in 0..count {
            let one = loop {
                match early.remove(&number) {
                    Some(one) => break one,
                    None => early.extend(wait(&made)),
                }
            };
            if number + under_way < count {
                start(number + under_way);
            }
            take(one.unwrap_or_else(|panic| resume_unwind(panic))?)?;
        }
        Ok(())
    })
}

/// The next that is made. A thread of the pool works on meanwhile: what it waits for may be its own to make.
fn wait<T>(made: &mpsc::Receiver<T>) -> Option<T> {
    match rayon::yield_now() {
        None => made.recv().ok(),
        Some(rayon::Yield::Executed) => made.try_recv().ok(),
        Some(rayon::Yield::Idle) => made.recv_timeout(Duration::from_millis(1)).ok(),
    }
}

/// Rows that come one by one from a simulation, gathered into batches that are made into something in parallel.
pub struct Gathered<'a, T> {
    make: &'a (dyn Fn(Batch) -> Result<T> + Sync),
    take: &'a mut dyn FnMut(T) -> Result<()>,
    waiting: Vec<Batch>,
}

impl<'a, T: Send> Gathered<'a, T> {
    /// Gives what `make` makes of batches to `take`.
    pub fn new(make: &'a (dyn Fn(Batch) -> Result<T> + Sync), take: &'a mut dyn FnMut(T) -> Result<()>) -> Self {
        Self { make, take, waiting: Vec::new() }
    }

    /// Takes rows, however many: they become batches of [`ROWS`] at most.
    ///
    /// # Errors
    /// Those of `make` and `take`.
    pub fn add(&mut self, rows: Batch) -> Result<()> {
        self.waiting.extend(rows.parts(ROWS));
        if self.waiting.len() < rayon::current_num_threads() { Ok(()) } else { self.flush() }
    }

    /// Hands on what waits.
    ///
    /// # Errors
    /// As [`Gathered::add`].
    pub fn flush(&mut self) -> Result<()> {
        let made: Vec<_> = std::mem::take(&mut self.waiting).into_par_iter().map(self.make).collect();
        made.into_iter().try_for_each(|one| (self.take)(one?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ColumnsError;

    #[test]
    fn order_is_kept_and_the_first_error_counts() {
        for count in [0, 1, 7, 100] {
            let mut taken = Vec::new();
            ordered(count, Ok, &mut |i| {
                taken.push(i);
                Ok(())
            })
            .unwrap();
            assert_eq!(taken, (0..count).collect::<Vec<_>>());
        }
        let mut taken = Vec::new();
        let make = |i: usize| if i % 10 == 9 { Err(ColumnsError::Request(i.to_string())) } else { Ok(i) };
        let error = ordered(100, make, &mut |i| {
            taken.push(i);
            Ok(())
        });
        assert_eq!((error.unwrap_err().to_string(), taken), ("9".into(), (0..9).collect::<Vec<_>>()));
    }

    #[test]
    fn a_pool_of_one_thread_makes_what_it_waits_for_and_a_panic_ends_the_wait() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let mut sum = 0;
        let mut take = |i| {
            sum += i;
            Ok(())
        };
        pool.install(|| ordered(100, Ok, &mut take)).unwrap();
        assert_eq!(sum, 4950);
        let make = |i: usize| if i == 7 { panic!("seven") } else { Ok(i) };
        let ended = catch_unwind(|| ordered(100, make, &mut |_| Ok(())));
        assert_eq!(ended.unwrap_err().downcast_ref(), Some(&"seven"));
    }
}
