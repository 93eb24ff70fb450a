//! Parts of work: what is traced, tested and interpolated of a tile by one of the tiles that share it, and how a tile's work is
//! joined from such parts.

use rayreel_formats::tile::Tile;

use super::stream::Weigh;
use crate::error::{ReplayError, Result};
use crate::policy::view::{CLOSERS, Closer, RoundCounts};
use rayreel_machine::work::check::PathCounts;
use rayreel_machine::work::history::HistoryWork;
use rayreel_machine::work::ops::Op;
use rayreel_machine::work::{NO_RAY, Neighbour, RayWork, Round, TileWork};

/// A tile as work, and what its paths ask for.
#[derive(Clone, Debug, PartialEq)]
pub struct Built {
    /// The work.
    pub work: TileWork,
    /// Sums over all its rays, apron included.
    pub paths: PathCounts,
}

impl Weigh for Built {
    fn bytes(&self) -> usize {
        let TileWork { ops, rays, .. } = &self.work;
        size_of::<Self>() + ops.capacity() * size_of::<Op>() + rays.capacity() * size_of::<RayWork>()
    }
}

/// Rays of some samples of one recorded tile, numbered from 0.
#[derive(Debug, Default)]
pub(crate) struct Part {
    pub(super) rays: Vec<RayWork>,
    rounds: Vec<Round>,
    pub(super) paths: PathCounts,
    pub(super) samples: u32,
    pub(super) secondary_hits: u32,
    pub(super) audited_samples: u32,
    pub(super) ops: Vec<Op>,
    /// Places of the history that are looked up.
    pub(super) looked_up: Vec<u32>,
}

/// What is done of a tile, by who does it.
#[derive(Debug, Default)]
pub(crate) struct Parts(pub(super) [Part; CLOSERS.len()]);

impl Parts {
    /// Takes the part of `closer`.
    pub fn take(&mut self, closer: Closer) -> Part {
        std::mem::take(&mut self.0[closer as usize])
    }
}

/// What a tile closes: strips of the tile to its left, of the tile above, and of the one to the left of that.
#[derive(Debug, Default)]
pub(crate) struct Closes {
    pub left: Part,
    pub above: [Part; 2],
    /// Rounds of the tile above that bring what is read: those of its X step, and those in which it closes its left neighbour's.
    pub above_rounds: u32,
}

/// What a tile exchanges with its neighbours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Borders {
    /// Samples of the tiles to the left and above that it reads.
    pub read: u32,
    /// Its samples that the tiles to the right and below read.
    pub kept: u32,
    /// Tiles in a row of the frame.
    pub columns: u32,
}

impl Part {
    pub(super) fn round(&mut self, round: usize) -> &mut Round {
        if self.rounds.len() <= round {
            self.rounds.resize(round + 1, Round::default());
        }
        &mut self.rounds[round]
    }

    /// Adds what was tested and interpolated, round by round.
    pub fn count(&mut self, rounds: &[RoundCounts]) {
        for (number, counts) in rounds.iter().enumerate() {
            let &RoundCounts { tests, colours, interpolated, attributes, shaded, looked_back } = counts;
            let added = Round { tests, colours, interpolated, attributes, shaded, looked_back, starts: Vec::new() };
            add_round(self.round(number), added);
        }
    }

    /// The first round in which anything is done.
    fn first_round(&self) -> Option<u32> {
        let first = self.rounds.iter().position(|round| *round != Round::default());
        first.map(|first| first as u32)
    }

    /// Lets it begin after round `round`.
    pub fn begin_after(&mut self, round: u8) {
        if let Some(first) = self.first_round() {
            let later = (u32::from(round) + 1).saturating_sub(first);
            self.rounds.splice(0..0, std::iter::repeat_n(Round::default(), later as usize));
        }
    }

    /// Adds what is done of another tile, round by round.
    ///
    /// # Errors
    /// When the operations cannot be numbered.
    fn add(&mut self, other: Self, tile: &Tile) -> Result<()> {
        let (op_base, ray_base) = (self.ops.len() as u32, self.rays.len() as u32);
        if u32::try_from(self.ops.len() + other.ops.len()).is_err() {
            return Err(bad(tile, "its operations are more than a tile can have".into()));
        }
        self.ops.extend(other.ops);
        let moved = |ray: u32| if ray == NO_RAY { NO_RAY } else { ray + ray_base };
        self.rays.extend(other.rays.iter().map(|ray| RayWork {
            ops_start: ray.ops_start + op_base,
            reflect: moved(ray.reflect),
            refract: moved(ray.refract),
            ..*ray
        }));
        for (number, mut added) in other.rounds.into_iter().enumerate() {
            added.starts.iter_mut().for_each(|start| *start = moved(*start));
            add_round(self.round(number), added);
        }
        self.paths += other.paths;
        self.looked_up.extend(other.looked_up);
        Ok(())
    }

    /// Joins what a tile does of itself with what it `closes` of its neighbours and with what it does for its apron.
    ///
    /// # Errors
    /// When the operations cannot be numbered.
    pub fn join(
        mut self,
        closes: Closes,
        apron: Self,
        tile: &Tile,
        (borders, history): (Borders, impl FnOnce(&[u32]) -> HistoryWork),
    ) -> Result<Built> {
        let apron_samples = apron.samples;
        let before = |parts: &[Self]| parts.iter().filter_map(Self::first_round).min();
        let left = before(std::slice::from_ref(&closes.left));
        let left = left.map(|before| Neighbour { tile: tile.index - 1, rounds: 1, before });
        let above = before(&closes.above);
        let rounds = closes.above_rounds;
        let above = above.map(|before| Neighbour { tile: tile.index - borders.columns, rounds, before });
        let [straight, across] = closes.above;
        for part in [closes.left, straight, across, apron] {
            self.add(part, tile)?;
        }
        while self.rounds.last().is_some_and(|round| *round == Round::default()) {
            self.rounds.pop();
        }
        let Borders { read, kept, .. } = borders;
        let work = TileWork {
            frame: tile.frame,
            tile: tile.index,
            rect: tile.rect,
            left,
            above,
            apron_samples,
            border_samples: read,
            kept_samples: kept,
            audited_samples: self.audited_samples,
            secondary_hits: self.secondary_hits,
            history: history(&self.looked_up),
            rays: self.rays,
            ops: self.ops,
            rounds: self.rounds,
        };
        Ok(Built { work, paths: self.paths })
    }
}

/// Adds what is done in a round.
fn add_round(round: &mut Round, added: Round) {
    let Round { starts, tests, colours, interpolated, attributes, shaded, looked_back } = added;
    round.starts.extend(starts);
    round.tests += tests;
    round.colours += colours;
    round.interpolated += interpolated;
    round.attributes += attributes;
    round.shaded += shaded;
    round.looked_back += looked_back;
}

/// An error of a tile.
pub(super) fn bad(tile: &Tile, detail: String) -> ReplayError {
    ReplayError::Corrupt { frame: tile.frame, tile: tile.index, ray: None, detail }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounds were numbered by a `u8`: work of round 256 went into round 0.
    #[test]
    fn rounds_may_be_more_than_256() {
        let counts = |tests| RoundCounts { tests, ..RoundCounts::default() };
        let rounds: Vec<RoundCounts> = (0..300).map(counts).collect();
        let mut part = Part::default();
        part.count(&rounds);
        part.begin_after(9);
        assert_eq!((part.rounds.len(), part.rounds[9].tests, part.rounds[10].tests), (309, 0, 1));
        assert_eq!(part.rounds[308].tests, 299);
    }
}
