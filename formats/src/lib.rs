//! The Rayreel trace file (`.rtrace`): what it holds, how it is coded, and how rays are rebuilt from it.
//!
//! This crate knows nothing of tracing or of hardware. `FORMAT.md` beside it specifies every byte.

pub mod bvh;
pub mod columns;
pub mod container;
pub mod durable;
pub mod error;
pub mod half;
pub mod intersect;
pub mod limits;
pub mod math;
pub mod oct;
pub mod payload;
pub mod rays;
pub mod scene;
pub mod tile;
pub mod trace;

pub use error::{Error, Result};
pub use limits::Limits;
