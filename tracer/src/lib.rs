//! The functional ray tracer of Rayreel: traces Whitted ray trees and records them, with every step of every ray.
//!
//! [`build`] makes the BVH of a scene, [`SampleGrid`] says what is traced, [`capture`](capture::capture) records it
//! in a file, [`render`] keeps only the colours, [`verify`](verify::verify) checks a file. [`Tracer`] traces a tile
//! at a time for callers that want no file.
//!
//! Not here: scenes (`rayreel-scenes`); what decides where a ray goes (`rayreel-formats`, whose functions also rebuild
//! the rays of a trace); sampling policies and hardware (they work on a trace and never trace).
//!
//! ```
//! use rayreel_formats::{Limits, trace::{Codec, Trace}};
//! use rayreel_tracer::{CaptureOutput, SampleGrid, TraceSettings, build, capture::capture, verify::verify};
//!
//! let scene = rayreel_scenes::load("cornell")?;
//! let built = build(&scene)?;
//! let grid = SampleGrid { width: 32, height: 16, samples: 1, tile: 16, first_frame: 0, frames: 1 };
//! let meta = grid.meta(&scene, TraceSettings::default(), "example");
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("cornell.rtrace");
//! let output = CaptureOutput::new(path.clone(), Codec::Context, 3);
//! capture(&scene, &built, &meta, &output, |_| true)?;
//!
//! let trace = Trace::open(&path, Limits::default())?;
//! let verified = verify(&trace, |_| true)?;
//! assert_eq!((verified.tiles, verified.first), (2, None));
//! assert!(verified.rays > 32 * 16);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Invariants: shading uses only values as the trace stores them, quantised; rendering and recording share one traversal, of
//! packets, and verification walks each ray alone; no output depends on the number of threads or the processor.

pub mod accel;
pub mod against;
pub mod capture;
mod coincident;
pub mod convert;
mod grid;
mod materials;
mod render;
mod shading;
mod texture;
mod trace;
pub mod traverse;
mod tree;
pub mod verify;
mod version;
mod waves;
mod wording;

pub use accel::{BuildError, Built, build};
pub use capture::{CaptureOutcome, CaptureOutput, CaptureProgress, Captured};
pub use grid::{SampleGrid, TraceSettings};
pub use render::render;
pub use trace::Tracer;
pub use verify::{Mismatch, Verified};
pub use version::{TOOL, TRACER_VERSION};
