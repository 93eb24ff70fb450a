//! Replays a recorded trace through sampling policies: which samples would have been traced, how many rays that saves, what the
//! picture looks like then, and what a machine makes of the rays that are left.
//!
//! ```text
//! TileSource -> Replayer (bands of tiles) -> Sampler (trace or interpolate) -> picture, counts -> quality
//!                                                                          `-> work -> machine -> cycles, joules
//! ```
//!
//! A [`Replayer`] takes the frames of a [`TileSource`], such as a trace, under a [`Policy`] or any other [`SamplePolicy`].
//! [`simulate`] runs what it traced on a machine. `POLICIES.md` states the built-in policies exactly.
//!
//! Everything is a pure function of the trace and the policy: no wall clock, no hash order, no thread count and no
//! floating-point function of the platform enters a result. The crate knows the trace format and nothing of scenes, tracing or
//! BVH building.
//!
//! ```
//! use rayreel_formats::{Limits, trace::Trace};
//! use rayreel_replay::{NamedPolicy, Options, Replayer};
//!
//! let trace = Trace::open("../traces/v1_0_cornell.rtrace".as_ref(), Limits::default())?;
//! let policy = NamedPolicy::load("multirate", &[])?;
//! let frame = Replayer::new(&trace, &policy, Options::default())?.frame(0)?.stats;
//! assert_eq!((frame.counts.rays_traced.total(), frame.counts.rays_full.total()), (4254, 10051));
//! let psnr = frame.quality.and_then(|quality| quality.psnr_db());
//! assert_eq!(psnr.map(|db| (db * 100.0).round()), Some(2709.0), "27.09 dB");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod counts;
pub mod detail;
pub mod error;
pub mod frame;
pub mod image;
pub mod maps;
pub mod policy;
pub mod sequence;
pub mod simulate;
pub mod source;
pub mod stop;
pub mod windows;
mod work;

pub use detail::Detail;
pub use error::{ReplayError, Result};
pub use frame::{FrameReplay, Options, Replayer, Replayers};
pub use policy::{NamedPolicy, Policy, SamplePolicy, Sampler};
pub use sequence::{FrameLoop, Replay, replay};
pub use source::{PathSource, TileSource};
pub use stop::Stop;
