//! The seam between the replay of frames and policies: [`SamplePolicy`] describes one, a [`Sampler`] is one at work.
//!
//! The policies of a [`super::Policy`] are behind it, and so can be one of another crate. A sampler is asked tile by tile and
//! sees a tile through its [`TileView`] only: what it did not trace it cannot read.
//!
//! A frame is replayed in rows of tiles, top to bottom. The calls for a frame come in this order:
//!
//! ```text
//! begin_frame
//! each row:  begin_tile of all its tiles, then step_x of all its tiles
//!            step_y of the tiles of the row above (of the last row: at the end), then end_row for that row
//! end_frame
//! ```
//!
//! The calls for the tiles of a row come from several threads at once and in any order, so a result may depend on nothing that
//! a tile changes.

use rayreel_formats::scene::{Camera, Meta};

use super::Apron;
use super::tree::Forest;
use super::view::TileView;
use crate::counts::TileStats;
use crate::error::Result;
use rayreel_machine::work::PolicyReads;
use rayreel_machine::work::history::HistoryWork;

/// A sampling policy: which samples of a frame are traced, and what the others are made of.
///
/// # Examples
/// Every other column is traced, the columns between are interpolated; one row of a tile does not depend on another, nor a tile
/// on its neighbours.
///
/// ```
/// use rayreel_formats::scene::Meta;
/// use rayreel_replay::policy::{SampleState, SamplePolicy, Sampler, TileView, between};
///
/// struct Columns;
///
/// impl SamplePolicy for Columns {
///     fn name(&self) -> String {
///         "columns".into()
///     }
///     fn text(&self) -> String {
///         "columns, version 1".into()
///     }
///     fn sampler(&self, _: &Meta) -> rayreel_replay::Result<Box<dyn Sampler>> {
///         Ok(Box::new(Columns))
///     }
/// }
///
/// impl Sampler for Columns {
///     fn begin_tile(&self, view: &mut TileView) {
///         let rect = view.rect();
///         for (x, y) in view.samples().filter(|(x, _)| (x - rect.x) % 2 == 0) {
///             view.trace(x, y, SampleState::Reference, 0);
///         }
///         for (x, y) in view.samples().filter(|(x, _)| (x - rect.x) % 2 == 1) {
///             let right = if x + 1 < rect.x + rect.width { x + 1 } else { x - 1 };
///             let tree = between(view.tree(x - 1, y), view.tree(right, y), 0.5);
///             view.interpolate(x, y, &tree, 1);
///         }
///     }
/// }
/// ```
pub trait SamplePolicy: Send + Sync {
    /// What people call it, as results show it.
    fn name(&self) -> String;

    /// Everything that its decisions depend on, as text: policies of the same text must decide alike, whatever their names.
    /// Results are kept under it, so it must change when the rules do.
    fn text(&self) -> String;

    /// Sets out to replay a trace, from a first frame on.
    ///
    /// # Errors
    /// When a value of the policy is out of range, or it does not suit the trace.
    fn sampler(&self, meta: &Meta) -> Result<Box<dyn Sampler>>;
}

/// A policy at work on the frames of one trace, one after the other.
///
/// After [`Sampler::step_y`] every sample of a tile must be decided, or the replay ends with an error. All but
/// [`Sampler::begin_tile`] does nothing unless it is written.
pub trait Sampler: Send + Sync {
    /// The policy looks at whole ray trees, not only at primary hits with the colour of all.
    fn deep(&self) -> bool {
        false
    }

    /// What it reads of hits beside their colours: what its decisions cost on a machine.
    fn reads(&self) -> PolicyReads {
        PolicyReads::PAPER
    }

    /// A frame begins. Frames may be left out, or end early when something fails.
    fn begin_frame(&mut self, _frame: u32, _camera: &Camera) {}

    /// First look at a tile, which knows no other: its samples of round 0, and whatever else needs no neighbour.
    fn begin_tile(&self, view: &mut TileView);

    /// The rows on which the tile to the left of `view` reads a sample of its first column. These samples must be known after
    /// [`Sampler::begin_tile`].
    fn shared_rows(&self, _view: &TileView) -> Vec<u32> {
        Vec::new()
    }

    /// The tile above reads the first row of each tile. It must be known after [`Sampler::step_x`].
    fn shares_first_row(&self) -> bool {
        false
    }

    /// The columns in which the tile above reads a sample of the first row of `view`, ascending.
    fn shared_columns(&self, view: &TileView) -> Vec<u32> {
        let (x, width) = (view.rect().x, view.rect().width);
        if self.shares_first_row() { (x..x + width).collect() } else { Vec::new() }
    }

    /// A tile reads the tile to the right of the one below, too: R-samples, as all that it reads of its neighbours. The columns
    /// and rows that wait then begin with its own last R-samples, which do not wait.
    fn shares_corner(&self) -> bool {
        false
    }

    /// The columns and rows of a tile, in the frame's grid, that wait for its neighbours: from the first of these columns on it
    /// takes samples of the tile to the right to decide, from the first of these rows on samples of the tile below. A machine
    /// does what belongs to them when the neighbour has brought its samples. [`u32::MAX`] says that nothing waits.
    fn waiting_from(&self, _view: &TileView) -> (u32, u32) {
        (u32::MAX, u32::MAX)
    }

    /// Second look at a tile. `right` holds the samples that the tile to the right shares, by row from top to bottom: nothing
    /// if there is no such tile, or it shares none.
    fn step_x(&self, _view: &mut TileView, _right: Option<&Forest>) {}

    /// Last look at a tile. `below` holds the first row of the tile below, left to right, in the columns that it shares: nothing
    /// if there is no such tile, or it shares none. With [`Sampler::shares_corner`], where there is a tile to the right, two
    /// samples follow: the last that it shares, and the first of the tile below it.
    fn step_y(&self, _view: &mut TileView, _below: Option<&Forest>) {}

    /// Takes note of the next row of tiles that is decided, top to bottom; the row below it has begun by then.
    fn end_row(&mut self, _row: &[TileStats]) {}

    /// What a decided tile has to do with the frames before and after: it looks up `places`. The tile was kept before.
    fn history(&self, _view: &TileView, _places: &[u32]) -> HistoryWork {
        HistoryWork::default()
    }

    /// Keeps of the tiles of a row, all decided, what it wants for later frames: all that it knew of them.
    fn keep(&mut self, _tiles: &[TileView]) {}

    /// Takes note of the tiles of the frame, in order.
    fn end_frame(&mut self, _tiles: &[TileStats]) {}

    /// Block edge of a tile, samples: what maps and reports show.
    fn block(&self, _tile: u32) -> u32 {
        1
    }

    /// Factor on the limits of a tile: what reports show.
    fn factor(&self, _tile: u32) -> f64 {
        1.0
    }

    /// The same policy, having learnt the same: a frame can then be begun again. A policy that cannot be kept gives nothing, and
    /// its frames are simulated whole.
    fn fork(&self) -> Option<Box<dyn Sampler>> {
        None
    }

    /// Who pays for the samples that a tile reads of its neighbours.
    fn apron(&self) -> Apron {
        Apron::Share
    }
}
