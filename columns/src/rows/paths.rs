//! The paths of a tile's rays as operations, ray by ray.

use std::sync::Arc;

use rayreel_formats::tile::{Column, Tile};
use rayreel_formats::trace::Trace;
use rayreel_machine::work::check::{Fault, PathCounts, walk};
use rayreel_machine::work::ops::Op;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::PathSource;

use crate::error::{ColumnsError, Result};

/// A ray of a tile.
#[derive(Clone, Copy, Debug)]
pub struct RayAt {
    /// Sample in the tile, counted row by row.
    pub sample: u32,
    /// Its number in the tile.
    pub index: u32,
    /// Its number in its sample.
    pub ray: u32,
    /// It is a shadow ray.
    pub shadow: bool,
}

/// All rays of a tile, in order.
pub fn rays(tile: &Tile) -> impl Iterator<Item = RayAt> {
    let mut index = 0;
    (0..tile.tree.samples()).flat_map(move |sample| {
        let first = index;
        let counts = tile.tree.nodes[tile.tree.sample(sample)].iter().map(|node| 1 + node.shadows.count());
        let mut found = Vec::new();
        for count in counts {
            let at = |i| RayAt { sample: sample as u32, index: index + i, ray: index + i - first, shadow: i > 0 };
            found.extend((0..count).map(at));
            index += count;
        }
        found
    })
}

/// What is wrong with a path.
pub fn broken(tile: &Tile, ray: u32, Fault { step, detail }: Fault) -> ColumnsError {
    ColumnsError::Path { frame: tile.frame, tile: tile.index, ray, step, detail }
}

/// Gives every ray of a tile to `see`, with its operations and what they ask for. The tile that it gives back has the columns of `also`
/// too, at least.
///
/// # Errors
/// When the trace does not hold the tile or one of these columns, or it is damaged.
pub fn each_path(
    trace: &Trace,
    tree: &Topology,
    also: &[Column],
    (frame, index): (u32, u32),
    mut see: impl FnMut(&Tile, RayAt, &[Op], PathCounts),
) -> Result<Arc<Tile>> {
    let (tile, packed) = if trace.lacking().is_empty() {
        let read = PathSource::packed_tile(trace, frame, index)?;
        (read.tile, read.packed)
    } else {
        // Only what is needed: the others may have been trimmed away.
        let columns = [&[Column::Paths], also].concat();
        (Arc::new(trace.tile(frame, index, &columns)?), None)
    };
    if let Some(packed) = packed {
        // Known to lead through the tree; rays that share a path share its operations.
        let paths = PathSource::paths(trace, &tile, &packed)?;
        for ray in rays(&tile) {
            let path = paths.of_ray(ray.index).ok_or_else(|| broken(&tile, ray.index, NO_PATH))?;
            let (recorded, ops) = paths.path(path);
            see(&tile, ray, ops, recorded.counts);
        }
        return Ok(tile);
    }
    let mut ops = Vec::new();
    for ray in rays(&tile) {
        let mut counts = PathCounts::default();
        ops.clear();
        if ray.index as usize >= tile.paths.spans.len() {
            return Err(broken(&tile, ray.index, NO_PATH));
        }
        walk(tree, tile.paths.ray(ray.index as usize), ray.shadow, &mut ops, &mut counts)
            .map_err(|fault| broken(&tile, ray.index, fault))?;
        see(&tile, ray, &ops, counts);
    }
    Ok(tile)
}

pub(super) const NO_PATH: Fault = Fault { step: 0, detail: "the ray has no path" };
