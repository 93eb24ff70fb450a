//! One window: a part of a frame, simulated cycle by cycle from warm caches on.
//!
//! A window is as long as a stretch of the functional pass: the machine without cycles was at some point when the window began,
//! and had done so much more at the end of its warm-up, and so much more again at its own end. The simulation goes on from the
//! same point, and is measured between the moments at which it has done as much. At both moments other rays are under way, as
//! in a whole simulation.

use std::sync::Arc;

use rayreel_machine::config::MachineConfig;
use rayreel_machine::functional::{Checkpoint, Features};
use rayreel_machine::srp::FrameShape;
use rayreel_machine::system::{NoProbe, System};
use rayreel_machine::work::TileWork;
use rayreel_machine::work::topology::Topology;

use crate::error::Result;
use crate::stop::Stop;

/// A window to be simulated.
pub struct Window {
    /// The machine when the warm-up begins; an empty one where nothing is given.
    pub from: Option<Checkpoint>,
    /// The tiles that come next: at least as many as the machine can have begun before the end.
    pub tiles: Vec<Arc<TileWork>>,
    /// Work of the warm-up, as [`Features::size`] counts it.
    pub warm_up: f64,
    /// What the functional machine did from the end of the warm-up to the end of the window.
    pub features: Features,
    /// It is the last of the frame: it ends when everything is done.
    pub is_last: bool,
    /// It stands for itself and for nothing else.
    pub is_certain: bool,
}

/// What a window measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// All counters, as [`rayreel_machine::Stats::list`] has them, for the work of `features`.
    pub counters: Vec<f64>,
    /// What the functional machine did meanwhile.
    pub features: Features,
    /// It stands for itself and for nothing else.
    pub is_certain: bool,
}

impl Window {
    /// Simulates it.
    ///
    /// # Errors
    /// [`crate::ReplayError::Machine`] if the machine stands still, and an interruption.
    pub fn simulate(self, config: &MachineConfig, tree: &Topology, shape: FrameShape, stop: &Stop) -> Result<Measured> {
        let Self { from, tiles, warm_up, features, is_last, is_certain } = self;
        let mut tiles = tiles.into_iter().take_while(|_| stop.check().is_ok()).peekable();
        let mut system = match &from {
            Some(from) => System::resume(config, tree, shape, from),
            None => System::new(config, tree, shape),
        };
        drop(from);
        if warm_up > 0.0 {
            system.work_until(warm_up, &mut tiles)?;
        }
        let (before, begun) = (system.measure().list(), system.done());
        let wanted = features.size();
        system.work_until(if is_last { f64::INFINITY } else { begun + wanted }, &mut tiles)?;
        stop.check()?;
        let done = system.done() - begun;
        let after = if is_last { system.finish(&mut NoProbe)?.0.list() } else { system.measure().list() };
        // It stopped at the first look after it had done enough.
        let scale = if done > 0.0 && wanted > 0.0 { wanted / done } else { 1.0 };
        let counters = after.iter().zip(before).map(|(after, before)| scale * (after - before)).collect();
        Ok(Measured { counters, features, is_certain })
    }
}
