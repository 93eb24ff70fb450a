//! The inputs from which others are made: the first ones, and those that led to something new.

use std::collections::BTreeMap;

use crate::coverage::Seen;
use crate::mutate::{change, words};
use crate::random::Random;
use crate::target::Target;

/// Most inputs that are kept.
const KEPT_MAX: usize = 3000;

/// The inputs of one target.
#[derive(Debug)]
pub struct Kept {
    /// The inputs, in the order in which they came.
    pub inputs: Vec<Vec<u8>>,
    /// What has been said, without numbers and names, and the shortest input that led to it.
    said: BTreeMap<u64, usize>,
    words: Vec<Vec<u8>>,
    /// What code ran, where that is counted.
    pub seen: Seen,
}

impl Kept {
    /// Begins with these.
    pub fn new(seeds: Vec<Vec<u8>>) -> Self {
        Self { words: words(&seeds), inputs: seeds, said: BTreeMap::new(), seen: Seen::new() }
    }

    /// Another input, made from those that are kept.
    pub fn next(&self, target: &Target, random: &mut Random) -> Vec<u8> {
        let count = self.inputs.len();
        // What came last is worth more: nobody has looked around it yet.
        let at = if random.once_in(2) { count - 1 - random.below(count.min(32)) } else { random.below(count) };
        let mut bytes = self.inputs[at].clone();
        match target.change {
            Some(lie) => lie(&mut bytes, random),
            None => {
                let other = &self.inputs[random.below(count)][..];
                change(&mut bytes, &[other], &self.words, random);
            }
        }
        if let Some(mend) = target.mend.filter(|_| !random.once_in(16)) {
            mend(&mut bytes);
        }
        bytes
    }

    /// Takes in what became of an input. If it led to something new it is kept; where there are too many, in place of another.
    pub fn learn(&mut self, bytes: &[u8], said: &str, random: &mut Random) {
        let new_code = self.seen.take();
        let signature = signature(said);
        let shorter = |known: &usize| bytes.len() < self.inputs[*known].len() / 2;
        if !new_code && !self.said.get(&signature).is_none_or(shorter) {
            return;
        }
        let at = if self.inputs.len() < KEPT_MAX { self.inputs.len() } else { random.below(KEPT_MAX) };
        self.inputs.resize(self.inputs.len().max(at + 1), Vec::new());
        self.inputs[at] = bytes.to_vec();
        self.said.insert(signature, at);
    }

    /// The shortest inputs of different messages, at most so many and so long each.
    pub fn best(&self, most: usize, longest: usize) -> Vec<&[u8]> {
        let mut best: Vec<&[u8]> =
            self.said.values().map(|at| &self.inputs[*at][..]).filter(|bytes| bytes.len() <= longest).collect();
        best.sort_by_key(|bytes| (bytes.len(), *bytes));
        best.dedup();
        best.truncate(most);
        best
    }

    /// How many different things were said.
    pub fn messages(&self) -> usize {
        self.said.len()
    }
}

/// A message without what depends on the input: numbers, names, and what stands in quotes. Of the rest the beginning.
fn signature(said: &str) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut quoted = None;
    let mut letters = 0;
    for c in said.chars().take(2000) {
        match quoted {
            Some(end) if c == end => quoted = None,
            Some(_) => {}
            None if matches!(c, '`' | '"') => quoted = Some(c),
            None if c.is_ascii_alphabetic() && letters < 120 => {
                letters += 1;
                hash = (hash ^ u64::from(c)).wrapping_mul(0x0100_0000_01b3);
            }
            None => {}
        }
    }
    hash
}
