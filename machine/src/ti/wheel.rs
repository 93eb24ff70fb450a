//! The events of a T&I unit in order of time: a ring of cycles, each with what happens in it.
//!
//! Nothing in a unit lies further ahead than its deepest pipeline and the operations that can be booked before it, so a ring of
//! fixed length holds all events; those of one cycle happen in the order in which they were booked.

use crate::time::{ClockCycle, TiCycle, When};

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum EventKind {
    /// A ray's setup is complete.
    Setup,
    /// An operation leaves the inner-node (or only) pipeline.
    Inner,
    /// The same without work.
    InnerBypass,
    /// An operation leaves the leaf pipeline; `extra` is the intersection unit.
    Leaf,
    /// An operation leaves the stack pipeline.
    Stack,
    /// The result of a leaf task arrives.
    Returned,
    /// A lookup that was refused is tried again.
    RetryLookup,
    /// An intersection unit accepts the next task.
    Task,
    /// The next triangle of a task comes to the input buffer.
    NextTriangle,
    /// A triangle leaves the pipeline without work.
    TriangleBypass,
    /// The last triangle of a task leaves the pipeline.
    LastTriangle,
    /// A triangle's lookup that was refused is tried again.
    RetryTriangleLookup,
}

/// An event of one unit, and the place there that it is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// What happens.
    pub kind: EventKind,
    /// Traversal or intersection unit.
    pub unit: u8,
    /// Place in the unit.
    pub slot: u8,
    /// The intersection unit of [`EventKind::Leaf`].
    pub extra: u8,
}

impl Event {
    /// An event without extra.
    #[inline]
    pub fn new(kind: EventKind, unit: u8, slot: u8) -> Self {
        Self { kind, unit, slot, extra: 0 }
    }
}

/// No place in the pool.
const NONE: u16 = u16::MAX;

/// An event, and the place of the one that follows it in its cycle; the last one is followed by the first.
#[derive(Clone, Copy, Debug)]
struct Booked {
    event: Event,
    next: u16,
}

/// The events of a unit, a ring of cycles. Events lie in a pool whose places are used again at once, and a cycle is two bytes: a
/// unit comes through its whole ring again and again, and that should fit a cache of the host.
#[derive(Clone, Debug)]
pub struct Wheel {
    /// Per cycle its last event, as a place in the pool.
    last: Vec<u16>,
    pool: Vec<Booked>,
    /// The first of the places that are free; each is followed by the next of them.
    free: u16,
    /// One bit a cycle: it has events.
    used: Vec<u64>,
    /// Cycles before this one are over.
    now: TiCycle,
    mask: u64,
}

impl Wheel {
    /// A wheel for events up to `reach` cycles ahead.
    pub fn new(reach: u32) -> Self {
        let cycles = (reach as usize + 2).next_power_of_two().max(64);
        Self {
            last: vec![NONE; cycles],
            pool: Vec::new(),
            free: NONE,
            used: vec![0; cycles / 64],
            now: TiCycle::START,
            mask: cycles as u64 - 1,
        }
    }

    /// The place of a cycle.
    #[inline]
    fn place(&self, at: TiCycle) -> usize {
        (at.0 & self.mask) as usize
    }

    /// It is cycle `now`: no event lies before it.
    #[inline]
    pub fn advance(&mut self, now: TiCycle) {
        debug_assert!(self.next_event() >= When::at(now), "an event was passed over");
        self.now = self.now.max(now);
    }

    /// Books an event at cycle `at`.
    #[inline(always)]
    pub fn push(&mut self, at: TiCycle, event: Event) {
        // It would come a round too early, and nobody would see it.
        assert!(at >= self.now && at - self.now <= self.mask, "an event beyond the wheel");
        if self.free == NONE {
            self.grow();
        }
        let (cycle, new) = (self.place(at), self.free);
        let last = std::mem::replace(&mut self.last[cycle], new);
        let next = if last == NONE {
            self.used[cycle / 64] |= 1 << (cycle % 64);
            new
        } else {
            std::mem::replace(&mut self.pool[last as usize].next, new)
        };
        self.free = std::mem::replace(&mut self.pool[new as usize], Booked { event, next }).next;
    }

    /// A new place, which is free.
    #[cold]
    fn grow(&mut self) {
        assert!(self.pool.len() < NONE as usize, "a unit has less to do at a time than the pool has places");
        self.free = self.pool.len() as u16;
        self.pool.push(Booked { event: Event::new(EventKind::Setup, 0, 0), next: NONE });
    }

    /// The next event of cycle `now`, if there is one; those of earlier cycles were taken. Events that are booked for the same
    /// cycle meanwhile follow.
    #[inline(always)]
    pub fn take(&mut self, now: TiCycle) -> Option<Event> {
        let cycle = self.place(now);
        let last = self.last[cycle];
        if last == NONE {
            return None;
        }
        let first = self.pool[last as usize].next;
        let taken = &mut self.pool[first as usize];
        let (event, next) = (taken.event, std::mem::replace(&mut taken.next, self.free));
        self.free = first;
        if first == last {
            self.last[cycle] = NONE;
            self.used[cycle / 64] &= !(1 << (cycle % 64));
        } else {
            self.pool[last as usize].next = next;
        }
        Some(event)
    }

    /// The cycle of the next event; never, if there is none.
    #[inline]
    pub fn next_event(&self) -> When {
        let first = self.place(self.now);
        let (word, bit) = (first / 64, first % 64);
        let near = self.used[word] >> bit;
        if near != 0 { When::at(self.now + u64::from(near.trailing_zeros())) } else { self.later_event(word, bit) }
    }

    /// The next event, if it does not lie in the rest of the word of this cycle.
    fn later_event(&self, word: usize, bit: usize) -> When {
        let words = self.used.len();
        // The last word that is looked at is that of this cycle again: what is a round ahead there.
        for ahead in 1..=words {
            let bits = self.used[(word + ahead) % words];
            if bits != 0 {
                return When::at(self.now + (ahead * 64 - bit) as u64 + u64::from(bits.trailing_zeros()));
            }
        }
        When::NEVER
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(slot: u8) -> Event {
        Event::new(EventKind::Setup, 0, slot)
    }

    #[test]
    fn events_come_in_order_of_time() {
        let mut wheel = Wheel::new(100);
        assert!(wheel.next_event().is_never());
        let (mut last, mut seen) = (TiCycle(0), Vec::new());
        for (i, distance) in [3, 100, 3, 64, 1, 127].into_iter().enumerate() {
            wheel.push(TiCycle(distance), at(i as u8));
        }
        while let Some(now) = wheel.next_event().cycle() {
            wheel.advance(now);
            while let Some(event) = wheel.take(now) {
                seen.push((now.0, event.slot));
            }
            if now == 64 {
                wheel.push(now + 127, at(9));
            }
            last = now;
        }
        assert_eq!(seen, [(1, 4), (3, 0), (3, 2), (64, 3), (100, 1), (127, 5), (191, 9)]);
        assert_eq!(last, 191);
    }

    #[test]
    fn an_event_of_the_same_cycle_is_not_lost() {
        let (mut wheel, now) = (Wheel::new(10), TiCycle(5));
        wheel.advance(now);
        wheel.push(now, at(1));
        wheel.push(now, at(2));
        assert_eq!(wheel.take(now), Some(at(1)));
        wheel.push(now, at(3));
        assert_eq!([wheel.take(now), wheel.take(now), wheel.take(now)], [Some(at(2)), Some(at(3)), None]);
        assert!(wheel.next_event().is_never());
        wheel.push(now, at(4));
        assert_eq!((wheel.next_event(), wheel.take(now)), (When::at(now), Some(at(4))));
    }

    #[test]
    fn places_are_used_again() {
        let mut wheel = Wheel::new(100);
        for cycle in (0..1000).map(TiCycle) {
            wheel.advance(cycle);
            assert_eq!(wheel.take(cycle).is_some(), cycle.0 >= 64);
            assert_eq!(wheel.take(cycle), None);
            wheel.push(cycle + 64, at(0));
        }
        assert_eq!(wheel.pool.len(), 64);
    }
}
