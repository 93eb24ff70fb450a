//! What the units of a T&I unit work with.

use super::crossbar::LeafCrossbar;
use super::wheel::Wheel;
use crate::link::RayRef;
use crate::memory::{Lookup, Memory, Port};
use crate::time::TiCycle;
use crate::work::layout::{Layout, Region};
use crate::work::topology::Topology;
use crate::work::{RayWork, TileWork};

/// Where a unit finds the tiles of its core.
pub trait Tiles {
    /// The work of the tile in slot `slot`.
    fn work(&self, slot: u8) -> &TileWork;
}

impl Tiles for Vec<TileWork> {
    fn work(&self, slot: u8) -> &TileWork {
        &self[slot as usize]
    }
}

/// What a T&I unit works with.
#[derive(Debug)]
pub struct TiContext<'a, T, M> {
    /// The tree.
    pub tree: &'a Topology,
    /// Addresses.
    pub layout: &'a Layout,
    /// The tiles of the core.
    pub tiles: &'a T,
    /// The memory behind the L1s.
    pub memory: &'a mut M,
}

/// What an event of a traversal or intersection unit works with.
pub(super) struct EventContext<'a, T, M> {
    pub now: TiCycle,
    pub tree: &'a Topology,
    pub layout: &'a Layout,
    pub tiles: &'a T,
    pub memory: &'a mut M,
    pub crossbar: &'a mut LeafCrossbar,
    pub wheel: &'a mut Wheel,
    /// Finished rays are appended here.
    pub done: &'a mut Vec<RayRef>,
}

impl<T: Tiles, M: Memory> EventContext<'_, T, M> {
    /// Tells the memory what `ray` looks for in the L1 at `port`.
    pub fn tell(&mut self, port: Port, RayRef { slot, ray }: RayRef, (region, index): (Region, u32)) {
        let work = self.tiles.work(slot);
        let RayWork { kind, depth, x, y, .. } = work.rays[ray as usize];
        let lookup = Lookup { port, tile: work.tile, ray, kind, depth, sample: (x, y), region, index };
        self.memory.looked_for(self.now, lookup);
    }
}
