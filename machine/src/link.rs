//! The seam between SRP and T&I unit of a core.

use std::collections::VecDeque;

use crate::time::TiCycle;

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
}
