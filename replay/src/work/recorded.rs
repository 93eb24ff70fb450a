//! What was recorded of a tile, with its paths in the form in which they take least memory: a row of tiles waits for the rows
//! around it, and its operations may take a gigabyte.

use std::sync::{Arc, OnceLock};

use rayreel_formats::tile::{Paths, Tile};
use rayreel_formats::trace::PackedColumn;
use rayreel_machine::work::recorded::TilePaths;

use crate::error::{ReplayError, Result};
use crate::source::{PackedTile, PathSource};

/// A recorded tile that is to become work.
pub(crate) struct RecordedTile {
    /// The tile.
    pub tile: Arc<Tile>,
    packed: Option<Arc<PackedColumn>>,
    /// Its paths, if several tiles need them.
    kept: OnceLock<Arc<TilePaths>>,
}

/// The paths of a tile.
#[derive(Clone, Copy)]
pub(crate) enum PathsOf<'a> {
    /// They lead through the tree.
    Known(&'a TilePaths),
    /// Nobody knows whether they do.
    Steps(&'a Paths),
}

impl PathsOf<'_> {
    /// Number of rays that have a path.
    pub fn rays(&self) -> usize {
        match self {
            Self::Known(paths) => paths.rays(),
            Self::Steps(paths) => paths.spans.len(),
        }
    }
}

impl RecordedTile {
    /// A tile as it was read.
    pub fn new(read: PackedTile) -> Self {
        Self { tile: read.tile, packed: read.packed, kept: OnceLock::new() }
    }

    /// Gives the paths of the tile to `use_them`; with `keep` they stay for the next who asks.
    ///
    /// # Errors
    /// Paths that are damaged; what `use_them` returns.
    pub fn with_paths<S: PathSource + ?Sized, T>(
        &self,
        source: &S,
        keep: bool,
        use_them: impl FnOnce(PathsOf<'_>) -> Result<T>,
    ) -> Result<T> {
        let Some(packed) = &self.packed else { return use_them(PathsOf::Steps(&self.tile.paths)) };
        if let Some(kept) = self.kept.get() {
            return use_them(PathsOf::Known(kept));
        }
        let paths = source.paths(&self.tile, packed);
        let paths = paths.map_err(|e| ReplayError::tile((self.tile.frame, self.tile.index), e))?;
        // Two who ask at once may both decode them; they get the same.
        use_them(PathsOf::Known(if keep { self.kept.get_or_init(|| paths) } else { &paths }))
    }
}
