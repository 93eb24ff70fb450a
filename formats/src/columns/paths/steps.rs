//! Walks the tree with a path and codes its steps.

use super::labels::{NeighbourLabels, PathNumbers};
use super::leaf;
use super::met::{MetTree, Place};
use super::models::{EXPECTED, Expectation, PathModels, expect, outcome_model, pop_model, surprise_level, test_model};
use super::runs::Run;
use super::sink::{LeafTests, PathSink};
use super::topology::BvhTopology;
use super::walk::{Coded, CodedPath, PathWalk, RayPlace, StackEntry};
use crate::bvh::MAX_TREE_DEPTH;
use crate::columns::coder::{Bit, Coder};
use crate::columns::rows::Rows;
use crate::tile::step;

/// Number of run streams: two for outcomes, two for leaves, one for pops.
pub(super) const RUNS: usize = 5;
/// Outcomes on which all four neighbours agree; the next stream takes those on which fewer do.
const OUTCOME_RUN: usize = 0;
/// The same for leaves.
const LEAF_RUN: usize = 2;
/// Pops on which all four neighbours agree.
const POP_RUN: usize = 4;

/// Contexts of the question whether a path is a neighbour's: which of the neighbours share a path, and whether the ray
/// is a shadow ray.
const SAME_CONTEXTS: usize = 64;

/// Memory of the codec, reused from tile to tile.
#[derive(Debug, Default)]
pub struct PathScratch {
    met: MetTree,
    pub(super) rows: Rows<CodedPath>,
}

/// What steps are coded with.
pub(super) struct StepCoder<C, R> {
    pub coder: C,
    pub runs: [R; RUNS],
    models: PathModels,
    /// Which of the last steps were not as predicted, the newest in the lowest bit.
    surprises: u8,
}

/// The coder of one tile's paths.
pub(super) struct PathCoder<'a, C, R> {
    pub code: StepCoder<C, R>,
    topology: &'a BvhTopology,
    pub scratch: &'a mut PathScratch,
    ring: PathNumbers,
    /// Is the path that of the west neighbour, or of the north one? See [`SAME_CONTEXTS`].
    same: [Bit; 2 * SAME_CONTEXTS],
    stack: [StackEntry; MAX_TREE_DEPTH],
    /// Most steps that may still be decoded.
    budget: u64,
}

impl<'a, C: Coder, R: Run> PathCoder<'a, C, R> {
    /// A coder at the start of a tile; at most `budget` steps are decoded.
    pub fn new(
        coder: C,
        runs: [R; RUNS],
        topology: &'a BvhTopology,
        scratch: &'a mut PathScratch,
        budget: u64,
    ) -> Self {
        let ring = PathNumbers::new();
        scratch.met.start(topology);
        let same = [Bit::EVEN; 2 * SAME_CONTEXTS];
        let stack = [StackEntry::default(); MAX_TREE_DEPTH];
        let code = StepCoder { coder, runs, models: PathModels::new(), surprises: 0 };
        Self { code, topology, scratch, ring, same, stack, budget }
    }
}

impl<C: Coder, R: Run> StepCoder<C, R> {
    #[inline(always)]
    fn note(&mut self, met: bool) {
        self.surprises = self.surprises << 1 | u8::from(!met);
    }

    /// Codes the outcome of an inner node as a label (1 to 5), given its neighbours', the one that was set there last, and
    /// that of the ray's last node.
    #[inline(always)]
    fn outcome(&mut self, around: NeighbourLabels, stale: u8, last: u8, given: u8) -> u8 {
        let context = around.outcomes();
        let Expectation { label: expected, doubt } = EXPECTED[context];
        if doubt < 2 && self.surprises & 7 == 0 {
            if self.runs[OUTCOME_RUN + usize::from(doubt)].as_expected(given == expected) {
                return expected;
            }
            self.note(false);
            return self.other(context, expected, given);
        }
        if context == 0 {
            let models = &mut self.models.fresh[usize::from(stale & 7) * 8 + usize::from(last)];
            return models.code(&mut self.coder, usize::from(given)) as u8;
        }
        let model = &mut self.models.outcome[outcome_model(context, surprise_level(self.surprises))];
        let met = self.coder.bit(model, given == expected);
        self.note(met);
        if met { expected } else { self.other(context, expected, given) }
    }

    /// Codes an outcome that is not the expected one.
    fn other(&mut self, context: usize, expected: u8, given: u8) -> u8 {
        let (w, n) = (context & 7, context >> 3 & 7);
        let second = if n != usize::from(expected) { n } else { w };
        self.models.other[usize::from(expected) * 8 + second].code(&mut self.coder, usize::from(given)) as u8
    }

    /// Codes whether a popped child is visited.
    #[inline(always)]
    fn pop(&mut self, waiting: StackEntry, given: bool) -> bool {
        let context = waiting.around.pops();
        if (context == 0x55 || context == 0xaa) && self.surprises & 7 == 0 {
            let met = self.runs[POP_RUN].as_expected(given == (context == 0x55));
            self.note(met);
            return met == (context == 0x55);
        }
        let model = &mut self.models.pop[pop_model(context, surprise_level(self.surprises))];
        self.coder.bit(model, given)
    }

    /// Codes the tests of a leaf as a label: two bits a triangle. `passes` says of each which rays it lets through.
    #[inline(always)]
    fn leaf(&mut self, passes: &[u8], around: NeighbourLabels, any_hit: bool, given: u8) -> u8 {
        let [w, n, nw, ne] = around.list();
        let expected = expect(w, n, nw, ne);
        let same = |l: u8| usize::from(l == expected);
        let agree = same(w) | same(n) << 1 | same(nw) << 2 | same(ne) << 3;
        if expected != 0 {
            let met = if (agree == 0xf || agree == 7) && self.surprises & 7 == 0 {
                self.runs[LEAF_RUN + usize::from(agree == 7)].as_expected(given == expected)
            } else {
                let model = &mut self.models.leaf[surprise_level(self.surprises) * 16 + agree];
                self.coder.bit(model, given == expected)
            };
            self.note(met);
            if met {
                return expected;
            }
        }
        self.tests(passes, around, any_hit, given)
    }

    /// Codes a leaf's tests one by one.
    fn tests(&mut self, passes: &[u8], around: NeighbourLabels, any_hit: bool, given: u8) -> u8 {
        let [w, n, nw, ne] = around.list();
        let mut label = 0;
        for (i, passes) in passes.iter().enumerate() {
            let of = |l: u8| usize::from(l >> (2 * i) & 3);
            let context = of(ne) << 6 | of(nw) << 4 | of(n) << 2 | of(w);
            let value = of(given) as u8;
            let model = &mut self.models.test[test_model(context, surprise_level(self.surprises))];
            let met = self.coder.bit(model, value > leaf::MISS);
            let may_pass = passes >> u8::from(any_hit) & 1 != 0;
            let passes = met && may_pass && self.coder.bit(&mut self.models.pass[context], value == leaf::PASS);
            let coded = if passes { leaf::PASS } else { leaf::MISS + u8::from(met) };
            label |= coded << (2 * i);
            if any_hit && coded == leaf::HIT {
                break;
            }
        }
        label
    }
}

impl<C: Coder, R: Run> PathCoder<'_, C, R> {
    /// Codes whether the path is that of the west or the north neighbour, and gives it if so. An encoder asks `equals`
    /// whether the path to be coded is that of a given ray.
    fn neighbours_path(
        &mut self,
        any_hit: bool,
        around: &[CodedPath; 4],
        equals: impl Fn(u32) -> bool,
    ) -> Option<CodedPath> {
        let [w, n, nw, ne] = around.map(|known| known.number);
        let context = usize::from(w == n) | usize::from(w == nw) << 1 | usize::from(n == nw) << 2;
        let context = context | usize::from(n == ne) << 3 | usize::from(n == 0) << 4 | usize::from(any_hit) << 5;
        for (side, known) in around.iter().take(2).enumerate() {
            if !self.ring.is_fresh(known.number) || side == 1 && n == w {
                continue;
            }
            let model = &mut self.same[side * SAME_CONTEXTS + context];
            let value = C::ENCODES && equals(known.ray);
            if self.code.coder.bit(model, value) {
                return Some(*known);
            }
        }
        None
    }

    /// Codes the path of a ray: a neighbour's, or step by step. Then it goes to `sink`, if it is decoded.
    ///
    /// # Errors
    /// Encoding: `given` is no path through this tree. Decoding: a step is impossible, or there are more than
    /// the budget.
    pub fn ray<S: PathSink>(
        &mut self,
        place: RayPlace,
        given: &[u8],
        equals: impl Fn(u32) -> bool,
        sink: &mut S,
    ) -> Result<Coded, &'static str> {
        let RayPlace { sample, ray, any_hit } = place;
        let x = self.scratch.rows.go_to(sample);
        let around = self.scratch.rows.around(x).list();
        if let Some(known) = self.neighbours_path(any_hit, &around, equals) {
            self.scratch.rows.set(x, known);
            return Ok(Coded::Like(known.ray));
        }
        let mut number = self.ring.number();
        let mut cells = around.map(|known| self.ring.cell(known.number));
        if number == 0 {
            self.scratch.met.forget();
            self.scratch.rows.forget();
            cells = [self.ring.cell(0); 4];
            number = self.ring.number();
        }
        let path = self.ring.cell(number);
        let given = given.iter();
        let mut walk = PathWalk { any_hit, path, cells: &cells, given, sink, steps: 0, top: 0, hit: false, last: 0 };
        self.steps(&mut walk)?;
        self.scratch.rows.set(x, CodedPath { number, ray });
        Ok(Coded::Steps(walk.steps))
    }

    /// Codes a path step by step.
    fn steps<S: PathSink>(&mut self, walk: &mut PathWalk<'_, S>) -> Result<(), &'static str> {
        let mut place = Place::ROOT;
        self.code.surprises = 0;
        loop {
            let next = if place.child.is_leaf() {
                self.visit_leaf(walk, place)?;
                None
            } else {
                self.visit_node(walk, place.slot)?
            };
            if walk.any_hit && walk.hit {
                break;
            }
            place = match next {
                Some(place) => place,
                None => match self.next_waiting(walk)? {
                    Some(place) => place,
                    None => break,
                },
            };
            if !C::ENCODES && u64::from(walk.steps) > self.budget {
                return Err(TOO_MANY_STEPS);
            }
        }
        // A path can end before it is looked at above, and a tile has many.
        if !C::ENCODES && u64::from(walk.steps) > self.budget {
            return Err(TOO_MANY_STEPS);
        }
        if C::ENCODES && walk.given.next().is_some() {
            return Err("it goes on where the traversal ends");
        }
        walk.sink.end(!(walk.any_hit && walk.hit), walk.steps);
        self.budget = self.budget.saturating_sub(walk.steps.into());
        Ok(())
    }

    /// Codes what happens in a leaf.
    #[inline(always)]
    fn visit_leaf<S: PathSink>(&mut self, walk: &mut PathWalk<'_, S>, place: Place) -> Result<(), &'static str> {
        let Place { child, slot } = place;
        if child.count() == 0 {
            walk.sink.leaf(child, LeafTests(0));
            return Ok(());
        }
        let ring = self.scratch.met.leaf_labels.ring(slot);
        let around = ring.around(walk.cells);
        let given = if C::ENCODES { leaf::take(&mut walk.given, child.count(), walk.any_hit)? } else { 0 };
        let passes = &self.topology.passes[child.triangles()];
        let label = self.code.leaf(passes, around, walk.any_hit, given);
        if C::ENCODES && label != given {
            return Err("it passes a triangle that lets no ray through");
        }
        ring.set(walk.path, label);
        let tests = LeafTests(label);
        walk.steps += tests.count();
        walk.sink.leaf(child, tests);
        walk.hit |= leaf::hits(label) != 0;
        Ok(())
    }

    /// Codes what happens at an inner node, and gives the child to go on with.
    #[inline(always)]
    fn visit_node<S: PathSink>(
        &mut self,
        walk: &mut PathWalk<'_, S>,
        slot: u32,
    ) -> Result<Option<Place>, &'static str> {
        let met = &mut self.scratch.met;
        let ring = met.node_labels.ring(slot);
        let around = ring.around(walk.cells);
        let given = match walk.given.next() {
            _ if !C::ENCODES => 0,
            Some(&step) if is_outcome(step) => step + 1,
            Some(_) => return Err("a step at an inner node is no outcome of its boxes"),
            None => return Err("it ends at an inner node"),
        };
        let label = self.code.outcome(around, ring.last(), walk.last, given);
        if !C::ENCODES && !is_outcome(label.wrapping_sub(1)) {
            return Err("a node visit has no such outcome");
        }
        ring.set(walk.path, label);
        let outcome = label - 1;
        (walk.last, walk.steps) = (label, walk.steps + 1);
        let node = met.node(slot);
        walk.sink.visit(node.number, outcome);
        if outcome == step::NONE {
            return Ok(None);
        }
        // Which children there are is hard to foresee, for a processor too. So there is no branch: an entry is written in
        // any case, and stays where there are two children.
        let side = TO_RIGHT >> outcome & 1;
        self.stack[walk.top] = StackEntry::new(slot, side ^ 1, around);
        walk.top += usize::from(outcome >= step::LEFT_FIRST);
        let place = node.child(side);
        Ok(Some(place.unwrap_or_else(|| met.meet(slot, side, self.topology))))
    }

    /// Codes pops until one is visited, and gives it.
    #[inline(always)]
    fn next_waiting<S: PathSink>(&mut self, walk: &mut PathWalk<'_, S>) -> Result<Option<Place>, &'static str> {
        while walk.top > 0 {
            walk.top -= 1;
            let waiting = self.stack[walk.top];
            let given = match walk.given.next() {
                _ if !C::ENCODES => false,
                Some(&step::POP) => true,
                Some(&step::CULLED) => false,
                _ => return Err("it ends, or does something else, where a child is popped"),
            };
            // Until something is hit, nothing can hide a child.
            let visited = walk.any_hit || !walk.hit || self.code.pop(waiting, given);
            if C::ENCODES && visited != given {
                return Err("it drops a child although nothing can hide it");
            }
            let met = &mut self.scratch.met;
            if !walk.any_hit {
                let label = if visited { 1 << 3 } else { 2 << 3 };
                met.node_labels.ring(waiting.slot()).add(walk.path, label);
            }
            let node = met.node(waiting.slot());
            walk.steps += 1;
            walk.sink.pop(node.number, visited);
            if visited {
                let place = node.child(waiting.side());
                return Ok(Some(place.unwrap_or_else(|| met.meet(waiting.slot(), waiting.side(), self.topology))));
            }
        }
        Ok(None)
    }
}

/// What is said of paths that do not end where they should.
const TOO_MANY_STEPS: &str = "the paths have more steps than the directory promises, or than a tile may hold";

/// Whether a step is an outcome of an inner node.
#[inline(always)]
fn is_outcome(step: u8) -> bool {
    step <= step::RIGHT_FIRST
}

/// Outcomes after which the right child comes next (bit = outcome).
const TO_RIGHT: u8 = 1 << step::RIGHT | 1 << step::RIGHT_FIRST;
