//! The seam between SRP and T&I unit of a core.

use std::collections::VecDeque;

use crate::time::TiCycle;
use crate::work::layout::{Lines, Region};

/// A ray of a tile that a core works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayRef {
    /// Tile slot of the core.
    pub slot: u8,
    /// Index into the rays of that tile's work.
    pub ray: u32,
}

/// A ray, or its hit, on its way to somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayMessage {
    /// The cycle at which it is there: it can be taken from then on.
    pub at: TiCycle,
    /// The ray.
    pub ray: RayRef,
}

/// Items of a kernel that a warp executes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Job {
    /// What its end is told by.
    pub tag: u32,
    /// Lanes that have an item.
    pub lanes: u32,
    /// Operations of the item that takes longest.
    pub longest: u64,
    /// Operations of all items.
    pub operations: u64,
    /// Its code.
    pub code: Lines,
    /// Lines that its items read.
    pub reads: Vec<(u64, Region)>,
}

/// What the SRP sees of a T&I unit.
pub trait RayUnit {
    /// Whether the ray buffer has a free entry.
    fn has_room(&self) -> bool;

    /// Puts a ray into the ray buffer at cycle `now`; the unit may use it from `now + 1` on.
    ///
    /// # Panics
    /// When the ray buffer is full.
    fn push(&mut self, now: TiCycle, ray: RayRef);

    /// Finished rays in order, each with the cycle at which its hit left the unit. The SRP takes them from the front.
    fn results(&mut self) -> &mut VecDeque<RayMessage>;

    /// Rays that were pushed and have not come out as results.
    fn rays_inside(&self) -> usize;

    /// Items of kernels that can be given to it now, in warps: none where the SRP has an array for them.
    fn job_room(&self) -> usize {
        0
    }

    /// Gives it a warp of items at cycle `now`; it may start from `now + 1` on.
    ///
    /// # Panics
    /// When it runs no kernels.
    fn push_job(&mut self, _now: TiCycle, _job: Job) {
        unreachable!("a unit that runs no kernels has no room for their items")
    }

    /// The tag of the next warp of items that is done.
    fn finished_job(&mut self) -> Option<u32> {
        None
    }

    /// Whether a warp of items is done that nobody has asked for yet.
    fn has_finished_jobs(&self) -> bool {
        false
    }
}
