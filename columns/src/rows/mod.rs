//! The tables that follow from a trace alone, tile by tile, and those of its geometry.

mod addresses;
mod geometry;
mod hits;
mod kinds;
mod paths;
mod rays;
mod samples;
mod steps;

use rayreel_formats::tile::Tile;
use rayreel_formats::trace::Trace;

use crate::error::Result;
use crate::schema::{Batch, Table};

pub use addresses::{AddressRows, Addresses};
pub use geometry::{NodeRows, TriangleRows, ancestors, nodes, triangle_words, triangles};
pub(crate) use hits::COLOURS as HIT_COLOURS;
pub use hits::{HitRows, Hits};
pub use kinds::{Asked, Kind, Outcome};
pub use rays::RayRows;
pub(crate) use samples::{COLOURS as SAMPLE_COLOURS, WORK as SAMPLE_WORK};
pub use samples::{Made, SampleRows, Samples, State};
pub use steps::{At, StepOutcome, StepRows};

/// Rows that tiles add to, whichever tiles they are.
pub trait TileRows: Default + Send {
    /// The table.
    const TABLE: &'static Table;
    /// How many rows a sample has, about: how many tiles make a batch.
    const ROWS_A_SAMPLE: u32;
    /// What beside the trace the rows of a frame follow from.
    type With: Sync;

    /// Adds the rows of a tile.
    ///
    /// # Errors
    /// When the trace does not hold it, or it is damaged.
    fn add(&mut self, trace: &Trace, with: &Self::With, tile: (u32, u32)) -> Result<()>;

    /// The rows so far.
    fn into_batch(self) -> Batch;
}

/// Where a sample of a tile stands in the frame's grid: column and row.
fn place(tile: &Tile, sample: u32) -> (u32, u32) {
    (tile.rect.x + sample % tile.rect.width, tile.rect.y + sample / tile.rect.width)
}

/// Appends the same value several times.
fn repeat<T: Copy>(values: &mut Vec<T>, value: T, times: usize) {
    values.resize(values.len() + times, value);
}
