//! A tile that is being worked on: how far it is.

use std::sync::Arc;

use super::features::Features;
use crate::srp::Queues;
use crate::work::TileWork;

/// A tile on its way through a functional machine.
#[derive(Clone, Debug)]
pub(super) struct InFlight {
    pub rest: RestOfTile,
    /// Place in the order in which tiles were given.
    pub number: usize,
    pub features: Features,
}

/// What is left of a tile that is being worked on.
#[derive(Clone, Debug)]
pub struct RestOfTile {
    /// The tile.
    pub(crate) work: Arc<TileWork>,
    /// Rounds that have begun. What is left of the last of them waits in the queues.
    pub(crate) begun: usize,
    /// What waits for the SRP.
    pub(crate) queues: Queues,
    /// Bytes of samples that its rounds wrote to an external buffer.
    pub(crate) written_bytes: u64,
}

impl InFlight {
    /// A tile that has just been given.
    pub fn new(work: Arc<TileWork>, number: usize) -> Self {
        let rest = RestOfTile { work, begun: 0, queues: Queues::default(), written_bytes: 0 };
        Self { rest, number, features: Features::default() }
    }
}
