//! One row a step of a ray through the tree.

use std::sync::Arc;

use rayreel_formats::tile::{Column, Tile, step};
use rayreel_formats::trace::Trace;
use rayreel_machine::work::check::{PathCounts, walk};
use rayreel_machine::work::ops::{Op, OpKind};
use rayreel_machine::work::topology::Topology;

use super::paths::{NO_PATH, RayAt, broken, rays};
use super::{TileRows, place, repeat};
use crate::error::Result;
use crate::schema::{Batch, Table, table};
use crate::value::{WordsOf, word};

word! {
    /// Where a ray takes a step.
    pub enum At {
        /// An inner node is visited: both boxes are tested.
        Node = "node",
        /// A child is taken from the stack.
        Stack = "stack",
        /// A triangle is tested.
        Triangle = "triangle",
    }
}

word! {
    /// What came of a step, in the order of the codes of a path.
    pub enum StepOutcome {
        /// Neither child's box is met.
        None = "none",
        /// Only the left child.
        Left = "left",
        /// Only the right child.
        Right = "right",
        /// Both, the left one first.
        LeftFirst = "left_first",
        /// Both, the right one first.
        RightFirst = "right_first",
        /// The popped child is visited.
        Visited = "visited",
        /// The popped child lies behind the closest hit.
        Culled = "culled",
        /// The triangle is missed.
        Miss = "miss",
        /// The triangle is hit.
        Hit = "hit",
        /// The triangle is met, and the ray passes.
        Pass = "pass",
    }
}

impl StepOutcome {
    /// The outcome of a step that leads through the tree.
    fn of(code: u8) -> Self {
        match code {
            step::NONE => Self::None,
            step::LEFT => Self::Left,
            step::RIGHT => Self::Right,
            step::LEFT_FIRST => Self::LeftFirst,
            step::RIGHT_FIRST => Self::RightFirst,
            step::POP => Self::Visited,
            step::CULLED => Self::Culled,
            step::MISS => Self::Miss,
            step::HIT => Self::Hit,
            _ => Self::Pass,
        }
    }
}

table! {
    /// The traversal steps of a trace.
    pub struct StepRows = "steps", "a step of a ray through the tree, ray by ray in the order of table rays, each ray's steps in order" {
        frame: Vec<u32>, "", "frame number";
        tile: Vec<u32>, "", "tile in the frame";
        x: Vec<u32>, "samples", "sample: column of the frame's grid";
        y: Vec<u32>, "samples", "sample: row of the frame's grid";
        index: Vec<u32>, "", "number of the ray in its tile, as in table rays";
        ray: Vec<u32>, "", "number of the ray in its sample, as in table rays";
        step: Vec<u32>, "", "number of the step in its ray";
        at: WordsOf<At>, "", "where it is taken";
        number: Vec<u32>, "", "at a node the node, at the stack the node that put the child there, at a triangle the triangle";
        outcome: WordsOf<StepOutcome>, "", "what came of it";
    }
}

impl StepRows {
    /// Adds the steps of a ray, whose operations are `ops`.
    fn ray(&mut self, tile: &Tile, at: RayAt, steps: &[u8], ops: &[Op]) {
        let ((x, y), count) = (place(tile, at.sample), steps.len());
        repeat(&mut self.frame, tile.frame, count);
        repeat(&mut self.tile, tile.index, count);
        repeat(&mut self.x, x, count);
        repeat(&mut self.y, y, count);
        repeat(&mut self.index, at.index, count);
        repeat(&mut self.ray, at.ray, count);
        self.step.extend(0..count as u32);
        for op in ops {
            match op.kind() {
                OpKind::Visit { node, .. } => self.one(At::Node, node),
                OpKind::Pop { node } | OpKind::Cull { node } => self.one(At::Stack, node),
                OpKind::Leaf { triangle, tests } => {
                    (triangle..triangle + u32::from(tests)).for_each(|triangle| self.one(At::Triangle, triangle));
                }
                OpKind::End => {}
            }
        }
        steps.iter().for_each(|&code| self.outcome.push(StepOutcome::of(code)));
    }

    #[inline]
    fn one(&mut self, at: At, number: u32) {
        self.at.push(at);
        self.number.push(number);
    }
}

impl TileRows for StepRows {
    const TABLE: &'static Table = &Self::TABLE;
    const ROWS_A_SAMPLE: u32 = 256;
    type With = Arc<Topology>;

    fn add(&mut self, trace: &Trace, tree: &Arc<Topology>, (frame, index): (u32, u32)) -> Result<()> {
        let tile = trace.tile(frame, index, &[Column::Paths])?;
        let mut ops = Vec::new();
        for at in rays(&tile) {
            ops.clear();
            if at.index as usize >= tile.paths.spans.len() {
                return Err(broken(&tile, at.index, NO_PATH));
            }
            let steps = tile.paths.ray(at.index as usize);
            let walked = walk(tree, steps, at.shadow, &mut ops, &mut PathCounts::default());
            walked.map_err(|fault| broken(&tile, at.index, fault))?;
            self.ray(&tile, at, steps, &ops);
        }
        Ok(())
    }

    fn into_batch(self) -> Batch {
        self.batch()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::Word;

    #[test]
    fn words_stand_in_the_order_of_the_codes() {
        assert!((0..10).all(|code| StepOutcome::of(code).code() == u32::from(code)));
        assert_eq!(StepOutcome::NAMES.len(), 10);
    }
}
