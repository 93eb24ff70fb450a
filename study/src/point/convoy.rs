//! Jobs that go through a trace side by side, so that its paths are decoded once for all of them: whoever is far ahead waits for the last.
//!
//! Paths decoded take a hundred times their bytes, those of a large frame more than the memory of most computers. So they cannot be kept for jobs
//! that come later; but jobs that are at nearly the same place need only what lies between the first and the last of them.

use std::cell::Cell;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rayreel_replay::Stop;

/// Samples of a frame from which on jobs go side by side. The paths of fewer mostly find room in memory, and what is decoded of them stays.
const SIDE_BY_SIDE: u64 = 512 * 1024;

/// Whether frames of so many pixels, with so many samples a pixel and axis, are large enough for it.
pub fn is_worth((width, height): (u32, u32), samples: u32) -> bool {
    u64::from(width) * u64::from(height) * u64::from(samples).pow(2) >= SIDE_BY_SIDE
}

/// How far the first may be ahead of the last, tiles that their machines are through with. Each decodes further ahead than its machine is, as
/// far as the memory for what waits there reaches.
const LEAD: u64 = 32;

/// How often who waits looks whether all is to stop.
const LOOK: Duration = Duration::from_millis(100);

/// Jobs on their way through a trace.
pub struct Convoy {
    state: Mutex<State>,
    moved: Condvar,
}

struct State {
    /// Where those are that have begun and not ended, by number: tiles that they are through with.
    places: Vec<Option<u64>>,
    /// Threads that no job works in.
    free: usize,
}

impl State {
    /// Whether who is at `place` is too far ahead of the last.
    fn is_ahead(&self, place: u64) -> bool {
        place > self.places.iter().flatten().copied().min().unwrap_or(0) + LEAD
    }
}

/// A job on its way; it leaves the convoy where this ends.
pub struct Member<'a> {
    convoy: &'a Convoy,
    number: usize,
    /// It may work: one of the threads is its.
    works: Cell<bool>,
}

impl Convoy {
    /// So many jobs, none of which has begun. No more of them work at a time than there are `threads`.
    pub fn new(members: usize, threads: usize) -> Self {
        Self { state: Mutex::new(State { places: vec![None; members], free: threads }), moved: Condvar::new() }
    }

    /// Job `number` begins, once a thread is free. Nobody waits for those who have not asked to.
    pub fn join(&self, number: usize, stop: &Stop) -> Member<'_> {
        let member = Member { convoy: self, number, works: Cell::new(false) };
        member.is_at(0, stop);
        member
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Member<'_> {
    /// It is through with so many tiles. Waits until the last one is near enough and a thread is free, or all is to stop.
    pub fn is_at(&self, tiles: u64, stop: &Stop) {
        let mut state = self.convoy.lock();
        // Who passes a frame again has been there.
        let place = state.places[self.number].unwrap_or(0).max(tiles);
        state.places[self.number] = Some(place);
        if state.is_ahead(place) && self.works.take() {
            state.free += 1;
        }
        self.convoy.moved.notify_all();
        while (state.is_ahead(place) || !self.works.get() && state.free == 0) && !stop.is_requested() {
            let waited = self.convoy.moved.wait_timeout(state, LOOK);
            (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        }
        if !self.works.get() && state.free > 0 {
            state.free -= 1;
            self.works.set(true);
        }
    }
}

impl Drop for Member<'_> {
    fn drop(&mut self) {
        let mut state = self.convoy.lock();
        state.places[self.number] = None;
        state.free += usize::from(self.works.get());
        self.convoy.moved.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

    use super::*;

    /// With as many threads as jobs, and with fewer.
    #[test]
    fn nobody_is_far_ahead_of_the_last_and_no_more_work_than_there_are_threads() {
        for threads in [3, 2, 1] {
            let (convoy, stop) = (Convoy::new(3, threads), Stop::never());
            let (slow, working) = (AtomicU64::new(0), AtomicUsize::new(0));
            let begun = Barrier::new(3);
            let run = |number: usize| {
                convoy.lock().places[number] = Some(0);
                begun.wait();
                let member = convoy.join(number, &stop);
                for tiles in 1..=200 {
                    assert!(working.fetch_add(1, Ordering::SeqCst) < threads);
                    if number == 0 {
                        slow.store(tiles, Ordering::SeqCst);
                    } else {
                        assert!(tiles <= slow.load(Ordering::SeqCst) + LEAD + 1, "{tiles}");
                    }
                    working.fetch_sub(1, Ordering::SeqCst);
                    member.is_at(tiles, &stop);
                }
            };
            std::thread::scope(|scope| {
                (0..3).for_each(|number| {
                    drop(scope.spawn({
                        let run = &run;
                        move || run(number)
                    }))
                })
            });
            assert_eq!(convoy.lock().free, threads);
        }
    }

    #[test]
    fn nobody_waits_for_who_has_left_or_not_begun() {
        let (convoy, stop) = (Convoy::new(3, 3), Stop::never());
        let first = convoy.join(0, &stop);
        first.is_at(1000, &stop);
        let second = convoy.join(1, &stop);
        drop(second);
        first.is_at(2000, &stop);
        // Nor when all is to stop.
        let _behind = convoy.join(2, &stop);
        stop.request();
        first.is_at(3000, &stop);
    }
}
