//! Batches made in parallel and taken in order, few at a time.

use std::ops::Range;

use rayon::prelude::*;

use crate::error::Result;
use crate::schema::Batch;

/// Rows of a batch, about; a batch is a row group of a Parquet file.
pub const ROWS: usize = 1 << 17;

/// Calls `make` for 0 to `count` - 1 in parallel and gives what comes of it to `take` in this order, which meanwhile is made for the
/// next ones. So much is in memory at a time as two numbers a thread, twice.
///
/// # Errors
/// The first in order; what comes before it was taken.
pub fn ordered<T: Send>(
    count: usize,
    make: impl Fn(usize) -> Result<T> + Sync,
    take: &mut (impl FnMut(T) -> Result<()> + Send),
) -> Result<()> {
    let group = 2 * rayon::current_num_threads();
    let make_all = |range: Range<usize>| -> Vec<Result<T>> { range.into_par_iter().map(&make).collect() };
    let mut next = group.min(count);
    let mut made = make_all(0..next);
    while !made.is_empty() {
        let range = next..(next + group).min(count);
        next = range.end;
        let (taken, more) = rayon::join(|| made.into_iter().try_for_each(|one| take(one?)), || make_all(range));
        taken?;
        made = more;
    }
    Ok(())
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

    /// Takes a batch.
    ///
    /// # Errors
    /// Those of `make` and `take`.
    pub fn add(&mut self, batch: Batch) -> Result<()> {
        self.waiting.push(batch);
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
}
