//! One row a sample: its colour, what its rays cost, and what a policy made of it.

use std::sync::Arc;

use rayreel_formats::math::Vec3;
use rayreel_formats::tile::{Column, Tile, composite};
use rayreel_formats::trace::Trace;
use rayreel_machine::work::check::PathCounts;
use rayreel_machine::work::ops::Op;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::frame::states::{Blocks, StateMap};
use rayreel_replay::frame::traced::{TracedMap, TracedRays};
use rayreel_replay::policy::view::SampleState;

use super::paths::{RayAt, each_path};
use super::{TileRows, place};
use crate::error::Result;
use crate::schema::{Batch, Table, table};
use crate::value::{WordsOf, word};

word! {
    /// What a policy made of a sample.
    pub enum State {
        /// There is no policy: it was recorded.
        Recorded = "recorded",
        /// Traced before any test.
        Reference = "reference",
        /// Traced after a test.
        Traced = "traced",
        /// Some of its rays were traced, some of its hits interpolated.
        Partial = "partial",
        /// Interpolated.
        Interpolated = "interpolated",
    }
}

impl From<SampleState> for State {
    fn from(state: SampleState) -> Self {
        match state {
            SampleState::Reference => Self::Reference,
            SampleState::Traced => Self::Traced,
            SampleState::Partial => Self::Partial,
            SampleState::Interpolated => Self::Interpolated,
        }
    }
}

table! {
    /// The samples of a trace.
    pub struct SampleRows = "samples", "a sample, tile by tile, those of a tile row by row" {
        frame: Vec<u32>, "", "frame number";
        tile: Vec<u32>, "", "tile in the frame";
        x: Vec<u32>, "samples", "sample: column of the frame's grid";
        y: Vec<u32>, "samples", "sample: row of the frame's grid";
        r: Vec<f32>, "linear RGB", "colour as recorded, whatever a policy makes of it";
        g: Vec<f32>, "linear RGB", "colour as recorded";
        b: Vec<f32>, "linear RGB", "colour as recorded";
        rays: Vec<u32>, "rays", "recorded rays of the sample";
        shadow_rays: Vec<u32>, "rays", "shadow rays among them";
        node_visits: Vec<u32>, "events", "inner nodes that its rays visit";
        triangle_tests: Vec<u32>, "events", "triangles that its rays test";
        pops: Vec<u32>, "events", "children that its rays take from the stack, culled ones included";
        state: WordsOf<State>, "", "what the policy made of it";
        round: Vec<u8>, "", "round of the policy in which it was traced or interpolated; 0 without a policy";
        block: Vec<u32>, "samples", "block edge of the policy in its tile; 1 without a policy";
        rays_traced: Vec<u32>, "rays", "rays of the sample that the policy traced; without a policy those recorded";
        shadow_rays_traced: Vec<u32>, "rays", "shadow rays among them";
    }
}

/// The columns that are made of recorded colours.
pub(crate) const COLOURS: [&str; 3] = ["r", "g", "b"];
/// The columns that are made of paths.
pub(crate) const WORK: [&str; 3] = ["node_visits", "triangle_tests", "pops"];

/// What is read of samples, and what they follow from beside the trace.
#[derive(Clone, Debug)]
pub struct Samples {
    /// Their colours; without, these columns are 0.
    pub colours: bool,
    /// The tree that their rays walk through: their paths are read, which takes most of the time. Without, the work on them is 0.
    pub work: Option<Arc<Topology>>,
    /// What a policy made of the frame at hand.
    pub made: Option<Arc<Made>>,
}

/// What a policy made of a frame.
#[derive(Debug)]
pub struct Made {
    /// State and round of each sample.
    pub states: StateMap,
    /// The block of each tile.
    pub blocks: Blocks,
    /// The rays that were traced for each sample.
    pub traced: TracedMap,
}

impl TileRows for SampleRows {
    const TABLE: &'static Table = &Self::TABLE;
    const ROWS_A_SAMPLE: u32 = 1;
    type With = Samples;

    fn add(&mut self, trace: &Trace, with: &Samples, (frame, index): (u32, u32)) -> Result<()> {
        let mut sums = vec![PathCounts::default(); trace.meta().tile_rect(index).len()];
        let columns: &[Column] = if with.colours { &[Column::Radiance] } else { &[] };
        let tile = if let Some(tree) = &with.work {
            let mut add = |_: &Tile, at: RayAt, _: &[Op], counts| sums[at.sample as usize] += counts;
            each_path(trace, tree, columns, (frame, index), &mut add)?
        } else {
            Arc::new(trace.tile(frame, index, columns)?)
        };
        for (sample, counts) in (0..).zip(&sums) {
            let (x, y) = place(&tile, sample);
            let of = tile.tree.sample(sample as usize);
            let nodes = &tile.tree.nodes[of.clone()];
            let colour = if with.colours { composite(nodes, &tile.radiance[of]) } else { Vec3::ZERO };
            let shadow_rays: u32 = nodes.iter().map(|node| node.shadows.count()).sum();
            let rays = nodes.len() as u32 + shadow_rays;
            let (state, round, block, traced) = match with.made.as_deref() {
                Some(Made { states, blocks, traced }) => {
                    (states.state(x, y).into(), states.round(x, y), blocks.at(x, y), traced.at(x, y))
                }
                None => (State::Recorded, 0, 1, TracedRays { all: rays, shadow: shadow_rays }),
            };
            self.frame.push(frame);
            self.tile.push(index);
            self.x.push(x);
            self.y.push(y);
            self.r.push(colour.x);
            self.g.push(colour.y);
            self.b.push(colour.z);
            self.rays.push(rays);
            self.shadow_rays.push(shadow_rays);
            self.node_visits.push(counts.node_visits as u32);
            self.triangle_tests.push(counts.triangle_tests as u32);
            self.pops.push((counts.pops + counts.culled) as u32);
            self.state.push(state);
            self.round.push(round);
            self.block.push(block);
            self.rays_traced.push(traced.all);
            self.shadow_rays_traced.push(traced.shadow);
        }
        Ok(())
    }

    fn into_batch(self) -> Batch {
        self.batch()
    }
}
