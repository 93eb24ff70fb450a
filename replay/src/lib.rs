//! Replays a recorded trace through sampling policies: which samples would have been traced, how many rays that saves, and
//! what the picture looks like then.
//!
//! Everything here is a pure function of the trace and the policy: no wall clock, no hash order, no thread count and no
//! floating-point function of the platform enters a result. The crate knows the trace format and nothing of scenes, tracing
//! or BVH building: a replay runs on a machine that has only the trace. `POLICIES.md` beside it states the policies exactly.
//!
//! ```text
//! TileSource -> frame (bands of tiles) -> policy (trace or interpolate) -> image, counts -> report
//! ```

pub mod error;
pub mod frame;
pub mod image;
pub mod policy;
pub mod simulate;
pub mod source;
pub mod stop;
pub mod work;

pub use error::{ReplayError, Result};
pub use frame::{FrameReplay, Options, Replay, Replayer, replay, replay_each};
pub use policy::{NamedPolicy, Policy};
pub use source::{PathSource, TileSource};
pub use stop::Stop;
