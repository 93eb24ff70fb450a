//! The paper's experiment (Lee et al. 2016) on Rayreel's scenes, and what goes beyond it, as a library.
//!
//! Scenes are captured, points of policies and machines computed, and all put together as a [`Study`](rayreel_study::schema::Study).
//! Points are those of [`rayreel_study::point`]: what a sweep over the same traces has computed is found, and the other way round.
//!
//! ```
//! use rayreel_paper::{Folders, Setup, run};
//! use rayreel_replay::Stop;
//!
//! let place = tempfile::tempdir()?;
//! let folders = Folders { cache: place.path().join("cache"), out: place.path().join("out"), reuse: Vec::new() };
//! let cornell = rayreel_scenes::load("cornell")?;
//! // Without a machine: rays and pictures only.
//! let setup = Setup { size: (16, 8), ..Setup::new([cornell], None)? };
//! let finished = run(&setup, &folders, 2, &Stop::never(), &mut |_| {})?;
//! assert!(finished.study.points.iter().any(|point| point.policy == "paper-ss"));
//! assert_eq!(run(&setup, &folders, 2, &Stop::never(), &mut |_| {})?.counts.computed, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ablations;
pub mod anchors;
mod animation;
pub mod between;
mod cells;
mod claims;
mod error;
mod estimates;
mod execute;
mod experiment;
mod frame;
mod identity;
mod jobs;
mod ledger;
mod live;
mod lockstep;
mod maker;
mod meter;
mod plan;
mod points;
mod policies;
mod reference;
mod results;
mod rows;
mod setup;
mod study;
mod systems;
mod table;
mod totals;
mod traces;
mod widths;

pub use error::{PaperError, Result};
pub use experiment::{Finished, run};
pub use ledger::PointCounts;
pub use meter::Progress;
pub use reference::scenes;
pub use rows::rows;
pub use setup::{Folders, Machines, SIZE, SIZE_FULL, Setup, detail};
pub use table::table;
