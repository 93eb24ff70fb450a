//! The paths column: the traversal path of every ray, coded against the tree and the paths of neighbouring rays.
//!
//! Rays are coded stream by stream (all rays of one class, then its shadow rays light by light) and in a stream row by row. What
//! a ray does at a node is predicted from what the rays to the left, above, above left and above right did *at that node*:
//! the projection of a box on the image has few edges, so each node is a small picture, coded as JBIG codes one. Where all
//! four agree, only surprises cost anything ([`runs`]); elsewhere a step is an adaptive bit in the context of the four.
//!
//! A path is self-delimiting: the decoder walks the tree, so lengths cost nothing, and steps that cannot be otherwise (pops
//! before any hit) are not coded at all.

mod labels;
mod models;
mod runs;

use super::classes::{ClassRays, Order};
use super::coder::{Bit, Coder, Decoder, Encoder};
use crate::bvh::{Bvh, Child, MAX_TREE_DEPTH};
use crate::limits::Limits;
use crate::scene::Rect;
use crate::tile::{Paths, step};
use labels::{Around, Cell, Labels, Ring};
use models::{
    EXPECTED, Expectation, Models, OUTCOMES, expect, outcome_context, outcome_model, pop_context, pop_model,
    surprise_level, test_model,
};
use runs::{Run, RunDecoder, RunEncoder};

/// Sequences of near-certain steps: outcomes where four or fewer neighbours agree, leaves likewise, pops.
const RUNS: usize = 5;
const OUTCOME_RUN: usize = 0;
const LEAF_RUN: usize = 2;
const POP_RUN: usize = 4;

/// Contexts of whether a path is a neighbour's: which neighbours share one, and whether it is a shadow ray's.
const SAME_CONTEXTS: usize = 64;

/// What the path codec needs of the tree, packed for walking.
#[derive(Debug)]
pub struct Topology {
    children: Vec<[Child; 2]>,
    /// Per triangle: bit 0, any ray may pass; bit 1, a shadow ray may pass.
    passes: Vec<u8>,
}

impl Topology {
    /// The topology of a tree.
    pub fn new(bvh: &Bvh) -> Self {
        let passes = |t: usize| {
            let material = bvh.material(t);
            u8::from(material.may_pass(false)) | u8::from(material.may_pass(true)) << 1
        };
        Self {
            children: bvh.nodes.iter().map(|node| node.children).collect(),
            passes: (0..bvh.triangles.len()).map(passes).collect(),
        }
    }
}

/// Memory of the codec, reused from tile to tile.
#[derive(Debug, Default)]
pub struct PathScratch {
    nodes: Labels,
    leaves: Labels,
    rows: Rows,
}

/// Where a ray stands in the image and in its stream.
#[derive(Clone, Copy)]
struct Place {
    /// Column in the tile, from 1.
    x: usize,
    /// Row in the tile.
    y: u32,
    /// A shadow ray: it ends at the first hit.
    any: bool,
}

/// A path that was coded: its number in the rings (0: none) and the ray that it was coded for.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    number: u32,
    ray: u32,
}

/// The paths of the row in work and of the row above, by column from 1. Rays with equal paths share one entry.
#[derive(Debug, Default)]
struct Rows {
    above: Vec<Known>,
    own: Vec<Known>,
    y: u32,
}

impl Rows {
    fn clear(&mut self, width: usize) {
        self.above.clear();
        self.above.resize(width + 2, Known::default());
        self.own.clone_from(&self.above);
        self.y = 0;
    }

    /// Makes row `y` the row in work.
    fn go_to(&mut self, y: u32) {
        if y != self.y {
            std::mem::swap(&mut self.own, &mut self.above);
            self.own.fill(Known::default());
            if y != self.y + 1 {
                self.above.fill(Known::default());
            }
            self.y = y;
        }
    }

    /// West, north, north-west, north-east.
    fn around(&self, x: usize) -> [Known; 4] {
        [self.own[x - 1], self.above[x], self.above[x - 1], self.above[x + 1]]
    }
}

/// A child put aside, the node that put it there, and the pop labels of the neighbours at that node.
#[derive(Clone, Copy)]
struct Waiting {
    child: Child,
    slot: u32,
    context: u8,
}

/// The coder of one tile's paths.
struct PathCoder<'a, C, R> {
    coder: C,
    runs: [R; RUNS],
    topology: &'a Topology,
    models: Models,
    scratch: &'a mut PathScratch,
    ring: Ring,
    /// Is the path the west's, or the north's? By which of the neighbours share a path.
    same: [Bit; 2 * SAME_CONTEXTS],
    stack: [Waiting; MAX_TREE_DEPTH],
    /// Shift register of surprises, newest lowest.
    surprises: u8,
    /// Most steps that may still be decoded.
    budget: u64,
}

impl<C: Coder, R: Run> PathCoder<'_, C, R> {
    #[inline(always)]
    fn note(&mut self, met: bool) {
        self.surprises = self.surprises << 1 | u8::from(!met);
    }

    /// Codes the outcome of an inner node as a label (1 to 5), given its neighbours'.
    #[inline(always)]
    fn outcome(&mut self, slot: usize, around: &Around, last: u8, given: u8) -> u8 {
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
    fn pop(&mut self, waiting: Waiting, given: bool) -> bool {
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
    fn leaf(&mut self, leaf: Child, around: &Around, any: bool, given: u8) -> u8 {
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
        self.tests(leaf, around, any, given)
    }

    /// Codes a leaf's tests one by one.
    fn tests(&mut self, leaf: Child, around: &Around, any: bool, given: u8) -> u8 {
        let mut label = 0;
        for (i, triangle) in leaf.triangles().enumerate() {
            let of = |l: u8| usize::from(l >> (2 * i) & 3);
            let context = of(around.ne) << 6 | of(around.nw) << 4 | of(around.n) << 2 | of(around.w);
            let value = of(given) as u8;
            let model = &mut self.models.test[test_model(context, surprise_level(self.surprises))];
            let met = self.coder.bit(model, value > test::MISS);
            let may_pass = self.topology.passes[triangle] >> u8::from(any) & 1 != 0;
            let passes = met && may_pass && self.coder.bit(&mut self.models.pass[context], value == test::PASS);
            let coded = if passes { test::PASS } else { test::MISS + u8::from(met) };
            label |= coded << (2 * i);
            if any && coded == test::HIT {
                break;
            }
        }
        label
    }

    /// Codes whether the path is that of the west or the north neighbour, and gives that neighbour's. `equals` tells an encoder
    /// whether the path is that of a ray.
    fn known(&mut self, place: Place, around: &[Known; 4], equals: impl Fn(u32) -> bool) -> Option<Known> {
        let [w, n, nw, ne] = around.map(|known| known.number);
        let context = usize::from(w == n) | usize::from(w == nw) << 1 | usize::from(n == nw) << 2;
        let context = context | usize::from(n == ne) << 3 | usize::from(n == 0) << 4 | usize::from(place.any) << 5;
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
    fn ray(
        &mut self,
        place: Place,
        ray: u32,
        given: &[u8],
        equals: impl Fn(u32) -> bool,
        out: &mut Vec<u8>,
    ) -> Result<Option<u32>, String> {
        self.scratch.rows.go_to(place.y);
        let around = self.scratch.rows.around(place.x);
        if let Some(known) = self.known(place, &around, equals) {
            self.scratch.rows.own[place.x] = known;
            return Ok(Some(known.ray));
        }
        let mut number = self.ring.number();
        let mut cells = around.map(|known| self.ring.cell(known.number));
        if number == 0 {
            self.scratch.nodes.forget();
            self.scratch.leaves.forget();
            let Rows { own, above, .. } = &mut self.scratch.rows;
            own.fill(Known::default());
            above.fill(Known::default());
            cells = [self.ring.cell(0); 4];
            number = self.ring.number();
        }
        let path = self.ring.cell(number);
        self.steps(place.any, path, &cells, given, out)?;
        self.scratch.rows.own[place.x] = Known { number, ray };
        Ok(None)
    }

    /// Codes a path step by step: `given` when encoding, appended to `out` when decoding.
    fn steps(
        &mut self,
        any: bool,
        path: Cell,
        cells: &[Cell; 4],
        given: &[u8],
        out: &mut Vec<u8>,
    ) -> Result<(), String> {
        let start = out.len();
        let mut given = given.iter();
        let (mut top, mut hit, mut last) = (0, false, 0);
        let mut current = Child::inner(0);
        self.surprises = 0;
        loop {
            let mut next = None;
            if current.is_leaf() {
                if current.count() > 0 {
                    let slot = self.scratch.leaves.slot(current.first());
                    let around = self.scratch.leaves.around(slot, cells);
                    let value = if C::ENCODES { test::take(&mut given, current.count(), any) } else { 0 };
                    let label = self.leaf(current, &around, any, value);
                    self.scratch.leaves.set(slot, path, label);
                    if !C::ENCODES {
                        test::put(label, out);
                    }
                    hit |= test::has_hit(label);
                    if any && hit {
                        break;
                    }
                }
            } else {
                let node = current.node();
                let slot = self.scratch.nodes.slot(node);
                let around = self.scratch.nodes.around(slot, cells);
                let value = if C::ENCODES { given.next().map_or(0, |v| v + 1) } else { 0 };
                let label = self.outcome(slot, &around, last, value);
                self.scratch.nodes.set(slot, path, label);
                last = label;
                if !C::ENCODES {
                    if usize::from(label.wrapping_sub(1)) >= OUTCOMES - 1 {
                        return Err("a node visit has no such outcome".into());
                    }
                    out.push(label - 1);
                }
                let [left, right] = self.topology.children[node];
                let waiting = match label - 1 {
                    step::LEFT => {
                        next = Some(left);
                        None
                    }
                    step::RIGHT => {
                        next = Some(right);
                        None
                    }
                    step::LEFT_FIRST => {
                        next = Some(left);
                        Some(right)
                    }
                    step::RIGHT_FIRST => {
                        next = Some(right);
                        Some(left)
                    }
                    _ => None,
                };
                if let Some(child) = waiting {
                    self.stack[top] = Waiting { child, slot: slot as u32, context: pop_context(&around) as u8 };
                    top += 1;
                }
            }
            while next.is_none() && top > 0 {
                top -= 1;
                let waiting = self.stack[top];
                let value = C::ENCODES && given.next() == Some(&step::POP);
                // Until something is hit, nothing can hide a child.
                let visited = if any {
                    true
                } else {
                    let visited = !hit || self.pop(waiting, value);
                    self.scratch.nodes.add(waiting.slot as usize, path, if visited { 1 << 3 } else { 2 << 3 });
                    visited
                };
                if !C::ENCODES {
                    out.push(if visited { step::POP } else { step::CULLED });
                }
                next = visited.then_some(waiting.child);
            }
            match next {
                Some(child) => current = child,
                None => break,
            }
            if !C::ENCODES && (out.len() - start) as u64 > self.budget {
                return Err("the paths have more steps than a tile may hold".into());
            }
        }
        self.budget = self.budget.saturating_sub((out.len() - start) as u64);
        Ok(())
    }
}

/// Triangle tests as labels: two bits each, 0 where there was none.
mod test {
    use crate::tile::step;

    pub const MISS: u8 = 1;
    pub const HIT: u8 = 2;
    pub const PASS: u8 = 3;

    /// Packs up to `count` steps; a hit ends a shadow ray.
    #[inline(always)]
    pub fn take(steps: &mut std::slice::Iter<'_, u8>, count: usize, any: bool) -> u8 {
        let mut label = 0;
        for i in 0..count {
            let step = steps.next().map_or(0, |s| s - step::MISS + MISS);
            label |= step << (2 * i);
            if any && step == HIT {
                break;
            }
        }
        label
    }

    /// Appends the steps of a label.
    #[inline(always)]
    pub fn put(mut label: u8, out: &mut Vec<u8>) {
        while label != 0 {
            out.push((label & 3) - MISS + step::MISS);
            label >>= 2;
        }
    }

    /// True when one of the tests is a hit.
    #[inline(always)]
    pub fn has_hit(label: u8) -> bool {
        label & !(label << 1) & 0xaa != 0
    }
}

/// The streams of a tile: whether they are shadow rays, and per ray its sample and ray number.
fn streams(order: &Order<'_>, lights: usize) -> Vec<(bool, Vec<(u32, u32)>)> {
    let tree = order.tree;
    let index = tree.ray_index();
    let mut streams = Vec::new();
    for ClassRays { rays, .. } in &order.classes {
        let mut shadows = vec![Vec::new(); lights];
        for &(sample, node) in rays {
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

fn place(rect: Rect, sample: u32, any: bool) -> Place {
    Place { x: (sample % rect.width) as usize + 1, y: sample / rect.width, any }
}

fn start<'a, C, R>(
    coder: C,
    runs: [R; RUNS],
    topology: &'a Topology,
    scratch: &'a mut PathScratch,
    budget: u64,
) -> PathCoder<'a, C, R> {
    let ring = Ring::new();
    scratch.nodes.start(topology.children.len());
    scratch.leaves.start(topology.passes.len());
    let same = [Bit::EVEN; 2 * SAME_CONTEXTS];
    let stack = [Waiting { child: Child::leaf(0, 0), slot: 0, context: 0 }; MAX_TREE_DEPTH];
    PathCoder { coder, runs, topology, models: Models::new(), scratch, ring, same, stack, surprises: 0, budget }
}

/// Codes the paths of a tile: the runs' streams, each behind its length (u32), then the main stream.
pub fn encode(
    paths: &Paths,
    order: &Order<'_>,
    lights: usize,
    topology: &Topology,
    scratch: &mut PathScratch,
) -> Vec<u8> {
    let runs: [RunEncoder; RUNS] = Default::default();
    let mut coder = start(Encoder::default(), runs, topology, scratch, u64::MAX);
    let mut none = Vec::new();
    for (any, rays) in streams(order, lights) {
        coder.scratch.rows.clear(order.rect.width as usize);
        for (sample, ray) in rays {
            let given = paths.ray(ray as usize);
            let equals = |other: u32| paths.ray(other as usize) == given;
            let coded = coder.ray(place(order.rect, sample, any), ray, given, equals, &mut none);
            debug_assert!(coded.is_ok(), "the tracer records only paths of its own tree");
        }
    }
    let mut out = Vec::new();
    for run in coder.runs {
        let bytes = run.finish();
        out.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        out.extend_from_slice(&bytes);
    }
    out.extend_from_slice(&coder.coder.finish());
    out
}

/// Decodes the paths of a tile.
///
/// # Errors
/// Says so when a step is impossible or there are more than `limits` allow.
pub fn decode(
    mut bytes: &[u8],
    order: &Order<'_>,
    lights: usize,
    topology: &Topology,
    limits: &Limits,
    scratch: &mut PathScratch,
) -> Result<Paths, String> {
    let mut runs = Vec::with_capacity(RUNS);
    for _ in 0..RUNS {
        let (length, rest) = bytes.split_first_chunk::<4>().ok_or("the paths end within a length")?;
        let length = u32::from_le_bytes(*length) as usize;
        let (run, rest) = rest.split_at_checked(length).ok_or("a run of the paths is longer than the column")?;
        runs.push(RunDecoder::new(run));
        bytes = rest;
    }
    let runs: [RunDecoder<'_>; RUNS] = runs.try_into().map_err(|_| "the paths lack a run")?;
    let mut coder = start(Decoder::new(bytes), runs, topology, scratch, limits.max_path_steps_per_tile);
    let mut out = Paths { steps: Vec::new(), spans: vec![(0, 0); order.tree.ray_count() as usize] };
    let Paths { steps, spans } = &mut out;
    for (any, rays) in streams(order, lights) {
        coder.scratch.rows.clear(order.rect.width as usize);
        for (sample, ray) in rays {
            let start = steps.len();
            let shared = coder.ray(place(order.rect, sample, any), ray, &[], |_| false, steps)?;
            spans[ray as usize] = match shared {
                Some(other) => spans[other as usize],
                None => (start as u32, (steps.len() - start) as u32),
            };
        }
    }
    Ok(out)
}
