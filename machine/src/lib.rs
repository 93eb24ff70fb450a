//! The machine model: recorded rays in, cycles and joules out.
//!
//! ```text
//! policy -> work (tiles, waves, rays) -> system: cores { SRP <-> T&I unit } -> L2 -> LPDDR4 -> counters -> energy -> stats
//! ```
//!
//! Time is an integer number of cycles of the T&I clock; what runs in another clock keeps its own integer count and meets the
//! T&I clock through ratios of whole megahertz. No float decides an event. `MODEL.md` beside the crate states every rule.

pub mod config;
pub mod counters;
pub mod energy;
pub mod error;
pub mod link;
pub mod memory;
pub mod probes;
pub mod srp;
pub mod stats;
pub mod system;
#[cfg(test)]
pub(crate) mod test_config;
pub mod ti;
pub mod timeline;
pub mod work;

pub use error::{MachineError, Result};
