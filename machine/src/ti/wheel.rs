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

/// The events of a unit, a ring of cycles.
#[derive(Debug)]
pub struct Wheel {
    /// Per cycle its events.
    slots: Vec<Vec<Event>>,
    /// One bit a slot: it holds events.
    used: Vec<u64>,
    /// Cycles before this one are over.
    now: TiCycle,
    mask: u64,
}

impl Wheel {
    /// A wheel for events up to `reach` cycles ahead.
    pub fn new(reach: u32) -> Self {
        let slots = (reach as usize + 2).next_power_of_two().max(64);
        Self { slots: vec![Vec::new(); slots], used: vec![0; slots / 64], now: TiCycle::START, mask: slots as u64 - 1 }
    }

    /// The slot of a cycle.
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
    #[inline]
    pub fn push(&mut self, at: TiCycle, event: Event) {
        debug_assert!(at >= self.now && at - self.now <= self.mask, "an event beyond the wheel");
        let slot = self.place(at);
        self.used[slot / 64] |= 1 << (slot % 64);
        self.slots[slot].push(event);
    }

    /// The next events of cycle `now`, those of earlier cycles having been taken; false when there are none. `events` is
    /// emptied first. To be called until it is false: events may be booked for the same cycle meanwhile.
    #[inline]
    pub fn take(&mut self, now: TiCycle, events: &mut Vec<Event>) -> bool {
        self.advance(now);
        events.clear();
        let slot = self.place(now);
        std::mem::swap(&mut self.slots[slot], events);
        self.used[slot / 64] &= !(1 << (slot % 64));
        !events.is_empty()
    }

    /// The cycle of the next event; never, if there is none.
    #[inline]
    pub fn next_event(&self) -> When {
        // Mostly it is this cycle or the next.
        for at in [self.now, self.now + 1] {
            if !self.slots[self.place(at)].is_empty() {
                return When::at(at);
            }
        }
        let first = self.place(self.now);
        let words = self.used.len();
        let (word, bit) = (first / 64, first % 64);
        // The word of the current slot is looked at twice: its later slots first, its earlier ones, a round ahead, last.
        for i in 0..=words {
            let w = (word + i) % words;
            let mask = match i {
                0 => !0 << bit,
                _ if i == words => !(!0 << bit),
                _ => !0,
            };
            let bits = self.used[w] & mask;
            if bits != 0 {
                let slot = (w * 64) as u64 + u64::from(bits.trailing_zeros());
                return When::at(self.now + (slot.wrapping_sub(first as u64) & self.mask));
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
        let mut events = Vec::new();
        while let Some(now) = wheel.next_event().cycle() {
            assert!(wheel.take(now, &mut events));
            seen.extend(events.iter().map(|e| (now.0, e.slot)));
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
        let (mut wheel, mut events, now) = (Wheel::new(10), Vec::new(), TiCycle(5));
        wheel.push(now, at(1));
        assert!(wheel.take(now, &mut events));
        wheel.push(now, at(2));
        assert!(wheel.take(now, &mut events));
        assert_eq!(events, [at(2)]);
        assert!(!wheel.take(now, &mut events));
        assert!(wheel.next_event().is_never());
    }
}
