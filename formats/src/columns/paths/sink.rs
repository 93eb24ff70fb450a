//! Who takes decoded paths.

use super::leaf;
use crate::bvh::Child;
use crate::tile::step;

/// The tests that a ray makes in a leaf, in the order of its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafTests(pub(super) u8);

impl LeafTests {
    /// How many triangles are tested: all, but for a shadow ray, which ends at its first hit.
    #[inline(always)]
    pub fn count(self) -> u32 {
        (8 - self.0.leading_zeros()).div_ceil(2)
    }

    /// How many of them are hits.
    #[inline(always)]
    pub fn hits(self) -> u32 {
        leaf::hits(self.0).count_ones()
    }

    /// Which of them is the last hit; `None` if none is.
    #[inline(always)]
    pub fn last_hit(self) -> Option<u32> {
        let hits = leaf::hits(self.0);
        (hits != 0).then(|| (7 - hits.leading_zeros()) / 2)
    }
}

/// Takes the paths of a tile as a decoder finds them, step by step. What it is given is a valid path through the tree.
pub trait PathSink {
    /// An inner node is visited; `outcome` is one of [`step::NONE`] to [`step::RIGHT_FIRST`].
    fn visit(&mut self, node: u32, outcome: u8);

    /// The triangles of a leaf, of which there may be none, are tested.
    fn leaf(&mut self, leaf: Child, tests: LeafTests);

    /// A child that `node` deferred is taken from the stack, and `visited` or dropped.
    fn pop(&mut self, node: u32, visited: bool);

    /// The path ends: because the stack is `empty`, or a shadow ray hit something. `steps` is its length.
    fn end(&mut self, empty: bool, steps: u32);
}

/// Drops what it is given. An encoder has the steps already and needs no sink.
impl PathSink for () {
    #[inline(always)]
    fn visit(&mut self, _: u32, _: u8) {}
    #[inline(always)]
    fn leaf(&mut self, _: Child, _: LeafTests) {}
    #[inline(always)]
    fn pop(&mut self, _: u32, _: bool) {}
    #[inline(always)]
    fn end(&mut self, _: bool, _: u32) {}
}

/// Paths as bytes: one a step, see [`step`].
#[derive(Debug, Default)]
pub(super) struct Steps {
    pub steps: Vec<u8>,
    /// Per path where it starts and how long it is.
    pub spans: Vec<(u32, u32)>,
}

impl PathSink for Steps {
    #[inline(always)]
    fn visit(&mut self, _: u32, outcome: u8) {
        self.steps.push(outcome);
    }

    #[inline(always)]
    fn leaf(&mut self, _: Child, tests: LeafTests) {
        leaf::put(tests.0, &mut self.steps);
    }

    #[inline(always)]
    fn pop(&mut self, _: u32, visited: bool) {
        self.steps.push(if visited { step::POP } else { step::CULLED });
    }

    fn end(&mut self, _: bool, steps: u32) {
        self.spans.push((self.steps.len() as u32 - steps, steps));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_of_a_leaf_by_hand() {
        let [miss, hit, pass] = [leaf::MISS, leaf::HIT, leaf::PASS];
        let tests = |outcomes: &[u8]| LeafTests(outcomes.iter().rev().fold(0, |label, outcome| label << 2 | outcome));
        let found = |outcomes: &[u8]| {
            let tests = tests(outcomes);
            (tests.count(), tests.hits(), tests.last_hit())
        };
        assert_eq!(found(&[]), (0, 0, None));
        assert_eq!(found(&[miss]), (1, 0, None));
        assert_eq!(found(&[miss, pass, miss]), (3, 0, None));
        assert_eq!(found(&[hit]), (1, 1, Some(0)));
        assert_eq!(found(&[pass, hit, miss, hit]), (4, 2, Some(3)));
        assert_eq!(found(&[hit, hit, pass]), (3, 2, Some(1)));
    }
}
