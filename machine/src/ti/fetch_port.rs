//! The way of a unit to its data: the input buffer with its L1, and the events by which refused lookups are tried again.
//!
//! Traversal and intersection units use it alike: [`FetchPort::fetch`] asks for the data of the operation in a slot. The
//! operation comes back as a [`Candidate`] that the unit issues: at once, or from [`FetchPort::next_filled`] when its lines have
//! arrived, or from [`FetchPort::retry_lookup`] when a lookup that was refused is done.

use super::context::EventContext;
use super::input_buffer::{InputBuffer, InputBufferCounters, Outcome};
use super::stage::Candidate;
use super::wheel::{Event, EventKind};
use crate::memory::{CacheCounters, Memory, Port, Tags};
use crate::time::TiCycle;
use crate::work::layout::{Lines, Region};

/// A line that arrived, and who still has to be told.
#[derive(Clone, Copy, Debug)]
pub struct Fill {
    now: TiCycle,
    line: u64,
    waiters: u128,
}

/// The way of a unit to its data.
#[derive(Debug)]
pub struct FetchPort {
    buffer: InputBuffer,
    /// The unit, and its event for a lookup that is tried again.
    unit: u8,
    retry: EventKind,
}

impl FetchPort {
    /// The port of unit `unit` that fetches through `buffer`; `retry` is the unit's event for a refused lookup.
    pub fn new(buffer: InputBuffer, unit: u8, retry: EventKind) -> Self {
        Self { buffer, unit, retry }
    }

    /// The port of the L1.
    pub fn l1_port(&self) -> Port {
        self.buffer.l1().port()
    }

    /// The operation in `slot` needs `lines`.
    #[inline(always)]
    pub fn fetch<T, M: Memory>(
        &mut self,
        slot: u8,
        lines: Lines,
        region: Region,
        context: &mut EventContext<'_, T, M>,
    ) -> Option<Candidate> {
        let outcome = self.buffer.push(context.now, slot, lines, region, context.memory);
        self.route(slot, outcome, context)
    }

    /// The operation in `slot` needs the same lines again.
    #[inline]
    pub fn fetch_again<T, M: Memory>(&mut self, slot: u8, context: &mut EventContext<'_, T, M>) -> Option<Candidate> {
        let outcome = self.buffer.push_again(context.now, slot, context.memory);
        self.route(slot, outcome, context)
    }

    #[inline(always)]
    fn route<T, M>(&self, slot: u8, outcome: Outcome, context: &mut EventContext<'_, T, M>) -> Option<Candidate> {
        match outcome {
            Outcome::Ready(op) => return Some(op),
            Outcome::HeldUp => context.wheel.push(context.now + 1, Event::new(self.retry, self.unit, slot)),
            Outcome::Waits => {}
        }
        None
    }

    /// Tries a refused lookup again; gives the operation with its slot if its data are in sight. To be followed by
    /// [`FetchPort::book_retry`] when the operation is issued.
    pub fn retry_lookup<T, M: Memory>(&mut self, context: &mut EventContext<'_, T, M>) -> Option<(u8, Candidate)> {
        match self.buffer.retry_lookup(context.now, context.memory)? {
            (slot, Outcome::Ready(op)) => Some((slot, op)),
            _ => None,
        }
    }

    /// Books `event` anew while a lookup is held up: a queue of the memory may have room by the next cycle.
    pub fn book_retry<T, M>(&self, event: Event, context: &mut EventContext<'_, T, M>) {
        if self.buffer.is_held_up() {
            context.wheel.push(context.now + 1, event);
        }
    }

    /// A line arrived at cycle `now`.
    #[inline]
    pub fn fill(&mut self, now: TiCycle, line: u64) -> Fill {
        Fill { now, line, waiters: self.buffer.fill(line) }
    }

    /// The next operation that the line was the last one for, with its slot.
    #[inline]
    pub fn next_filled(&mut self, fill: &mut Fill) -> Option<(u8, Candidate)> {
        while fill.waiters != 0 {
            let slot = fill.waiters.trailing_zeros() as u8;
            fill.waiters &= fill.waiters - 1;
            if let Some(op) = self.buffer.filled(fill.now, slot, fill.line) {
                return Some((slot, op));
            }
        }
        None
    }

    /// What the L1 holds.
    pub fn tags(&self) -> &Tags {
        self.buffer.l1().tags()
    }

    /// Fills the empty L1.
    pub fn warm(&mut self, tags: &Tags) {
        self.buffer.l1_mut().warm(tags);
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.buffer.l1_mut().invalidate(line);
    }

    /// What the buffer did.
    pub fn counters(&self) -> InputBufferCounters {
        self.buffer.counters
    }

    /// What the L1 did.
    pub fn l1_counters(&self) -> CacheCounters {
        *self.buffer.l1().counters()
    }
}
