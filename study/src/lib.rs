//! Studies: points of a design space over recorded traces, their results, and what is shown of them.
//!
//! A [`Point`] is a trace, a machine, a policy and a run of frames. Its [`Row`] of figures is a pure function of its key, so it does
//! not matter who computes it, when, or how often. A [`Plan`] makes many of them; [`run`](sweep::run::run) computes what is missing,
//! on one machine or many, and [`merge`] puts the rows into one table.
//!
//! ```
//! use rayreel_formats::{Limits, trace::Trace};
//! use rayreel_replay::Stop;
//! use rayreel_study::sweep::plan::{Sources, locate::Text};
//! use rayreel_study::sweep::run::{Settings, run};
//! use rayreel_study::{Folder, Plan, ReusedRows, Shard, Writer, merge};
//!
//! let open = |file: &str| Trace::open(file.as_ref(), Limits::default()).map_err(|e| e.to_string());
//! let text = Text { name: "plan", text: r#"
//!     traces = ["../traces/v1_0_cornell.rtrace"]
//!     machines = ["none"] # rays and pictures only
//!     policies = ["full", "adaptive"]
//! "# };
//! let plan = Plan::new(&Sources { text, folder: "".as_ref(), traces: None, detail: None, stem: "plan", open: &open })?;
//!
//! let place = tempfile::tempdir()?;
//! let (folder, _) = Folder::create(&place.path().join("sweep"), plan)?;
//! let writer = Writer { attempt: "example".into(), host: "here".into() };
//! let (shard, flush, reused) = (Shard::WHOLE, std::time::Duration::ZERO, &ReusedRows::default());
//! let settings = Settings { shard, threads: 2, memory: 64 << 20, flush, writer, stop: Stop::never(), open: &open, reused };
//! assert_eq!(run(&folder, &settings, |_| {})?.computed, 2);
//!
//! let table = merge(&folder)?.results;
//! let rays = &table.field("rays_traced").unwrap().cells;
//! assert!(rays.number(1) < rays.number(0), "adaptive traces fewer rays than full");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod analysis;
#[cfg(feature = "cluster")]
pub mod cluster;
pub mod compare;
pub mod error;
pub mod figures;
pub mod files;
#[cfg(feature = "html")]
pub mod html;
pub mod point;
pub mod policy_text;
pub mod pool;
pub mod presets;
pub mod report;
pub mod schema;
pub mod sweep;
pub mod table;

pub use error::{Result, StudyError};
pub use point::key::Point;
pub use point::row::Row;
pub use point::segment::Writer;
pub use point::store::Store;
pub use sweep::{folder::Folder, merge::merge, plan::Plan, reused::ReusedRows, shard::Shard};
