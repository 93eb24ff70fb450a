//! Recorded paths against the tree: after this the simulator may trust every step.
//!
//! A path starts at the root. An inner node takes one step that says which children are met (of two, the far one goes on the
//! stack); a leaf takes one step a triangle, in order; then the stack is popped, one step each, until a child is visited that
//! is not culled. The path ends when the stack is empty, and a shadow ray also at its first hit. Shadow rays cull nothing.

use rayreel_formats::bvh::{Child, MAX_TREE_DEPTH};
use rayreel_formats::tile::step;

use super::NO_TRIANGLE;
use super::ops::Op;
use super::topology::Topology;
use crate::counters::counters;

counters! {
    /// Work that paths ask for, whatever machine does it, and whether it does it: a rasteriser finds what primaries see without them.
    pub struct PathCounts {
        rays: "rays", "recorded paths of the traced rays, primaries included that a rasteriser replaces";
        node_visits: "events", "inner nodes visited on these paths (paths/rays)";
        triangle_tests: "events", "triangles tested on these paths (paths/rays)";
        pushes: "events", "children put on the stack on these paths (paths/rays)";
        pops: "events", "children taken from the stack and visited on these paths (paths/rays)";
        culled: "events", "children taken from the stack on these paths (paths/rays) that lie behind the closest hit";
        hits: "events", "triangle tests on these paths (paths/rays) that found a closer hit";
    }
}

impl PathCounts {
    /// What the operations of one ray ask for, all but the hits: operations do not tell of them.
    pub fn of_ops(ops: &[Op]) -> Self {
        // Without branches, so that the compiler counts several at a time.
        let [mut visits, mut tests, mut pushes, mut pops, mut culled] = [0u32; 5];
        for op in ops {
            let found = op.tally();
            visits += found.visits;
            tests += found.tests;
            pushes += found.pushes;
            pops += found.pops;
            culled += found.culled;
        }
        Self {
            rays: 1,
            node_visits: visits.into(),
            triangle_tests: tests.into(),
            pushes: pushes.into(),
            pops: pops.into(),
            culled: culled.into(),
            hits: 0,
        }
    }
}

/// What a path does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Walked {
    /// The last triangle that was hit; [`NO_TRIANGLE`] if there is none.
    pub hit: u32,
    /// Most children on the stack at a time.
    pub max_stack: u32,
}

/// What is wrong with a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The first step that is wrong; the length of the path if it is too short.
    pub step: u32,
    /// What is wrong.
    pub detail: &'static str,
}

const TOO_SHORT: &str = "the path ends before the ray does";
const TOO_LONG: &str = "the path goes on after the ray's end";
const NOT_INNER: &str = "the step does not belong to an inner node";
const NOT_LEAF: &str = "the step does not belong to a leaf";
const NOT_POP: &str = "the step is not a stack pop";
const SHADOW_CULL: &str = "a shadow ray culls nothing";
const TOO_DEEP: &str = "the tree is deeper than the format allows";
const NO_TREE: &str = "the tree has no node";

/// Steps to the right child (bit = step).
const TO_RIGHT: u32 = 1 << step::RIGHT | 1 << step::RIGHT_FIRST;

/// Walks a path through the tree, appends its operations to `ops` and adds its work to `counts`; both are only right if there
/// is no fault.
///
/// # Errors
/// The first step that breaks the grammar.
pub fn walk(
    tree: &Topology,
    steps: &[u8],
    shadow: bool,
    ops: &mut Vec<Op>,
    counts: &mut PathCounts,
) -> Result<Walked, Fault> {
    let mut path = Path { steps, at: 0 };
    if tree.children.is_empty() {
        return Err(path.fault(NO_TREE));
    }
    // Deferred children, each with the node that deferred it.
    let mut stack = [(Child::leaf(0, 0), 0); MAX_TREE_DEPTH];
    let (mut top, mut max_stack, mut hit) = (0, 0, NO_TRIANGLE);
    let mut current = Child::inner(0);
    counts.rays += 1;
    loop {
        if current.is_leaf() {
            counts.triangle_tests += current.count() as u64;
            for triangle in current.triangles() {
                match path.take()? {
                    step::MISS | step::PASS => {}
                    step::HIT => {
                        (hit, counts.hits) = (triangle as u32, counts.hits + 1);
                        if shadow {
                            // Tests behind the hit are not made.
                            counts.triangle_tests -= (current.triangles().end - 1 - triangle) as u64;
                            ops.push(Op::leaf(current.first() as u32, (triangle + 1 - current.first()) as u32));
                            return path.end(Walked { hit, max_stack });
                        }
                    }
                    _ => return Err(path.wrong(NOT_LEAF)),
                }
            }
            ops.push(Op::leaf(current.first() as u32, current.count() as u32));
        } else {
            counts.node_visits += 1;
            let code = path.take()?;
            if code > step::RIGHT_FIRST {
                return Err(path.wrong(NOT_INNER));
            }
            let node = current.node() as u32;
            ops.push(Op::visit(node, code >= step::LEFT_FIRST));
            if code != step::NONE {
                let [left, right] = tree.children[current.node()];
                let (near, far) = if TO_RIGHT >> code & 1 == 1 { (right, left) } else { (left, right) };
                current = near;
                if code >= step::LEFT_FIRST {
                    if top == MAX_TREE_DEPTH {
                        return Err(path.wrong(TOO_DEEP));
                    }
                    stack[top] = (far, node);
                    top += 1;
                    max_stack = max_stack.max(top as u32);
                    counts.pushes += 1;
                }
                continue;
            }
        }
        loop {
            if top == 0 {
                ops.push(Op::END);
                return path.end(Walked { hit, max_stack });
            }
            top -= 1;
            let code = path.take()?;
            ops.push(Op::pop(stack[top].1, code == step::CULLED));
            match code {
                step::POP => break,
                step::CULLED if !shadow => counts.culled += 1,
                step::CULLED => return Err(path.wrong(SHADOW_CULL)),
                _ => return Err(path.wrong(NOT_POP)),
            }
        }
        current = stack[top].0;
        counts.pops += 1;
    }
}

/// The steps that are left.
struct Path<'a> {
    steps: &'a [u8],
    at: usize,
}

impl Path<'_> {
    #[inline(always)]
    fn take(&mut self) -> Result<u8, Fault> {
        let Some(&step) = self.steps.get(self.at) else {
            return Err(self.fault(TOO_SHORT));
        };
        self.at += 1;
        Ok(step)
    }

    /// The ray ends here: the path must, too.
    fn end(&self, walked: Walked) -> Result<Walked, Fault> {
        if self.at == self.steps.len() { Ok(walked) } else { Err(self.fault(TOO_LONG)) }
    }

    /// The step that comes next is wrong.
    #[cold]
    fn fault(&self, detail: &'static str) -> Fault {
        Fault { step: self.at as u32, detail }
    }

    /// The step that was just taken is wrong.
    #[cold]
    fn wrong(&self, detail: &'static str) -> Fault {
        Fault { step: self.at as u32 - 1, detail }
    }
}
