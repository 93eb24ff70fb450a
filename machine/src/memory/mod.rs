//! Caches and DRAM: a first-level cache for each unit that reads, and everything behind them as one [`Memory`].
//!
//! ```text
//! L1Cache (one a unit) -> MemorySystem { banks of the L2 -> clock crossing -> DRAM channels }
//! ```

mod dram;
mod ideal;
mod interface;
mod l1;
mod l2;
mod recording;
mod request;
mod stats;
mod system;
mod tags;
mod traffic;

pub(crate) use dram::AddressMap;
pub use dram::ChannelCounters;
pub use ideal::IdealMemory;
pub use interface::Memory;
pub use l1::{Access, CacheCounters, L1Cache};
pub use l2::L2Counters;
pub use recording::{Issued, Recording};
pub use request::{Lookup, Port, Request, Response, Route};
pub use stats::MemoryStats;
pub use system::MemorySystem;
pub(crate) use tags::Tags;
pub use traffic::Traffic;
