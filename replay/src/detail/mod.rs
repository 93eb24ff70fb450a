//! Frames of which not every cycle is simulated: what is asked for, and what is known of the figures.
//!
//! `mode` says how much, `estimate` how far the figures may be off.

mod estimate;
mod mode;

pub(crate) use estimate::weight_of_pair;
pub use estimate::{Estimate, FLOOR, Floors, Replicate, WHY_WHOLE, half_width};
pub use mode::{Detail, Share};
