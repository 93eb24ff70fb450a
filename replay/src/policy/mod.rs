//! Sampling policies: which recorded samples are traced, and which are interpolated from traced ones.
//!
//! A [`SamplePolicy`] decides, tile by tile, through a [`TileView`], which gives out nothing that the policy has not traced. The
//! built-in ones are the kinds of [`Policy`]. They cut the sample grid of the frame into blocks of n x n samples. *R-samples*
//! stand at every column that is a multiple of n, or the last one, in every row that is a multiple of n, or the last one. They
//! are always traced. The others are *I-samples*, decided in two steps:
//!
//! - **X step**, along each row of R-samples. Between two neighbouring R-samples that are similar the samples are interpolated.
//!   Otherwise they are traced: all of them ([`Refine::Direct`]), or the middle one, after which both halves are tested again
//!   ([`Refine::Hierarchical`]).
//! - **Y step**, down each column, the same between two neighbouring rows of R-samples, whose samples are all known by now.
//!
//! Then, if it is on, **correction**: interpolated samples that a traced neighbour contradicts are traced too. With `secondary`
//! an I-sample need not be traced whole: each hit of its ray tree is decided by itself.
//!
//! The block is the same for all tiles (`adaptive`), follows each tile's similarity in the frame before (`multirate`), or the
//! distance from a gaze point (`foveated`); `full` has blocks of one sample. `whitted1980`, `mitchell1987` and `jin2009` decide
//! between the four R-samples around a block instead, in `cells`. But for blocks that differ and for correction, the
//! result depends on the frame alone and not on its tiles, which only matter for accounting ([`Apron`]).
//!
//! The files, each of which uses only those before it: `limit`, `sampling`, `kinds`, `schema` and `load` (settings), `tree` (a sample's hits), `scramble` (chance), `interpolate`,
//! `shade`, `similarity`, `lattice` (where R-samples stand), `view`, `history` (the frame before), `reuse` (hit by hit), `correct`, `audit`, `target`, `rate` (blocks and
//! limits of tiles), `sampler` (the seam), `cells` (what lies between four R-samples), `adaptive` (the steps on a tile), `blocks` (all of it
//! as a sampler).

mod adaptive;
mod audit;
mod blocks;
mod cells;
mod correct;
mod history;
mod interpolate;
mod kinds;
mod lattice;
mod limit;
mod load;
mod rate;
mod reuse;
mod sampler;
mod sampling;
pub mod schema;
mod scramble;
mod shade;
mod similarity;
mod target;
pub mod tree;
pub mod view;

pub use interpolate::between;
pub use kinds::{
    Adaptive, Foveated, HistoryRules, Jin2009, Mitchell1987, Multirate, Policy, Priorities, Target, Temporal,
    Thresholds, Whitted1980,
};
pub use limit::Limit;
pub use load::NamedPolicy;
pub use sampler::{SamplePolicy, Sampler};
pub use sampling::{Apron, Attributes, Correct, First, Refine, Sampling, Shade, Similarity};
pub use schema::{POLICIES, PRESETS};
pub use view::{SampleState, TileView};
