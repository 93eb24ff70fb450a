//! The replay of frames: tiles in, picture and counts out.
//!
//! Tiles are read and decided in parallel, but everything is put together in tile order, and floats are never summed across
//! threads: the result is the same for any number of them.

mod band;
mod caches;
mod canvas;
mod replayer;
mod several;
pub mod states;
pub mod traced;

pub use canvas::FrameReplay;
pub(crate) use replayer::PassedFrame;
pub use replayer::{Options, Replayer};
pub use several::Replayers;
