//! One window: a few consecutive tiles, simulated cycle by cycle from warm caches on.
//!
//! A window is measured from the moment at which its first tile can begin to the moment at which the tile after its last one
//! could. At both moments other tiles are under way, as in a whole simulation, so what is measured is not the work of its tiles:
//! of each tile the part counts that was done between the two moments.

use std::sync::Arc;

use rayreel_formats::tile::RayKind;
use rayreel_machine::config::{MachineConfig, PrimaryVisibility};
use rayreel_machine::functional::Checkpoint;
use rayreel_machine::srp::FrameShape;
use rayreel_machine::system::{Measure, NoProbe, System};
use rayreel_machine::work::topology::Topology;
use rayreel_machine::work::{NO_RAY, TileWork};

use crate::error::Result;
use crate::stop::Stop;

/// A window to be simulated.
pub struct Window {
    /// Its tiles, those of its warm-up first.
    pub tiles: Vec<Arc<TileWork>>,
    /// Tiles of the warm-up.
    pub warm_up: usize,
    /// The machine when the warm-up begins; an empty one where nothing is given.
    pub from: Option<Checkpoint>,
    /// It is the last of the frame: it ends when everything is done.
    pub last: bool,
}

/// What a window measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// All counters, as [`rayreel_machine::Stats::list`] has them.
    pub counters: Vec<f64>,
    /// Tile numbers, and which part of each was done.
    pub parts: Vec<(u32, f64)>,
}

/// A tile of a window: its number, the operations of the whole tile, and those that the window is given.
#[derive(Clone, Copy)]
struct TileSize {
    tile: u32,
    whole: u64,
    given: u64,
}

/// How far a tile is at some moment: operations done, and whether it is finished.
type Progress = (u64, bool);

impl Window {
    /// Simulates it.
    ///
    /// # Errors
    /// [`crate::ReplayError::Machine`] if the machine stands still, and an interruption.
    pub fn simulate(self, config: &MachineConfig, tree: &Topology, shape: FrameShape, stop: &Stop) -> Result<Measured> {
        let Self { tiles, warm_up, from, last } = self;
        let rests = from.as_ref().map_or(&[][..], |from| &from.tiles);
        let rests = rests.iter().map(|rest| {
            let (whole, given) = (operations(config, &rest.whole), operations(config, &rest.work()));
            TileSize { tile: rest.whole.tile, whole, given }
        });
        let whole = tiles.iter().map(|tile| {
            let whole = operations(config, tile);
            TileSize { tile: tile.tile, whole, given: whole }
        });
        let sizes: Vec<TileSize> = rests.chain(whole).collect();
        let resumed = sizes.len() - tiles.len();
        let mut system = match &from {
            Some(from) => System::resume(config, tree, shape, from),
            None => System::new(config, tree, shape),
        };
        let mut begun = None;
        for (number, tile) in tiles.into_iter().enumerate() {
            stop.check()?;
            if number == warm_up {
                system.make_room(&mut NoProbe)?;
                let measure = system.measure();
                begun = Some((measure.stats.list(), progress(&sizes, resumed + number, &measure)));
            }
            system.feed(Arc::unwrap_or_clone(tile), &mut NoProbe)?;
        }
        let (after, ended) = if last {
            let (stats, _) = system.finish(&mut NoProbe)?;
            (stats.list(), sizes.iter().map(|size| (size.given, true)).collect())
        } else {
            system.make_room(&mut NoProbe)?;
            let measure = system.measure();
            (measure.stats.list(), progress(&sizes, sizes.len(), &measure))
        };
        let (before, begun) = begun.unwrap_or_else(|| (vec![0.0; after.len()], vec![(0, false); sizes.len()]));
        let counters = after.iter().zip(before).map(|(after, before)| after - before).collect();
        let parts = sizes.iter().zip(begun.iter().zip(&ended));
        let parts = parts.map(|(size, (&from, &to))| (size.tile, part(size.whole, from, to))).collect();
        Ok(Measured { counters, parts })
    }
}

/// Which part of a tile of `whole` operations was done.
fn part(whole: u64, from: Progress, to: Progress) -> f64 {
    if whole == 0 { f64::from(u8::from(to.1 && !from.1)) } else { (to.0 - from.0) as f64 / whole as f64 }
}

/// How far the tiles are of which the first `fed` were given to the machine.
fn progress(sizes: &[TileSize], fed: usize, measure: &Measure) -> Vec<Progress> {
    let state = |(number, size): (usize, &TileSize)| {
        let in_work = measure.in_work.iter().find(|(other, _)| *other == size.tile);
        match in_work {
            Some(&(_, done)) => (done, false),
            None if number < fed => (size.given, true),
            None => (0, false),
        }
    };
    sizes.iter().enumerate().map(state).collect()
}

/// The operations of the rays of a tile that a T&I unit traces: a rasteriser sees the primary rays.
fn operations(config: &MachineConfig, tile: &TileWork) -> u64 {
    let rasters = config.gpu.primary_visibility == PrimaryVisibility::Raster;
    let mut rays: Vec<u32> = tile.rounds.iter().flat_map(|round| &round.starts).copied().collect();
    let mut sum = 0;
    while let Some(number) = rays.pop() {
        let ray = &tile.rays[number as usize];
        if !(rasters && ray.kind == RayKind::Primary) {
            sum += u64::from(ray.ops_len);
        }
        rays.extend(number + 1..=number + u32::from(ray.shadows));
        rays.extend([ray.reflect, ray.refract].into_iter().filter(|&child| child != NO_RAY));
    }
    sum
}
