//! What is left of a tile: with it a run begins in the middle of a frame.

use std::sync::Arc;

use super::queues::Queues;
use crate::work::TileWork;

/// What is left of a tile that is being worked on.
#[derive(Clone, Debug)]
pub struct RestOfTile {
    /// The tile.
    pub(crate) work: Arc<TileWork>,
    /// Rounds that have begun. What is left of the last of them waits in the queues.
    pub(crate) begun: usize,
    /// What waits for the SRP.
    pub(crate) queues: Queues,
    /// Rays that were sent to the T&I unit and have not come back, in a checkpoint.
    pub(crate) rays_out: Vec<u32>,
    /// Bytes of samples that its rounds wrote to an external buffer.
    pub(crate) written_bytes: u64,
}
