//! What happens when in the processors of a core.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::time::{TiCycle, When};

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum What {
    /// The block of this warp is over.
    Done(u8),
    /// Refused lookups are tried again.
    Retry,
}

/// Something that happens in a processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Event {
    /// The processor.
    pub processor: u8,
    /// What happens.
    pub what: What,
}

/// Events by cycle; those of a cycle in the order in which they were booked.
#[derive(Debug, Default)]
pub struct Events {
    heap: BinaryHeap<Reverse<(TiCycle, u64, Event)>>,
    booked: u64,
}

impl Events {
    /// Books an event.
    #[inline]
    pub fn push(&mut self, at: TiCycle, event: Event) {
        self.heap.push(Reverse((at, self.booked, event)));
        self.booked += 1;
    }

    /// The next event at or before `now`.
    #[inline]
    pub fn take(&mut self, now: TiCycle) -> Option<Event> {
        let &Reverse((at, _, event)) = self.heap.peek()?;
        if at > now {
            return None;
        }
        self.heap.pop();
        Some(event)
    }

    /// When the next event is.
    #[inline]
    pub fn next(&self) -> When {
        When::from(self.heap.peek().map(|Reverse((at, ..))| *at))
    }
}
