//! Sampling policies: which recorded samples are traced, and which are interpolated from traced ones.
//!
//! The sample grid of the whole frame is cut into blocks of n x n samples. *R-samples* stand at every column that is a
//! multiple of n, or the last one, in every row that is a multiple of n, or the last one; they are always traced. The others
//! are *I-samples*, decided in two steps:
//!
//! - **X step**, along each row of R-samples: between two neighbouring R-samples that are similar ([`similarity`]) the
//!   samples are interpolated ([`interpolate`]), otherwise traced: all of them ([`Refine::Direct`]), or the middle one, after
//!   which both halves are tested again ([`Refine::Hierarchical`]).
//! - **Y step**, down each column, the same between two neighbouring rows of R-samples, whose samples are all known by now.
//!
//! Then, if it is on, **correction** ([`correct`]): interpolated samples that a traced neighbour contradicts are traced too.
//! With `secondary` an I-sample need not be traced whole: each hit of its ray tree is decided by itself ([`reuse`]).
//!
//! The block is the same for all tiles (`adaptive`), follows each tile's similarity in the frame before (`multirate`), or the
//! distance from a gaze point (`foveated`): [`rate`]. But for these and for correction, the result depends on the frame alone
//! and not on its tiles; they matter for accounting ([`Apron`]). A policy sees only what it has traced: [`view::TileView`]
//! gives out nothing else. `full` is the same with blocks of one sample.
//!
//! Not here: which tiles are in memory when (see [`crate::frame`]).

pub mod adaptive;
pub mod audit;
pub mod correct;
pub mod interpolate;
mod kinds;
pub mod lattice;
mod limit;
mod load;
pub mod rate;
pub mod reuse;
mod sampling;
pub mod schema;
pub mod similarity;
pub mod target;
pub mod tree;
pub mod view;

pub use kinds::{Adaptive, Foveated, Multirate, Policy, Target};
pub use limit::Limit;
pub use load::NamedPolicy;
pub use sampling::{Apron, Correct, Refine, Sampling, Similarity};
pub use schema::{POLICIES, PRESETS};
