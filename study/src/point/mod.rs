//! Points: what is replayed under what, the keys of its results, the one loop that computes them, and where they are kept.
//!
//! ```text
//! Point --key--> Store: is it there?  --no--> PointTask (FrameLoop over its frames) --> Row, Details --> Store
//! ```

pub mod columns;
pub mod compute;
pub mod convoy;
pub mod details;
pub mod estimates;
pub mod figures;
pub mod key;
pub mod known;
pub mod pictures;
pub mod row;
pub mod segment;
pub mod store;
pub mod task;
pub mod tile_cache;
pub mod version;
pub mod wanted;
