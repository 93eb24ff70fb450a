//! The memory behind the L1s as one trait.

use super::request::{Lookup, Request, Response};
use super::stats::MemoryStats;
use crate::component::{Component, Tick};
use crate::time::TiCycle;

/// What the T&I unit and the SRP see of the memory system.
///
/// A tick runs up to and including its cycle and appends what arrived by then, in the order of arrival. Its next event is the
/// next cycle at which a tick can bring a response or free a queue.
pub trait Memory: Component<Report = MemoryStats> + for<'a> Tick<&'a mut Vec<Response>> {
    /// Whether units tell it what they look for: a constant, so that it costs nothing where nobody listens. Those that tell are the
    /// traversal and intersection units of fixed function ([`tells_lookups`](crate::ports::tells_lookups)); SRPs, processors and
    /// units that gather rays tell nothing. What any of them misses is a request.
    const LISTENS: bool = false;

    /// Whether it is of no use in front of a machine that tells nothing: it is refused there.
    fn wants_lookups(&self) -> bool {
        Self::LISTENS
    }

    /// A unit that tells looks for something at cycle `now`; called if this memory listens.
    fn looked_for(&mut self, _now: TiCycle, _lookup: Lookup) {}

    /// Takes a request at cycle `now`, or refuses it because a queue is full: then nothing changed, ask again later.
    /// Of `Route::Cached` and `Route::Read` each accepted request gets exactly one response, at a later cycle.
    fn request(&mut self, now: TiCycle, request: Request) -> bool;

    /// Whether nothing is under way: no request, and no write that still has to reach DRAM.
    fn is_idle(&self, now: TiCycle) -> bool {
        self.next_event(now).is_never()
    }

    /// Bytes that crossed the DRAM's data bus so far, by commands given.
    fn bytes_moved(&self) -> u64 {
        0
    }

    /// Lines that left the L2 since the last call, to be dropped from the L1s (inclusive L2 only).
    fn take_evicted(&mut self) -> Vec<u64> {
        Vec::new()
    }
}
