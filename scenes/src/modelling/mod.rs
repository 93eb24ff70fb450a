//! Shapes for the built-in scenes: parts made of grids, put together by a builder.
//!
//! Everything is computed in `f64` with `libm` and rounded once, so that the built-in scenes are
//! the same bytes on every machine. What tests build their scenes from is public, the rest is not.

pub(crate) mod backdrop;
pub mod block;
pub mod builder;
pub(crate) mod curve;
pub mod lathe;
pub(crate) mod loft;
pub(crate) mod paint;
pub mod part;
pub(crate) mod patch;
pub mod profile;
pub(crate) mod rounded;
pub(crate) mod scatter;
pub(crate) mod slab;
pub(crate) mod sweep;
pub(crate) mod tube;
pub mod vessel;

pub use builder::SceneBuilder;
pub use part::Part;
