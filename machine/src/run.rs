//! A frame's tiles through a machine, from the first cycle to the joules.

use crate::config::MachineConfig;
use crate::energy::EnergyReport;
use crate::error::Result;
use crate::srp::FrameShape;
use crate::stats::Stats;
use crate::system::{NoProbe, System};
use crate::work::TileWork;
use crate::work::topology::Topology;

/// Runs the tiles of a frame, in order, on a machine that starts with cold caches.
///
/// Whoever gets tiles one by one, or wants to look at the machine while it runs, uses a [`System`].
///
/// # Errors
/// [`MachineError::Deadlock`](crate::MachineError::Deadlock) if the machine stands still with work left.
pub fn run_tiles(
    config: &MachineConfig,
    tree: &Topology,
    shape: FrameShape,
    tiles: impl IntoIterator<Item = TileWork>,
) -> Result<(Stats, EnergyReport)> {
    let mut system = System::new(config, tree, shape);
    for tile in tiles {
        system.feed(tile, &mut NoProbe)?;
    }
    let (stats, _) = system.finish(&mut NoProbe)?;
    let energy = EnergyReport::new(config, &stats);
    Ok((stats, energy))
}
