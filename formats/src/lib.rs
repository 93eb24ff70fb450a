//! The Rayreel trace file (`.rtrace`): what it holds, how it is coded, and how rays are rebuilt from it.
//!
//! This crate knows nothing of tracing or of hardware. `FORMAT.md` beside it specifies every byte.

pub mod container;
pub mod error;
pub mod limits;

pub use error::{Error, Result};
pub use limits::Limits;
