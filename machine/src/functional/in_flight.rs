//! A tile that is being worked on: how far it is.

use std::sync::Arc;

use super::features::Features;
use crate::work::{Round, TileWork};

/// A tile on its way through a functional machine.
#[derive(Clone, Debug)]
pub(super) struct InFlight {
    pub work: Arc<TileWork>,
    /// Place in the order in which tiles were given.
    pub number: usize,
    /// Rounds that have begun.
    pub round: usize,
    /// Rays of the round that are sent next, and of those the first that is not sent yet.
    pub wave: Vec<u32>,
    pub sent: usize,
    /// Rays of hits of the wave.
    pub next: Vec<u32>,
    /// The SRP starts the wave; else hits do.
    pub started: bool,
    /// Bytes of samples that its rounds wrote to an external buffer.
    pub written_bytes: u64,
    pub features: Features,
}

/// The rest of a tile that is being worked on.
#[derive(Clone, Debug)]
pub struct RestOfTile {
    /// The core that works on it.
    pub core: usize,
    /// The whole tile.
    pub whole: Arc<TileWork>,
    rounds: Vec<Round>,
}

impl InFlight {
    /// A tile that has just been given.
    pub fn new(work: Arc<TileWork>, number: usize) -> Self {
        Self {
            work,
            number,
            round: 0,
            wave: Vec::new(),
            sent: 0,
            next: Vec::new(),
            started: false,
            written_bytes: 0,
            features: Features::default(),
        }
    }

    /// What is left of it on core `core`.
    pub fn rest(&self, core: usize) -> RestOfTile {
        let starts: Vec<u32> = self.wave[self.sent..].iter().chain(&self.next).copied().collect();
        let mut rounds = vec![Round { tests: 0, interpolated: 0, starts }];
        rounds.extend(self.work.rounds.iter().skip(self.round).cloned());
        RestOfTile { core, whole: Arc::clone(&self.work), rounds }
    }
}

impl RestOfTile {
    /// The rest as a tile of its own: rays whose hits have sent them already are started by the SRP.
    pub fn work(&self) -> TileWork {
        TileWork { rounds: self.rounds.clone(), ..TileWork::clone(&self.whole) }
    }
}
