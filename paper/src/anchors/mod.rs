//! Anchors: figures that publications and estimates put between bounds, measured on this model.
//!
//! ```text
//! list (bounds, sources, how a value is made, why it lies outside) -> run (each replay once) -> Measured -> text, JSON
//! ```
//!
//! The list is data. A row is measured on the first frame of the paper's five scenes, traced in memory. A value outside its bounds has
//! an explanation, written beside the anchor after a look at the counters; one without fails.

mod anchor;
mod list;
mod measured;
mod of;
mod run;
mod text;

pub use anchor::SCENES;
pub use measured::{Measured, machines, measure};
pub use text::text;

/// Picture size by default, pixels.
pub const SIZE: (u32, u32) = (128, 64);
