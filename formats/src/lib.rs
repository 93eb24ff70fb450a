//! The Rayreel trace file (`.rtrace`): what a ray tracer did, recorded once, to be read as often as one likes.
//!
//! A trace holds the BVH, the cameras, and for every sample of every frame its tree of rays: what each ray hit, the
//! shading, the shadow states, and each step of its way through the BVH. It stores no ray: rays follow from camera and
//! hits, to the last bit.
//!
//! - Read: [`Trace::open`], then [`Trace::tile`] for a [`Tile`] of columns, or [`Trace::rays`] for its rays.
//! - Write: [`TraceWriter`], with tiles coded by [`trace::TileCodec`]; it goes on with a file that was cut short.
//! - The formulas: [`rays`], [`intersect`], [`math`]; the tracer calls the same ones.
//! - Below: [`container`], the chunks of a file; `repair` and `scan` for damaged ones.
//! - Every reader has [`Limits`]; whatever goes wrong is an [`Error`] that says who must act.
//!
//! This crate knows nothing of scenes, tracing or hardware: those who capture and those who replay meet here. No input
//! makes it panic, loop, or take more memory than its limits. `FORMAT.md` beside it specifies every byte.
//!
//! ```
//! use rayreel_formats::intersect::intersect;
//! use rayreel_formats::rays::RayEnd;
//! use rayreel_formats::{Limits, Trace};
//!
//! let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../traces/v1_0_cornell.rtrace");
//! let trace = Trace::open(path.as_ref(), Limits::default())?;
//! for recorded in trace.rays(trace.meta().first_frame, 0)? {
//!     match recorded.end {
//!         RayEnd::Sky | RayEnd::Light { .. } => {}
//!         RayEnd::Hit(hit) => {
//!             let corners = trace.bvh().corners(hit.triangle as usize);
//!             let met = intersect(&recorded.ray, corners, f32::INFINITY).expect("the ray meets the triangle");
//!             assert_eq!(met.t, hit.t, "the ray is the one that was traced");
//!         }
//!     }
//! }
//! # Ok::<(), rayreel_formats::Error>(())
//! ```

pub mod budget;
pub mod bvh;
mod columns;
pub mod container;
pub mod durable;
pub mod error;
pub mod half;
mod id;
pub mod intersect;
pub mod limits;
pub mod locks;
pub mod math;
pub mod oct;
mod payload;
pub mod rays;
pub mod scene;
pub mod tile;
pub mod trace;

pub use error::{Error, Result};
pub use limits::Limits;
pub use rays::{Ray, RayRebuilder};
pub use scene::{Camera, Meta};
pub use tile::Tile;
pub use trace::{Trace, TraceWriter};
