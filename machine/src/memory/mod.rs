//! Caches and DRAM: a first-level cache for each unit that reads, and everything behind them as one [`Memory`].
//!
//! ```text
//! L1Cache (one a unit) -> MemorySystem { banks of the L2 -> clock crossing -> DRAM channels }
//! ```

pub mod crossing;
pub mod dram;
pub mod ideal;
pub mod l1;
pub mod l2;
pub mod system;
pub mod tags;

pub use crossing::Crossing;
pub use ideal::IdealMemory;
pub use l1::{Access, CacheCounters, L1Cache};
pub use system::{MemorySystem, Traffic};

use crate::work::layout::Region;

/// A time in cycles of the T&I clock, or of the clock that the context names.
pub type Cycle = u64;

/// A port of the memory system: one for each L1 and each engine that reads or writes memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Port(pub u16);

/// How a request travels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// A read through the L2.
    Cached,
    /// A read of DRAM past the L2.
    Read,
    /// A write to DRAM past the L2. Nobody waits for it.
    Write,
}

/// A request for one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Who asks.
    pub port: Port,
    /// Line number: address / line size.
    pub line: u64,
    /// What for.
    pub region: Region,
    /// Way.
    pub route: Route,
}

/// A line that arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Response {
    /// Who asked.
    pub port: Port,
    /// Line number.
    pub line: u64,
}

/// What the T&I unit and the SRP see of the memory system. Time never runs backwards from call to call.
pub trait Memory {
    /// Takes a request at cycle `now`, or refuses it because a queue is full: then nothing changed, ask again later.
    /// Of [`Route::Cached`] and [`Route::Read`] each accepted request gets exactly one response, at a later cycle.
    fn request(&mut self, now: Cycle, request: Request) -> bool;

    /// Runs up to and including cycle `now` and appends what arrived by then, in the order of arrival.
    fn tick(&mut self, now: Cycle, arrived: &mut Vec<Response>);

    /// The next cycle at which `tick` can bring a response or free a queue; `None` if nothing is under way.
    fn next_event(&self) -> Option<Cycle>;

    /// Whether nothing is under way: no request, and no write that still has to reach DRAM.
    fn is_idle(&self) -> bool {
        self.next_event().is_none()
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
