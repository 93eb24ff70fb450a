//! Shapes for the built-in scenes: parts made of grids, put together by a builder.
//!
//! Everything is computed in `f64` with `libm` and rounded once, so that the built-in scenes are
//! the same bytes on every machine.

pub mod backdrop;
pub mod block;
pub mod builder;
pub mod curve;
pub mod lathe;
pub mod loft;
pub mod paint;
pub mod part;
pub mod patch;
pub mod profile;
pub mod rounded;
pub mod scatter;
pub mod slab;
pub mod sweep;
pub mod tube;
pub mod vessel;

pub use builder::SceneBuilder;
pub use part::Part;
