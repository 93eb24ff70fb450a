//! The machine model: rays that were recorded once go in, cycles and joules come out.
//!
//! ```text
//! tiles of work -> System: cores { SRP <-> T&I unit } -> L2 -> LPDDR4 -> Stats -> EnergyReport
//! ```
//!
//! A machine is a [`MachineConfig`], from a preset or a file ([`NamedMachine`]). Its input is [`TileWork`]: rays with the
//! operations that traversal does, in rounds. It decides when work is done, never what, and knows neither traces nor policies nor
//! pictures; `rayreel-replay` makes the work of a recorded frame. `MODEL.md` beside the crate states every rule.
//!
//! Time is whole cycles of each unit's clock ([`time`]) and energy whole femtojoules; no float decides an event.
//!
//! ```
//! use rayreel_machine::work::{PolicyReads, synthetic::{Random, balanced_topology, random_tile}};
//! use rayreel_machine::{FrameShape, NamedMachine, run_tiles};
//!
//! # fn main() -> rayreel_machine::Result<()> {
//! let machine = NamedMachine::load("sgrt-ti2", &["gpu.cores=2".to_owned()])?;
//! let (tree, mut random) = (balanced_topology(8, 2), Random(1));
//! let tiles = (0..4).map(|tile| random_tile(&tree, tile, 64, 2, &mut random));
//! let shape = FrameShape { width_pixels: 128, samples_per_axis: 1, pixel_bytes: 4, tile_bytes: 0, tile_samples: 1024, policy: PolicyReads::PAPER };
//! let (stats, energy) = run_tiles(&machine.config, &tree, shape, tiles)?;
//! assert!(stats.cycles > 0 && stats.rays() >= 4 * 64 && energy.gpu_fj() > 0);
//! # Ok(())
//! # }
//! ```

pub mod area;
pub mod component;
pub mod config;
pub mod counters;
pub mod energy;
mod error;
pub mod functional;
pub mod link;
pub mod memory;
pub mod ports;
pub mod probes;
mod run;
pub mod srp;
pub mod stats;
pub mod system;
#[cfg(test)]
pub(crate) mod test_config;
pub mod ti;
pub mod time;
pub mod timeline;
pub mod traversal;
pub mod work;

pub use area::AreaReport;
pub use config::{MachineConfig, NamedMachine};
pub use energy::EnergyReport;
pub use error::{MachineError, Result};
pub use run::run_tiles;
pub use srp::FrameShape;
pub use stats::Stats;
pub use system::System;
pub use work::TileWork;
pub use work::topology::Topology;
