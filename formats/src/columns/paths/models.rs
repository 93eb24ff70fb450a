//! The models of a path's steps, and which of them the neighbours' labels select.

use crate::columns::coder::Bit;
use crate::columns::numbers::Symbol;

/// Neighbour labels of an inner node: not visited, or one of five outcomes; three bits each.
const OUTCOME_CONTEXTS: usize = 8 * 8 * 8 * 8;
/// Neighbour labels of a pop: none, visited, culled.
const POP_CONTEXTS: usize = 256;
/// Neighbour labels of a triangle test: none, missed, hit, passed.
const TEST_CONTEXTS: usize = 256;
/// How often the ray's last three steps were not as predicted: never, once, more.
const SURPRISES: usize = 3;

/// The models of one tile's uncertain steps.
pub(super) struct PathModels {
    /// Is the outcome the expected one?
    pub outcome: Vec<Bit>,
    /// Which one, if not: by the expected outcome and the next best guess.
    pub other: Vec<Symbol<8>>,
    /// The outcome where no neighbour met the node: by the label that was set there last and the label of the ray's
    /// last node.
    pub fresh: Vec<Symbol<8>>,
    /// Is the popped child visited?
    pub pop: Vec<Bit>,
    /// Are a leaf's tests as expected?
    pub leaf: [Bit; SURPRISES * 16],
    /// Is the triangle met?
    pub test: Vec<Bit>,
    /// Does the ray pass the triangle that it met?
    pub pass: Vec<Bit>,
}

impl PathModels {
    pub fn new() -> Self {
        Self {
            outcome: OUTCOME_PRIORS.repeat(SURPRISES),
            other: vec![Symbol::default(); 8 * 8],
            fresh: vec![Symbol::default(); 8 * 8],
            pop: vec![Bit::EVEN; SURPRISES * POP_CONTEXTS],
            leaf: [Bit::EVEN; SURPRISES * 16],
            test: vec![Bit::EVEN; SURPRISES * TEST_CONTEXTS],
            pass: vec![Bit::EVEN; TEST_CONTEXTS],
        }
    }
}

/// How many of the last three steps were surprises, at most two. `register` holds a bit a step, the newest lowest.
#[inline(always)]
pub(super) fn surprise_level(register: u8) -> usize {
    ((register & 0b111).count_ones() as usize).min(SURPRISES - 1)
}

/// Index into [`PathModels::outcome`].
#[inline(always)]
pub(super) fn outcome_model(context: usize, surprises: usize) -> usize {
    surprises * OUTCOME_CONTEXTS + context
}

/// Index into [`PathModels::pop`].
#[inline(always)]
pub(super) fn pop_model(context: usize, surprises: usize) -> usize {
    surprises * POP_CONTEXTS + context
}

/// Index into [`PathModels::test`].
#[inline(always)]
pub(super) fn test_model(context: usize, surprises: usize) -> usize {
    surprises * TEST_CONTEXTS + context
}

/// The label to expect, given those of the neighbours; 0 stands for no label. Where the label changes between
/// north-west and north, the edge is taken to go on downwards, between west and here. (The predictor of LOCO-I does the
/// same.)
pub(super) const fn expect(w: u8, n: u8, nw: u8, ne: u8) -> u8 {
    if n != 0 && (w == nw || w == 0) {
        n
    } else if w != 0 {
        w
    } else if ne != 0 {
        ne
    } else {
        nw
    }
}

/// What the neighbours let expect of an outcome.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expectation {
    /// [`expect`] of them.
    pub label: u8,
    /// How uncertain it is: 0 where all four agree, 1 where west and north agree and the others do or have no label, 2
    /// otherwise.
    pub doubt: u8,
}

/// The expectation by outcome context.
pub(super) static EXPECTED: [Expectation; OUTCOME_CONTEXTS] = {
    let mut table = [Expectation { label: 0, doubt: 2 }; OUTCOME_CONTEXTS];
    let mut i = 0;
    while i < OUTCOME_CONTEXTS {
        let (w, n, nw, ne) = ((i & 7) as u8, ((i >> 3) & 7) as u8, ((i >> 6) & 7) as u8, (i >> 9) as u8);
        let doubt = if n == 0 || w != n || (nw != n && nw != 0) || (ne != n && ne != 0) {
            2
        } else if nw == n && ne == n {
            0
        } else {
            1
        };
        table[i] = Expectation { label: expect(w, n, nw, ne), doubt };
        i += 1;
    }
    table
};

/// The outcome models of a new tile: the more neighbours agree with the expectation, the likelier it is.
static OUTCOME_PRIORS: [Bit; OUTCOME_CONTEXTS] = {
    const AGREE: [u32; 5] = [32_768, 52_000, 60_000, 63_500, 64_900];
    let mut table = [Bit::EVEN; OUTCOME_CONTEXTS];
    let mut i = 0;
    while i < OUTCOME_CONTEXTS {
        let labels = [i & 7, i >> 3 & 7, i >> 6 & 7, i >> 9];
        let (mut agree, mut against, mut k) = (0, false, 0);
        while k < 4 {
            if labels[k] == EXPECTED[i].label as usize {
                agree += 1;
            } else if labels[k] != 0 {
                against = true;
            }
            k += 1;
        }
        table[i] = Bit::of(if against { AGREE[agree] * 7 / 8 } else { AGREE[agree] }, 2);
        i += 1;
    }
    table
};
