//! Walks the tree with a path and codes its steps.

use super::labels::{Cell, Labels, NeighbourLabels, PathNumbers};
use super::leaf;
use super::models::{
    EXPECTED, Expectation, PathModels, expect, outcome_context, outcome_model, pop_context, pop_model, surprise_level,
    test_model,
};
use super::rows::{CodedPath, Rows};
use super::runs::Run;
use super::topology::BvhTopology;
use crate::bvh::{Child, MAX_TREE_DEPTH};
use crate::columns::coder::{Bit, Coder};
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

/// Where a ray stands in the image and in its stream.
#[derive(Clone, Copy)]
pub(super) struct RayPosition {
    /// Column in the tile, from 1.
    pub x: usize,
    /// Row in the tile.
    pub y: u32,
    /// A shadow ray: it ends at the first hit.
    pub any_hit: bool,
}

/// A child put on the stack, the slot of the node that put it there, and what the neighbours did when they popped it.
#[derive(Clone, Copy)]
struct StackEntry {
    child: Child,
    slot: u32,
    context: u8,
}

/// Memory of the codec, reused from tile to tile.
#[derive(Debug, Default)]
pub struct PathScratch {
    nodes: Labels,
    leaves: Labels,
    pub(super) rows: Rows,
}

/// The coder of one tile's paths.
pub(super) struct PathCoder<'a, C, R> {
    pub coder: C,
    pub runs: [R; RUNS],
    topology: &'a BvhTopology,
    models: PathModels,
    pub scratch: &'a mut PathScratch,
    ring: PathNumbers,
    /// Is the path that of the west neighbour, or of the north one? See [`SAME_CONTEXTS`].
    same: [Bit; 2 * SAME_CONTEXTS],
    stack: [StackEntry; MAX_TREE_DEPTH],
    /// Which of the last steps were not as predicted, the newest in the lowest bit.
    surprises: u8,
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
        scratch.nodes.start(topology.children.len());
        scratch.leaves.start(topology.passes.len());
        let same = [Bit::EVEN; 2 * SAME_CONTEXTS];
        let stack = [StackEntry { child: Child::leaf(0, 0), slot: 0, context: 0 }; MAX_TREE_DEPTH];
        Self { coder, runs, topology, models: PathModels::new(), scratch, ring, same, stack, surprises: 0, budget }
    }
}

impl<C: Coder, R: Run> PathCoder<'_, C, R> {
    #[inline(always)]
    fn note(&mut self, met: bool) {
        self.surprises = self.surprises << 1 | u8::from(!met);
    }

    /// Codes the outcome of an inner node as a label (1 to 5), given its neighbours'.
    #[inline(always)]
    fn outcome(&mut self, slot: usize, around: &NeighbourLabels, last: u8, given: u8) -> u8 {
        let context = outcome_context(around);
        let Expectation { label: expected, doubt } = EXPECTED[context];
        if doubt < 2 && self.surprises & 7 == 0 {
            if self.runs[OUTCOME_RUN + usize::from(doubt)].as_expected(given == expected) {
                return expected;
            }
            self.note(false);
            return self.other(context, expected, given);
        }
        if context == 0 {
            let stale = self.scratch.nodes.last(slot);
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
        let context = usize::from(waiting.context);
        if (context == 0x55 || context == 0xaa) && self.surprises & 7 == 0 {
            let met = self.runs[POP_RUN].as_expected(given == (context == 0x55));
            self.note(met);
            return met == (context == 0x55);
        }
        let model = &mut self.models.pop[pop_model(context, surprise_level(self.surprises))];
        self.coder.bit(model, given)
    }

    /// Codes the tests of a leaf as a label: two bits a triangle.
    #[inline(always)]
    fn leaf(&mut self, leaf: Child, around: &NeighbourLabels, any_hit: bool, given: u8) -> u8 {
        let expected = expect(around.w, around.n, around.nw, around.ne);
        let same = |l: u8| l == expected;
        let agree = usize::from(same(around.w)) | usize::from(same(around.n)) << 1;
        let agree = agree | usize::from(same(around.nw)) << 2 | usize::from(same(around.ne)) << 3;
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
        self.tests(leaf, around, any_hit, given)
    }

    /// Codes a leaf's tests one by one.
    fn tests(&mut self, leaf: Child, around: &NeighbourLabels, any_hit: bool, given: u8) -> u8 {
        let mut label = 0;
        for (i, triangle) in leaf.triangles().enumerate() {
            let of = |l: u8| usize::from(l >> (2 * i) & 3);
            let context = of(around.ne) << 6 | of(around.nw) << 4 | of(around.n) << 2 | of(around.w);
            let value = of(given) as u8;
            let model = &mut self.models.test[test_model(context, surprise_level(self.surprises))];
            let met = self.coder.bit(model, value > leaf::MISS);
            let may_pass = self.topology.passes[triangle] >> u8::from(any_hit) & 1 != 0;
            let passes = met && may_pass && self.coder.bit(&mut self.models.pass[context], value == leaf::PASS);
            let coded = if passes { leaf::PASS } else { leaf::MISS + u8::from(met) };
            label |= coded << (2 * i);
            if any_hit && coded == leaf::HIT {
                break;
            }
        }
        label
    }

    /// Codes whether the path is that of the west or the north neighbour, and gives it if so. An encoder asks `equals`
    /// whether the path to be coded is that of a given ray.
    fn neighbours_path(
        &mut self,
        position: RayPosition,
        around: &[CodedPath; 4],
        equals: impl Fn(u32) -> bool,
    ) -> Option<CodedPath> {
        let [w, n, nw, ne] = around.map(|known| known.number);
        let context = usize::from(w == n) | usize::from(w == nw) << 1 | usize::from(n == nw) << 2;
        let context =
            context | usize::from(n == ne) << 3 | usize::from(n == 0) << 4 | usize::from(position.any_hit) << 5;
        for (side, known) in around.iter().take(2).enumerate() {
            if !self.ring.is_fresh(known.number) || side == 1 && n == w {
                continue;
            }
            let model = &mut self.same[side * SAME_CONTEXTS + context];
            let value = C::ENCODES && equals(known.ray);
            if self.coder.bit(model, value) {
                return Some(*known);
            }
        }
        None
    }

    /// Codes the path of ray `ray`: a neighbour's, or step by step. Gives the ray whose path it shares.
    ///
    /// # Errors
    /// Encoding: `given` is no path through this tree. Decoding: a step is impossible, or there are more than
    /// the budget.
    pub fn ray(
        &mut self,
        position: RayPosition,
        ray: u32,
        given: &[u8],
        equals: impl Fn(u32) -> bool,
        out: &mut Vec<u8>,
    ) -> Result<Option<u32>, &'static str> {
        self.scratch.rows.go_to(position.y);
        let around = self.scratch.rows.neighbours(position.x);
        if let Some(known) = self.neighbours_path(position, &around, equals) {
            self.scratch.rows.current[position.x] = known;
            return Ok(Some(known.ray));
        }
        let mut number = self.ring.number();
        let mut cells = around.map(|known| self.ring.cell(known.number));
        if number == 0 {
            self.scratch.nodes.forget();
            self.scratch.leaves.forget();
            let Rows { current, above, .. } = &mut self.scratch.rows;
            current.fill(CodedPath::default());
            above.fill(CodedPath::default());
            cells = [self.ring.cell(0); 4];
            number = self.ring.number();
        }
        let path = self.ring.cell(number);
        self.steps(position.any_hit, path, &cells, given, out)?;
        self.scratch.rows.current[position.x] = CodedPath { number, ray };
        Ok(None)
    }

    /// Codes a path step by step: `given` when encoding, appended to `out` when decoding.
    fn steps(
        &mut self,
        any_hit: bool,
        path: Cell,
        cells: &[Cell; 4],
        given: &[u8],
        out: &mut Vec<u8>,
    ) -> Result<(), &'static str> {
        let start = out.len();
        let mut walk = PathWalk { any_hit, path, cells, given: given.iter(), out, top: 0, hit: false, last: 0 };
        let mut current = Child::inner(0);
        self.surprises = 0;
        loop {
            let next = if current.is_leaf() {
                self.visit_leaf(&mut walk, current)?;
                None
            } else {
                self.visit_node(&mut walk, current.node())?
            };
            if any_hit && walk.hit {
                break;
            }
            current = match next {
                Some(child) => child,
                None => match self.next_waiting(&mut walk)? {
                    Some(child) => child,
                    None => break,
                },
            };
            if !C::ENCODES && (walk.out.len() - start) as u64 > self.budget {
                return Err("the paths have more steps than a tile may hold");
            }
        }
        if C::ENCODES && walk.given.next().is_some() {
            return Err("it goes on where the traversal ends");
        }
        self.budget = self.budget.saturating_sub((walk.out.len() - start) as u64);
        Ok(())
    }

    /// Codes what happens in a leaf.
    #[inline(always)]
    fn visit_leaf(&mut self, walk: &mut PathWalk<'_>, child: Child) -> Result<(), &'static str> {
        if child.count() == 0 {
            return Ok(());
        }
        let slot = self.scratch.leaves.slot(child.first());
        let around = self.scratch.leaves.around(slot, walk.cells);
        let given = if C::ENCODES { leaf::take(&mut walk.given, child.count(), walk.any_hit)? } else { 0 };
        let label = self.leaf(child, &around, walk.any_hit, given);
        if C::ENCODES && label != given {
            return Err("it passes a triangle that lets no ray through");
        }
        self.scratch.leaves.set(slot, walk.path, label);
        if !C::ENCODES {
            leaf::put(label, walk.out);
        }
        walk.hit |= leaf::has_hit(label);
        Ok(())
    }

    /// Codes what happens at an inner node, and gives the child to go on with.
    #[inline(always)]
    fn visit_node(&mut self, walk: &mut PathWalk<'_>, node: usize) -> Result<Option<Child>, &'static str> {
        let slot = self.scratch.nodes.slot(node);
        let around = self.scratch.nodes.around(slot, walk.cells);
        let given = match walk.given.next() {
            _ if !C::ENCODES => 0,
            Some(&step) if is_outcome(step) => step + 1,
            Some(_) => return Err("a step at an inner node is no outcome of its boxes"),
            None => return Err("it ends at an inner node"),
        };
        let label = self.outcome(slot, &around, walk.last, given);
        self.scratch.nodes.set(slot, walk.path, label);
        walk.last = label;
        if !C::ENCODES {
            if !is_outcome(label.wrapping_sub(1)) {
                return Err("a node visit has no such outcome");
            }
            walk.out.push(label - 1);
        }
        let [left, right] = self.topology.children[node];
        let (next, waiting) = match label - 1 {
            step::LEFT => return Ok(Some(left)),
            step::RIGHT => return Ok(Some(right)),
            step::LEFT_FIRST => (left, right),
            step::RIGHT_FIRST => (right, left),
            _ => return Ok(None),
        };
        self.stack[walk.top] = StackEntry { child: waiting, slot: slot as u32, context: pop_context(&around) as u8 };
        walk.top += 1;
        Ok(Some(next))
    }

    /// Codes pops until one is visited, and gives it.
    #[inline(always)]
    fn next_waiting(&mut self, walk: &mut PathWalk<'_>) -> Result<Option<Child>, &'static str> {
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
            let visited = walk.any_hit || !walk.hit || self.pop(waiting, given);
            if C::ENCODES && visited != given {
                return Err("it drops a child although nothing can hide it");
            }
            if !walk.any_hit {
                let label = if visited { 1 << 3 } else { 2 << 3 };
                self.scratch.nodes.add(waiting.slot as usize, walk.path, label);
            }
            if !C::ENCODES {
                walk.out.push(if visited { step::POP } else { step::CULLED });
            }
            if visited {
                return Ok(Some(waiting.child));
            }
        }
        Ok(None)
    }
}

/// Whether a step is an outcome of an inner node.
#[inline(always)]
fn is_outcome(step: u8) -> bool {
    step <= step::RIGHT_FIRST
}

/// A path on its way through the tree.
struct PathWalk<'a> {
    /// A shadow ray: it ends at the first hit.
    any_hit: bool,
    /// Where the path's labels go.
    path: Cell,
    /// Where the neighbours' labels are.
    cells: &'a [Cell; 4],
    /// Steps still to be encoded.
    given: std::slice::Iter<'a, u8>,
    /// Where decoded steps go.
    out: &'a mut Vec<u8>,
    /// Number of children put aside.
    top: usize,
    /// Something was hit.
    hit: bool,
    /// Label of the node visited last.
    last: u8,
}
