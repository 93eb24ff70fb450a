//! The last columns and rows of a tile: they lie between its own R-samples and those of the tiles to its right and below.
//!
//! ```text
//!   R . . . R . . . | r       R: R-samples of the tile, r: of its neighbours
//!   .       .       |
//!   R . . . R right | r
//!   . below . corner|
//!   ----------------+--
//!   r . . . r . . . | r
//! ```
//!
//! Nothing of a neighbour that comes later is known while a tile is worked on. So whoever brings the samples that close a strip
//! does its tests and starts its rays.
//!
//! Where blocks are decided as cells with four corners, the strips begin with the tile's last R-samples: these are its own.

/// What was done in one round beside tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RoundCounts {
    /// Similarity tests: pairs of hits that were compared.
    pub tests: u32,
    /// Differences of colours that were computed for these tests.
    pub colours: u32,
    /// Hits and whole subtrees that were interpolated; one for a sample of which nothing was traced.
    pub interpolated: u32,
    /// Interpolated hits of which later tests may read the attributes.
    pub attributes: u32,
    /// Interpolated samples that were shaded from their attributes.
    pub shaded: u32,
    /// Hits whose lights were looked for in the history.
    pub looked_back: u32,
}

/// Who decides a sample of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closer {
    /// The tile itself.
    Itself,
    /// The tile to its right.
    Right,
    /// The tile below.
    Below,
    /// The tile to the right of the one below.
    Corner,
}

/// All there are.
pub const CLOSERS: [Closer; 4] = [Closer::Itself, Closer::Right, Closer::Below, Closer::Corner];

/// Where the strips begin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strips {
    /// First column that waits for the tile to the right.
    pub column: u32,
    /// First row that waits for the tile below.
    pub row: u32,
    /// R-samples never wait.
    pub cells: bool,
}

impl Default for Strips {
    /// Nothing waits.
    fn default() -> Self {
        Self { column: u32::MAX, row: u32::MAX, cells: false }
    }
}

impl Strips {
    #[inline]
    pub fn closer(&self, x: u32, y: u32) -> Closer {
        match (x >= self.column, y >= self.row) {
            (false, false) => Closer::Itself,
            (true, false) => Closer::Right,
            (false, true) => Closer::Below,
            (true, true) => Closer::Corner,
        }
    }
}

/// What is done beside tracing: by tile that does it, per round.
#[derive(Clone, Debug, Default)]
pub(super) struct RoundsByCloser {
    rounds: [Vec<RoundCounts>; CLOSERS.len()],
    /// The places that are looked up in the history.
    looked_up: [Vec<u32>; CLOSERS.len()],
}

impl RoundsByCloser {
    pub fn of(&self, closer: Closer) -> &[RoundCounts] {
        &self.rounds[closer as usize]
    }

    pub fn looked_up(&self, closer: Closer) -> &[u32] {
        &self.looked_up[closer as usize]
    }

    pub fn look_up(&mut self, closer: Closer, place: u32) {
        self.looked_up[closer as usize].push(place);
    }

    pub fn round_mut(&mut self, closer: Closer, round: u8) -> &mut RoundCounts {
        round_mut(&mut self.rounds[closer as usize], round)
    }
}

/// Round `round` of `rounds`, which grow as needed.
pub(super) fn round_mut(rounds: &mut Vec<RoundCounts>, round: u8) -> &mut RoundCounts {
    let round = usize::from(round);
    if rounds.len() <= round {
        rounds.resize(round + 1, RoundCounts::default());
    }
    &mut rounds[round]
}
