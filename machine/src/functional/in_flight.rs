//! A tile that is being worked on: how far it is.

use std::sync::Arc;

use crate::srp::{Queues, RestOfTile};
use crate::work::TileWork;

/// A tile on its way through a functional machine.
#[derive(Clone, Debug)]
pub(super) struct InFlight {
    pub rest: RestOfTile,
    /// Place in the order in which tiles were given.
    pub number: usize,
    /// Rays in the T&I unit.
    pub rays_out: usize,
    /// Its size, and how much of that is done: operations of rays, and some for each ray.
    pub size: f64,
    pub done: f64,
}

/// What a ray counts for beside its operations.
const RAY: f64 = 4.0;

impl InFlight {
    /// A tile that has just been given.
    pub fn new(work: Arc<TileWork>, number: usize) -> Self {
        let size = work.operations() as f64 + RAY * work.rays.len() as f64;
        let rest = RestOfTile { work, begun: 0, queues: Queues::default(), rays_out: Vec::new(), written_bytes: 0 };
        Self { rest, number, rays_out: 0, size, done: 0.0 }
    }

    /// A ray was traced; gives which part of the tile it is.
    pub fn traced(&mut self, ray: u32) -> f64 {
        let done = f64::from(self.rest.work.rays[ray as usize].ops_len) + RAY;
        self.done += done;
        self.rays_out -= 1;
        done / self.size
    }

    /// The part of the tile that was not traced, once it is done.
    pub fn rest_of_size(&self) -> f64 {
        if self.size > 0.0 { 1.0 - self.done / self.size } else { 1.0 }
    }
}
