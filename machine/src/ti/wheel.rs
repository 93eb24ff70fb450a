//! The events of a T&I unit in order of time: a ring of cycles, each with what happens in it.
//!
//! Nothing in a unit lies further ahead than its deepest pipeline and the operations that can be booked before it, so a ring of
//! fixed length holds all events; those of one cycle happen in the order in which they were booked.

use crate::memory::Cycle;

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
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
    LookUpAgain,
    /// An intersection unit accepts the next task.
    Task,
    /// The next triangle of a task comes to the input buffer.
    NextTriangle,
    /// A triangle leaves the pipeline without work.
    TriangleBypass,
    /// The last triangle of a task leaves the pipeline.
    LastTriangle,
    /// A triangle's lookup that was refused is tried again.
    TriangleLookUpAgain,
}

/// An event of one unit, and the place there that it is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// What happens.
    pub kind: Kind,
    /// Traversal or intersection unit.
    pub unit: u8,
    /// Place in the unit.
    pub slot: u8,
    /// See [`Kind`].
    pub extra: u8,
}

impl Event {
    /// An event without extra.
    #[inline]
    pub fn new(kind: Kind, unit: u8, slot: u8) -> Self {
        Self { kind, unit, slot, extra: 0 }
    }
}

/// See the module.
#[derive(Debug)]
pub struct Wheel {
    /// Per cycle its events.
    slots: Vec<Vec<Event>>,
    /// One bit a slot: it holds events.
    used: Vec<u64>,
    /// Cycles before this one are over.
    now: Cycle,
    mask: Cycle,
}

impl Wheel {
    /// A wheel for events up to `reach` cycles ahead.
    pub fn new(reach: u32) -> Self {
        let slots = (reach as usize + 2).next_power_of_two().max(64);
        Self { slots: vec![Vec::new(); slots], used: vec![0; slots / 64], now: 0, mask: slots as Cycle - 1 }
    }

    /// It is cycle `now`: no event lies before it.
    #[inline]
    pub fn advance(&mut self, now: Cycle) {
        debug_assert!(self.next_event() >= now, "an event was passed over");
        self.now = self.now.max(now);
    }

    /// Books an event at cycle `at`.
    #[inline]
    pub fn push(&mut self, at: Cycle, event: Event) {
        debug_assert!(at >= self.now && at - self.now <= self.mask, "an event beyond the wheel");
        let slot = (at & self.mask) as usize;
        self.used[slot / 64] |= 1 << (slot % 64);
        self.slots[slot].push(event);
    }

    /// The next events of cycle `now`, those of earlier cycles having been taken; false when there are none. `events` is
    /// emptied first. To be called until it is false: events may be booked for the same cycle meanwhile.
    #[inline]
    pub fn take(&mut self, now: Cycle, events: &mut Vec<Event>) -> bool {
        self.advance(now);
        events.clear();
        let slot = (now & self.mask) as usize;
        std::mem::swap(&mut self.slots[slot], events);
        self.used[slot / 64] &= !(1 << (slot % 64));
        !events.is_empty()
    }

    /// The cycle of the next event; never, if there is none.
    #[inline]
    pub fn next_event(&self) -> Cycle {
        // Mostly it is this cycle or the next.
        for at in [self.now, self.now + 1] {
            if !self.slots[(at & self.mask) as usize].is_empty() {
                return at;
            }
        }
        let first = (self.now & self.mask) as usize;
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
                let slot = (w * 64) as Cycle + Cycle::from(bits.trailing_zeros());
                return self.now + (slot.wrapping_sub(first as Cycle) & self.mask);
            }
        }
        Cycle::MAX
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(slot: u8) -> Event {
        Event::new(Kind::Setup, 0, slot)
    }

    #[test]
    fn events_come_in_order_of_time() {
        let mut wheel = Wheel::new(100);
        assert_eq!(wheel.next_event(), Cycle::MAX);
        let (mut now, mut seen) = (0, Vec::new());
        for (i, distance) in [3, 100, 3, 64, 1, 127].into_iter().enumerate() {
            wheel.push(distance, at(i as u8));
        }
        let mut events = Vec::new();
        while wheel.next_event() != Cycle::MAX {
            now = wheel.next_event();
            assert!(wheel.take(now, &mut events));
            seen.extend(events.iter().map(|e| (now, e.slot)));
            if now == 64 {
                wheel.push(now + 127, at(9));
            }
        }
        assert_eq!(seen, [(1, 4), (3, 0), (3, 2), (64, 3), (100, 1), (127, 5), (191, 9)]);
        assert_eq!(now, 191);
    }

    #[test]
    fn an_event_of_the_same_cycle_is_not_lost() {
        let (mut wheel, mut events) = (Wheel::new(10), Vec::new());
        wheel.push(5, at(1));
        assert!(wheel.take(5, &mut events));
        wheel.push(5, at(2));
        assert!(wheel.take(5, &mut events));
        assert_eq!(events, [at(2)]);
        assert!(!wheel.take(5, &mut events));
        assert_eq!(wheel.next_event(), Cycle::MAX);
    }
}
