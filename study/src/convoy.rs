//! Jobs that go through a trace side by side, so that its paths are decoded once for all of them: whoever is far ahead waits for the last.
//!
//! Paths decoded take a hundred times their bytes, those of a large frame more than the memory of most computers. So they cannot be kept for jobs
//! that come later; but jobs that are at nearly the same place need only what lies between the first and the last of them.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use rayreel_replay::Stop;

/// How far the first may be ahead of the last, tiles that their machines are through with. Each decodes further ahead than its machine is, as
/// far as the memory for what waits there reaches.
const LEAD: u64 = 32;

/// How often who waits looks whether all is to stop.
const LOOK: Duration = Duration::from_millis(100);

/// Jobs on their way through a trace.
pub struct Convoy {
    /// Where those are that have begun and not ended, by number: tiles that they are through with.
    places: Mutex<Vec<Option<u64>>>,
    moved: Condvar,
}

/// A job on its way; it leaves the convoy where this ends.
pub struct Member<'a> {
    convoy: &'a Convoy,
    number: usize,
}

impl Convoy {
    /// So many jobs, none of which has begun.
    pub fn new(members: usize) -> Self {
        Self { places: Mutex::new(vec![None; members]), moved: Condvar::new() }
    }

    /// Job `number` begins. Nobody waits for those who have not.
    pub fn join(&self, number: usize) -> Member<'_> {
        self.put(number, Some(0));
        Member { convoy: self, number }
    }

    fn put(&self, number: usize, place: Option<u64>) {
        self.places.lock().unwrap_or_else(PoisonError::into_inner)[number] = place;
        self.moved.notify_all();
    }
}

impl Member<'_> {
    /// It is through with so many tiles. Waits until the last one is near enough, or all is to stop.
    pub fn is_at(&self, tiles: u64, stop: &Stop) {
        let mut places = self.convoy.places.lock().unwrap_or_else(PoisonError::into_inner);
        // Who passes a frame again has been there.
        let place = places[self.number].unwrap_or(0).max(tiles);
        places[self.number] = Some(place);
        self.convoy.moved.notify_all();
        let last = |places: &[Option<u64>]| places.iter().flatten().copied().min().unwrap_or(0);
        while place > last(&places) + LEAD && !stop.is_requested() {
            let waited = self.convoy.moved.wait_timeout(places, LOOK);
            (places, _) = waited.unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Drop for Member<'_> {
    fn drop(&mut self) {
        self.convoy.put(self.number, None);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    #[test]
    fn nobody_is_far_ahead_of_the_last() {
        let (convoy, stop) = (Convoy::new(3), Stop::never());
        let slow = AtomicU64::new(0);
        std::thread::scope(|scope| {
            let (last, others) = (convoy.join(0), [convoy.join(1), convoy.join(2)]);
            for member in others {
                let (slow, stop) = (&slow, &stop);
                scope.spawn(move || {
                    for tiles in 1..=200 {
                        member.is_at(tiles, stop);
                        assert!(tiles <= slow.load(Ordering::SeqCst) + LEAD, "{tiles}");
                    }
                });
            }
            for tiles in 1..=200 {
                slow.store(tiles, Ordering::SeqCst);
                last.is_at(tiles, &stop);
            }
        });
    }

    #[test]
    fn nobody_waits_for_who_has_left_or_not_begun() {
        let (convoy, stop) = (Convoy::new(3), Stop::never());
        let first = convoy.join(0);
        first.is_at(1000, &stop);
        let second = convoy.join(1);
        drop(second);
        first.is_at(2000, &stop);
        // Nor when all is to stop.
        let _behind = convoy.join(2);
        stop.request();
        first.is_at(3000, &stop);
    }
}
