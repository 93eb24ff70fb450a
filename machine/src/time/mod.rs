//! Times: a cycle of a clock, when something happens next, and the way from clock to clock.
//!
//! A cycle of one clock is not a cycle of another, so each clock has a type: they cannot be compared or mixed, only converted
//! ([`Crossing`]). A distance between two cycles is a plain `u64` of that clock. All of it is a `u64` at run time.

mod crossing;
mod cycle;
mod when;

pub use crossing::Crossing;
pub use cycle::{ClockCycle, DramCycle, SrpCycle, TiCycle};
pub use when::When;
