//! What the tests of several crates share. Never part of a build: members name it in `[dev-dependencies]` only.
//!
//! [`Random`] knows no other member. With the feature `frames` there are also `synthetic` frames, a slow second
//! implementation of the policies (`reference`, `cells` and `past`), and a source that catches who reads what was not traced (`poison`).

mod random;

#[cfg(feature = "frames")]
pub mod cells;
#[cfg(feature = "frames")]
pub mod golden;
#[cfg(feature = "frames")]
pub mod past;
#[cfg(feature = "frames")]
pub mod poison;
#[cfg(feature = "frames")]
mod policies;
#[cfg(feature = "frames")]
mod recorded;
#[cfg(feature = "frames")]
pub mod reference;
#[cfg(feature = "frames")]
pub mod rules;
#[cfg(feature = "frames")]
pub mod same;
#[cfg(feature = "frames")]
mod shade;
#[cfg(feature = "frames")]
pub mod switches;
#[cfg(feature = "frames")]
pub mod synthetic;
#[cfg(feature = "frames")]
mod trees;

#[cfg(feature = "frames")]
pub use policies::{adaptive, policy, preset};
pub use random::Random;
