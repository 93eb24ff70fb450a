//! Frames of which not every cycle is simulated: what is asked for, and what is known of the figures.
//!
//! `mode` says how much, `estimate` how far the figures may be off, `whole` why there is no estimate after all.

mod estimate;
mod mode;
mod whole;

pub use estimate::{Estimate, FLOOR, Floors, Replicate, WHY_WHOLE, half_width, replicates_of_ratio};
pub(crate) use estimate::{READS, weight_of_pair};
pub use mode::{Detail, Share};
pub use whole::{WholeFrames, WhyWhole};
