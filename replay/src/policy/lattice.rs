//! Where the R-samples of a frame stand.

use super::kinds::{Edge, Policy};
use crate::error::{RequestError, Result};

/// The R-sample grid of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleLattice {
    /// Columns of samples in the frame.
    pub width: u32,
    /// Rows of samples in the frame.
    pub height: u32,
    /// Block edge in samples; 1 makes every sample an R-sample.
    pub block: u32,
}

impl SampleLattice {
    /// True for a column of R-samples: a multiple of the block, or the last one.
    pub fn is_column(&self, x: u32) -> bool {
        x.is_multiple_of(self.block) || x + 1 == self.width
    }

    /// True for a row of R-samples: a multiple of the block, or the last one.
    pub fn is_row(&self, y: u32) -> bool {
        y.is_multiple_of(self.block) || y + 1 == self.height
    }

    /// The R-columns in `from..to`, ascending.
    pub fn columns(&self, from: u32, to: u32) -> impl Iterator<Item = u32> + use<> {
        let lattice = *self;
        (from..to).filter(move |&x| lattice.is_column(x))
    }

    /// The R-rows in `from..to`, ascending.
    pub fn rows(&self, from: u32, to: u32) -> impl Iterator<Item = u32> + use<> {
        let lattice = *self;
        (from..to).filter(move |&y| lattice.is_row(y))
    }
}

/// Tiles must begin at R-samples of every block that they may have, and at entries of the history.
///
/// # Errors
/// [`RequestError::TileSize`].
pub fn check_tile(tile: u32, policy: &Policy) -> Result<()> {
    let edges = policy.edges();
    let Some(&Edge { key, edge, allowed }) = edges.iter().find(|e| !tile.is_multiple_of(e.edge)) else { return Ok(()) };
    // One edge, or powers of two: the largest is a multiple of all.
    let multiple = edges.iter().map(|e| e.edge).fold(1, u32::max);
    let fit = |edge: &&i64| u32::try_from(**edge).is_ok_and(|edge| tile.is_multiple_of(edge));
    let edges: Vec<_> = allowed.iter().filter(fit).map(i64::to_string).collect();
    let below = tile / multiple * multiple;
    let tiles: Vec<_> = [below, below + multiple].into_iter().filter(|&t| t > 0).map(|t| t.to_string()).collect();
    let edges = if edges.is_empty() { "none does".into() } else { edges.join(", ") };
    Err(RequestError::TileSize { key, tile, edge, edges, multiple, tiles: tiles.join(" or ") }.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_column_and_row_close_the_frame() {
        let lattice = SampleLattice { width: 8, height: 7, block: 3 };
        assert_eq!(lattice.columns(0, 8).collect::<Vec<_>>(), [0, 3, 6, 7]);
        assert_eq!(lattice.rows(0, 7).collect::<Vec<_>>(), [0, 3, 6]);
        assert_eq!(lattice.columns(3, 6).collect::<Vec<_>>(), [3]);
        let every = SampleLattice { width: 3, height: 1, block: 1 };
        assert_eq!(every.columns(0, 3).count(), 3);
    }

    #[test]
    fn tiles_that_do_not_suit_a_policy_name_the_key_at_fault() {
        let check = |name: &str, set: &[&str], tile| {
            let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
            let named = crate::policy::NamedPolicy::load(name, &set).unwrap();
            check_tile(tile, &named.policy).map_err(|error| error.to_string())
        };
        let multirate = check("multirate", &[], 20).unwrap_err();
        assert!(multirate.starts_with("coarsest = 8 does not divide tiles of 20 samples"), "{multirate}");
        assert!(multirate.contains("(2, 4), or capture") && multirate.ends_with("a multiple of 8 (such as 16 or 24)"));
        // Blocks fit, entries of the history do not.
        let blocks = ["start=2", "finest=2", "coarsest=2"];
        let temporal = check("temporal", &blocks, 18).unwrap_err();
        assert!(temporal.starts_with("history.step = 4 ") && temporal.contains("(1, 2)"), "{temporal}");
        let step = [&blocks[..], &["history.step=2"]].concat();
        assert_eq!(check("temporal", &step, 18), Ok(()));
        assert_eq!(check("full", &[], 17), Ok(()));
    }
}
