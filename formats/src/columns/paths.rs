//! The paths column: the traversal path of every ray, coded against the tree and the paths of neighbouring rays.
//!
//! Rays are coded stream by stream (all rays of one class, then its shadow rays light by light) and in a stream row by row. What
//! a ray does at a node is predicted from what the rays to the left, above, above left and above right did *at that node*:
//! the projection of a box on the image has few edges, so a node is a small bilevel picture, coded as JBIG codes one. Per node the
//! coder therefore keeps a row of labels over the tile's columns.
//!
//! A path is self-delimiting: the decoder walks the tree, so lengths cost nothing, and steps that cannot be otherwise (pops
//! before any hit) are not coded at all.

use super::classes::{ClassRays, classes};
use super::coder::{Bit, Coder, Decoder, Encoder, Symbol};
use crate::bvh::{Bvh, Child, MAX_TREE_DEPTH};
use crate::limits::Limits;
use crate::scene::Rect;
use crate::tile::{Paths, Tree, step};

/// Neighbour labels of an inner node: not visited, or one of five outcomes.
const OUTCOMES: usize = 6;
const OUTCOME_CONTEXTS: usize = OUTCOMES * OUTCOMES * OUTCOMES * OUTCOMES;
/// Neighbour labels of a pop: none, visited, culled.
const POPS: usize = 3;
const POP_CONTEXTS: usize = POPS * POPS * POPS * POPS;
/// Neighbour labels of a triangle test: none, missed, hit, passed.
const TEST_CONTEXTS: usize = 256;
/// How often the ray was lately not as predicted: never, once, more.
const SURPRISES: usize = 3;

/// A label cell holds the row that wrote it above this bit, the label below.
const ROW_SHIFT: u32 = 16;
const ROW_MAX: u32 = 0xffff;

/// One row of labels over the columns of the tile, for each node (or leaf) that was visited.
#[derive(Debug, Default)]
struct Labels {
    /// Per node its place in `cells`, in rows, plus one.
    slots: Vec<u32>,
    visited: Vec<u32>,
    stride: usize,
    cells: Vec<u32>,
    /// Per slot the cell that was overwritten last: the row above's, to the left.
    overwritten: Vec<u32>,
}

/// The labels around a ray at one node: left, above, above left, above right; and whatever the column held last.
#[derive(Clone, Copy, Debug)]
struct Around {
    w: u32,
    n: u32,
    nw: u32,
    ne: u32,
    stale: u32,
}

impl Labels {
    fn start(&mut self, keys: usize, width: usize) {
        for &key in &self.visited {
            self.slots[key as usize] = 0;
        }
        self.slots.resize(keys, 0);
        self.visited.clear();
        self.cells.clear();
        self.overwritten.clear();
        self.stride = width + 2;
    }

    /// Forgets every label but keeps the slots: the row number is about to start again.
    fn forget(&mut self) {
        self.cells.fill(0);
        self.overwritten.fill(0);
    }

    #[inline(always)]
    fn slot(&mut self, key: usize) -> usize {
        let slot = self.slots[key];
        if slot != 0 {
            return slot as usize - 1;
        }
        self.visited.push(key as u32);
        self.slots[key] = self.visited.len() as u32;
        self.cells.resize(self.cells.len() + self.stride, 0);
        self.overwritten.push(0);
        self.visited.len() - 1
    }

    /// The labels around column `x` (from 1), in row `row`.
    #[inline(always)]
    fn around(&self, slot: usize, x: usize, row: u32) -> Around {
        let at = slot * self.stride + x;
        let cells: [u32; 3] = [self.cells[at - 1], self.cells[at], self.cells[at + 1]];
        let of = |cell: u32, row: u32| if cell >> ROW_SHIFT == row { cell & 0xffff } else { 0 };
        let w = of(cells[0], row);
        let left = if w != 0 { self.overwritten[slot] } else { cells[0] };
        Around {
            w,
            n: of(cells[1], row - 1),
            nw: of(left, row - 1),
            ne: of(cells[2], row - 1),
            stale: cells[1] & 0xffff,
        }
    }

    #[inline(always)]
    fn set(&mut self, slot: usize, x: usize, row: u32, label: u32) {
        let cell = &mut self.cells[slot * self.stride + x];
        self.overwritten[slot] = *cell;
        *cell = row << ROW_SHIFT | label;
    }

    #[inline(always)]
    fn add(&mut self, slot: usize, x: usize, bits: u32) {
        self.cells[slot * self.stride + x] |= bits;
    }
}

struct Models {
    /// Is the outcome the predicted one?
    outcome: Vec<Bit>,
    /// Which one, if not: by prediction.
    other: Vec<Symbol<8>>,
    /// Where no neighbour was: by the last label in this column and the step before.
    fresh: Vec<Symbol<8>>,
    pop: Vec<Bit>,
    test: Vec<Bit>,
    pass: Vec<Bit>,
}

/// The outcome to expect from the labels around, or 0.
static EXPECTED: [u8; OUTCOME_CONTEXTS] = {
    let mut table = [0; OUTCOME_CONTEXTS];
    let mut i = 0;
    while i < OUTCOME_CONTEXTS {
        let (w, n, nw, ne) = (i % 6, i / 6 % 6, i / 36 % 6, i / 216);
        // An edge between north-west and north runs on between west and here, as in LOCO-I.
        let vertical = w == nw && n != 0;
        table[i] = if w != 0 && !vertical {
            w
        } else if n != 0 {
            n
        } else if nw != 0 && nw == ne {
            nw
        } else if w != 0 {
            w
        } else if ne != 0 {
            ne
        } else {
            nw
        } as u8;
        i += 1;
    }
    table
};

/// Before anything is seen: the more neighbours agree with the prediction, the surer it is.
fn outcome_prior(context: usize) -> Bit {
    let expected = usize::from(EXPECTED[context]);
    let labels = [context % 6, context / 6 % 6, context / 36 % 6, context / 216];
    let agree = labels.iter().filter(|&&l| l == expected).count();
    let against = labels.iter().filter(|&&l| l != 0 && l != expected).count();
    const AGREE: [u32; 5] = [32_768, 52_000, 60_000, 63_500, 64_900];
    Bit::of(if against > 0 { AGREE[agree] * 7 / 8 } else { AGREE[agree] }, 2)
}

impl Models {
    fn new() -> Self {
        let outcome = (0..SURPRISES * OUTCOME_CONTEXTS).map(|i| outcome_prior(i % OUTCOME_CONTEXTS)).collect();
        Self {
            outcome,
            other: vec![Symbol::default(); OUTCOMES * OUTCOMES],
            fresh: vec![Symbol::default(); OUTCOMES * OUTCOMES],
            pop: vec![Bit::EVEN; SURPRISES * POP_CONTEXTS],
            test: vec![Bit::EVEN; SURPRISES * TEST_CONTEXTS],
            pass: vec![Bit::EVEN; TEST_CONTEXTS],
        }
    }
}

/// Memory of the codec, reused from tile to tile.
#[derive(Debug, Default)]
pub struct PathScratch {
    nodes: Labels,
    leaves: Labels,
}

/// Where a ray stands in the image and in its stream.
#[derive(Clone, Copy)]
struct Place {
    /// Column in the tile, from 1.
    x: usize,
    /// Row number, counted over all streams.
    row: u32,
    /// A shadow ray: it ends at the first hit.
    any: bool,
}

/// The coder of one tile's paths.
struct PathCoder<'a, C> {
    coder: C,
    bvh: &'a Bvh,
    models: Models,
    scratch: &'a mut PathScratch,
    /// Shift register of surprises, newest lowest.
    surprises: u8,
    /// Most steps that may still be decoded.
    budget: u64,
}

/// A child put aside, the node that put it there, and the pop context of its neighbours.
#[derive(Clone, Copy)]
struct Waiting {
    child: Child,
    slot: u32,
    context: u16,
}

impl<C: Coder> PathCoder<'_, C> {
    #[inline(always)]
    fn surprise(&self) -> usize {
        ((self.surprises & 0b111).count_ones() as usize).min(SURPRISES - 1)
    }

    /// Codes the outcome of an inner node: its step value, and the pop context for a child put aside.
    #[inline(always)]
    fn outcome(&mut self, node: usize, place: Place, last: u8, given: u8) -> (u8, usize, usize) {
        let slot = self.scratch.nodes.slot(node);
        let around = self.scratch.nodes.around(slot, place.x, place.row);
        let of = |label: u32| (label & 7) as usize;
        let context = ((of(around.ne) * 6 + of(around.nw)) * 6 + of(around.n)) * 6 + of(around.w);
        let given = usize::from(given) + 1;
        let outcome = if context == 0 {
            let models = &mut self.models.fresh[of(around.stale) * OUTCOMES + usize::from(last)];
            models.code(&mut self.coder, given & 7)
        } else {
            let expected = usize::from(EXPECTED[context]);
            let surprise = self.surprise();
            let model = &mut self.models.outcome[surprise * OUTCOME_CONTEXTS + context];
            let met = self.coder.bit(model, given == expected);
            self.surprises = self.surprises << 1 | u8::from(!met);
            if met {
                expected
            } else {
                let second = if of(around.n) != expected { of(around.n) } else { of(around.w) };
                let models = &mut self.models.other[expected * OUTCOMES + second];
                models.code(&mut self.coder, given & 7)
            }
        };
        self.scratch.nodes.set(slot, place.x, place.row, outcome as u32);
        let pop = |label: u32| (label >> 3 & 3) as usize;
        let pop = ((pop(around.ne) * 3 + pop(around.nw)) * 3 + pop(around.n)) * 3 + pop(around.w);
        (outcome.wrapping_sub(1) as u8, slot, pop)
    }

    /// Codes whether a popped child is visited.
    #[inline(always)]
    fn pop(&mut self, waiting: Waiting, place: Place, certain: bool, given: u8) -> bool {
        let visited = certain || {
            let surprise = self.surprise();
            let model = &mut self.models.pop[surprise * POP_CONTEXTS + usize::from(waiting.context)];
            self.coder.bit(model, given == step::POP)
        };
        self.scratch.nodes.add(waiting.slot as usize, place.x, if visited { 1 << 3 } else { 2 << 3 });
        visited
    }

    /// Codes the tests of a leaf's triangles from `given` on; calls `emit` with each. True when the ray ends here.
    #[inline(always)]
    fn leaf(&mut self, leaf: Child, place: Place, given: &[u8], out: &mut Vec<u8>, hit: &mut bool) -> (usize, bool) {
        if leaf.count() == 0 {
            return (0, false);
        }
        let slot = self.scratch.leaves.slot(leaf.first());
        let around = self.scratch.leaves.around(slot, place.x, place.row);
        let mut label = 0;
        for (i, triangle) in leaf.triangles().enumerate() {
            let of = |l: u32| (l >> (2 * i) & 3) as usize;
            let context = (of(around.ne) << 6) | of(around.nw) << 4 | of(around.n) << 2 | of(around.w);
            let value = if C::ENCODES { given[i] } else { 0 };
            let surprise = self.surprise();
            let met = self.coder.bit(&mut self.models.test[surprise * TEST_CONTEXTS + context], value != step::MISS);
            let passes = met
                && self.bvh.material(triangle).may_pass(place.any)
                && self.coder.bit(&mut self.models.pass[context], value == step::PASS);
            let coded = match (met, passes) {
                (false, _) => step::MISS,
                (true, false) => step::HIT,
                (true, true) => step::PASS,
            };
            label |= u32::from(coded - step::MISS + 1) << (2 * i);
            if !C::ENCODES {
                out.push(coded);
            }
            if coded == step::HIT {
                *hit = true;
                if place.any {
                    self.scratch.leaves.set(slot, place.x, place.row, label);
                    return (i + 1, true);
                }
            }
        }
        self.scratch.leaves.set(slot, place.x, place.row, label);
        (leaf.count(), false)
    }

    /// Codes one path: `given` when encoding, appended to `out` when decoding.
    fn ray(&mut self, place: Place, given: &[u8], out: &mut Vec<u8>) -> Result<(), String> {
        let start = out.len();
        let mut stack = [Waiting { child: Child::leaf(0, 0), slot: 0, context: 0 }; MAX_TREE_DEPTH];
        let (mut top, mut at, mut hit, mut last) = (0, 0, false, 0);
        let mut current = Child::inner(0);
        self.surprises = 0;
        loop {
            if (out.len() - start) as u64 > self.budget {
                return Err("the paths have more steps than a tile may hold".into());
            }
            if current.is_leaf() {
                let rest = if C::ENCODES { &given[at..] } else { given };
                let (tests, ends) = self.leaf(current, place, rest, out, &mut hit);
                at += tests;
                if ends {
                    break;
                }
            } else {
                let node = current.node();
                let value = if C::ENCODES { given[at] } else { 0 };
                let (outcome, slot, context) = self.outcome(node, place, last, value);
                at += 1;
                if !C::ENCODES {
                    out.push(outcome);
                }
                last = outcome;
                let [left, right] = self.bvh.nodes[node].children;
                let (first, second) = match outcome {
                    step::NONE => (None, None),
                    step::LEFT => (Some(left), None),
                    step::RIGHT => (Some(right), None),
                    step::LEFT_FIRST => (Some(left), Some(right)),
                    step::RIGHT_FIRST => (Some(right), Some(left)),
                    _ => return Err("a node visit has no such outcome".into()),
                };
                if let Some(child) = second {
                    stack[top] = Waiting { child, slot: slot as u32, context: context as u16 };
                    top += 1;
                }
                if let Some(child) = first {
                    current = child;
                    continue;
                }
            }
            let mut next = None;
            while next.is_none() && top > 0 {
                top -= 1;
                let value = if C::ENCODES { given[at] } else { 0 };
                // Until something is hit, nothing can hide a child.
                let visited = self.pop(stack[top], place, place.any || !hit, value);
                at += 1;
                if !C::ENCODES {
                    out.push(if visited { step::POP } else { step::CULLED });
                }
                next = visited.then_some(stack[top].child);
            }
            match next {
                Some(child) => current = child,
                None => break,
            }
        }
        self.budget -= (out.len() - start) as u64;
        Ok(())
    }
}

/// The streams of a tile: for each the light (`None` for closest-hit rays) and per ray its sample and ray number.
fn streams(tree: &Tree, lights: usize) -> Vec<(bool, Vec<(u32, u32)>)> {
    let index = tree.ray_index();
    let mut streams = Vec::new();
    for ClassRays { rays, .. } in classes(tree) {
        let mut shadows = vec![Vec::new(); lights];
        for &(sample, node) in &rays {
            let cast = tree.nodes[node as usize].shadows.cast();
            for (rank, light) in cast.enumerate() {
                shadows[light].push((sample, index[node as usize] + 1 + rank as u32));
            }
        }
        streams.push((false, rays.iter().map(|&(sample, node)| (sample, index[node as usize])).collect()));
        streams.extend(shadows.into_iter().filter(|s| !s.is_empty()).map(|s| (true, s)));
    }
    streams
}

/// Walks the rays of a tile in coding order.
fn each_ray<C: Coder>(
    paths: &mut PathCoder<'_, C>,
    tree: &Tree,
    rect: Rect,
    lights: usize,
    mut ray: impl FnMut(&mut PathCoder<'_, C>, Place, usize) -> Result<(), String>,
) -> Result<(), String> {
    let mut row = 1;
    for (any, rays) in streams(tree, lights) {
        // A gap of one row number: the last row of one stream is not above the first of the next.
        if row + rect.height + 2 > ROW_MAX {
            paths.scratch.nodes.forget();
            paths.scratch.leaves.forget();
            row = 1;
        }
        for (sample, number) in rays {
            let (x, y) = (sample % rect.width, sample / rect.width);
            let place = Place { x: x as usize + 1, row: row + 1 + y, any };
            ray(paths, place, number as usize)?;
        }
        row += rect.height + 1;
    }
    Ok(())
}

fn start<'a, C>(coder: C, bvh: &'a Bvh, rect: Rect, scratch: &'a mut PathScratch, budget: u64) -> PathCoder<'a, C> {
    scratch.nodes.start(bvh.nodes.len(), rect.width as usize);
    scratch.leaves.start(bvh.triangles.len(), rect.width as usize);
    PathCoder { coder, bvh, models: Models::new(), scratch, surprises: 0, budget }
}

/// Codes the paths of a tile.
pub fn encode(paths: &Paths, tree: &Tree, rect: Rect, lights: usize, bvh: &Bvh, scratch: &mut PathScratch) -> Vec<u8> {
    let mut coder = start(Encoder::default(), bvh, rect, scratch, u64::MAX);
    let coded = each_ray(&mut coder, tree, rect, lights, |coder, place, ray| {
        coder.ray(place, paths.ray(ray), &mut Vec::new())
    });
    debug_assert!(coded.is_ok(), "the tracer records only paths of its own tree");
    coder.coder.finish()
}

/// Decodes the paths of a tile.
///
/// # Errors
/// Says so when a step is impossible or there are more than `limits` allow.
pub fn decode(
    bytes: &[u8],
    tree: &Tree,
    rect: Rect,
    lights: usize,
    bvh: &Bvh,
    limits: &Limits,
    scratch: &mut PathScratch,
) -> Result<Paths, String> {
    let mut coder = start(Decoder::new(bytes), bvh, rect, scratch, limits.max_path_steps_per_tile);
    let mut out = Paths { steps: Vec::new(), spans: vec![(0, 0); tree.ray_count() as usize] };
    let Paths { steps, spans } = &mut out;
    each_ray(&mut coder, tree, rect, lights, |coder, place, ray| {
        let start = steps.len();
        coder.ray(place, &[], steps)?;
        spans[ray] = (start as u32, (steps.len() - start) as u32);
        Ok(())
    })?;
    Ok(out)
}
