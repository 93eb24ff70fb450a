//! The format of `study.json`: many replays side by side, as a study's folder holds them beside their pictures.
//!
//! `rayreel paper` writes the file and `rayreel report` makes a page of it; nothing but this file stands between them. [`Study`] is
//! the whole of it, and each struct below is an object of the file: its fields are the keys, in their order, and no other key is
//! taken. Whoever changes a field changes the format, and raises [`SCHEMA`].
//!
//! Whatever was not measured is null or an empty list. Ratios are plain numbers (0.25, not 25 %), pictures are PNG files named
//! relative to the study's folder, frames count from 1.

mod ablations;
mod animation;
mod points;
mod references;
mod setup;
mod study;
mod systems;
mod viewer;

pub use ablations::Ablation;
pub use animation::{Map, Track, TrackFrame};
pub use points::{Component, Cost, CostInterval, Gain, GainInterval, Kernel, Point, Quality, StateShare, Unit};
pub use references::{GainBand, ModePolicy, PaperKernel, PaperPsnr, References};
pub use setup::{ConfigValue, ModeRays, Policy, Scene};
pub use study::{FILE, SCHEMA, Study};
pub use systems::SystemPoint;
pub use viewer::{TileFigures, ViewerImages, ViewerSet};
