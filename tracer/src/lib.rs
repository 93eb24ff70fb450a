//! The functional ray tracer of Rayreel: builds the BVH, traces Whitted ray trees, captures them into a trace file and
//! verifies a trace from the trace alone.
//!
//! Everything that decides where a ray goes is in `rayreel-formats`; this crate adds the scene: shading, textures, and the
//! traversal loop that records paths.

pub mod accel;
pub mod capture;
pub mod convert;
pub mod shade;
pub mod texture;
pub mod trace;
pub mod traverse;
pub mod verify;

pub use accel::build;
pub use trace::{Settings, Tracer};
