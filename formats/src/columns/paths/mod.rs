//! The paths column: the traversal path of every ray, coded against the tree and the paths of neighbouring rays.
//!
//! Rays are coded stream by stream: all rays of one class, then its shadow rays light by light. Within a stream they
//! are coded row by row. What a ray does at a node is predicted from what the rays to the left, above, above left and
//! above right did *at that node*. The projection of a box on the image has few edges, so each node is a small picture,
//! coded as JBIG codes one. Where all four neighbours agree, only surprises cost anything (`runs.rs`); elsewhere a step
//! is an adaptive bit in the context of the four.
//!
//! The decoder walks the tree, so a path needs no length, and steps that can only go one way (pops before any hit) are
//! not coded at all.

mod labels;
mod leaf;
mod models;
mod rows;
mod runs;
mod steps;
mod topology;

use super::classes::{ClassRays, CodingOrder};
use super::coder::{Decoder, Encoder};
use crate::limits::Limits;
use crate::scene::Rect;
use crate::tile::Paths;
use runs::{RunDecoder, RunEncoder};
use steps::{PathCoder, RUNS, RayPosition};

pub(crate) use steps::PathScratch;
pub use topology::BvhTopology;

/// The streams of a tile: whether any hit ends their rays (shadow rays), and per ray its sample and its number.
fn streams(order: &CodingOrder<'_>, lights: usize) -> Vec<(bool, Vec<(u32, u32)>)> {
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

fn position(rect: Rect, sample: u32, any_hit: bool) -> RayPosition {
    RayPosition { x: (sample % rect.width) as usize + 1, y: sample / rect.width, any_hit }
}

/// Codes the paths of a tile: the runs' streams, each behind its length (u32), then the main stream.
///
/// # Errors
/// Says which ray has a path that does not fit the tree, and why.
pub fn encode(
    paths: &Paths,
    order: &CodingOrder<'_>,
    lights: usize,
    topology: &BvhTopology,
    scratch: &mut PathScratch,
) -> Result<Vec<u8>, String> {
    let runs: [RunEncoder; RUNS] = Default::default();
    let mut coder = PathCoder::new(Encoder::default(), runs, topology, scratch, u64::MAX);
    let mut none = Vec::new();
    for (any_hit, rays) in streams(order, lights) {
        coder.scratch.rows.clear(order.rect.width as usize);
        for (sample, ray) in rays {
            let given = paths.ray(ray as usize);
            let equals = |other: u32| paths.ray(other as usize) == given;
            coder
                .ray(position(order.rect, sample, any_hit), ray, given, equals, &mut none)
                .map_err(|why| format!("the path of ray {ray} does not fit the tree: {why}"))?;
        }
    }
    let mut out = Vec::new();
    for run in coder.runs {
        let bytes = run.finish();
        out.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        out.extend_from_slice(&bytes);
    }
    out.extend_from_slice(&coder.coder.finish());
    Ok(out)
}

/// Decodes the paths of a tile.
///
/// # Errors
/// Says so when a step is impossible or there are more than `limits` allow.
pub fn decode(
    mut bytes: &[u8],
    order: &CodingOrder<'_>,
    lights: usize,
    topology: &BvhTopology,
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
    let mut coder = PathCoder::new(Decoder::new(bytes), runs, topology, scratch, limits.max_path_steps_per_tile);
    let mut out = Paths { steps: Vec::new(), spans: vec![(0, 0); order.tree.ray_count() as usize] };
    let Paths { steps, spans } = &mut out;
    for (any_hit, rays) in streams(order, lights) {
        coder.scratch.rows.clear(order.rect.width as usize);
        for (sample, ray) in rays {
            let start = steps.len();
            let shared = coder.ray(position(order.rect, sample, any_hit), ray, &[], |_| false, steps)?;
            spans[ray as usize] = match shared {
                Some(other) => spans[other as usize],
                None => (start as u32, (steps.len() - start) as u32),
            };
        }
    }
    Ok(out)
}
