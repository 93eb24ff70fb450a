//! A machine as numbers: plain structs, one a block, each value in the unit that its name ends with.
//!
//! Each field is declared once, with what it takes, its meaning and its unit; keys, checks and the tables of `MODEL.md` come from
//! that. Values come from presets (`presets/*.toml`), files and overrides; each keeps its class and source. The simulator sees
//! only these structs, already checked.

mod area;
mod cache;
mod check;
mod dram;
mod energy;
mod gpu;
mod layout;
mod load;
mod memories;
mod prices;
mod processor;
mod rules;
pub mod schema;
mod srp;
mod ti;
mod whole;
mod widths;

pub use rayreel_settings::{Ancestor, Bytes, Class, Picojoules, Sourced, units};

pub use area::Area;
pub use cache::{L1, L2, Replacement};
pub use dram::{Dram, PagePolicy};
pub use energy::Energy;
pub use gpu::{GeometryBuffer, Gpu, Interface, PrimaryVisibility, TileDispatch};
pub use layout::{Framebuffer, LayoutSizes, Raster};
pub use load::NamedMachine;
pub use processor::{Block, Code, KernelMix, Processor, Units};
pub use schema::{MACHINES, PRESETS};
pub use srp::{Divergence, Kernel, Kernels, MixOps, PolicyKernel, SampleFields, Srp, TestOps};
pub use ti::{MissHandling, Pipeline, Ti};
pub use whole::MachineConfig;
pub use widths::TrvWidth;
