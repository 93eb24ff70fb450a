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
mod met;
mod models;
mod runs;
mod sink;
mod steps;
mod topology;
mod walk;

use super::classes::{ClassRays, CodingOrder};
use super::coder::{Decoder, Encoder};
use crate::limits::Limits;
use crate::tile::Paths;
use runs::{RunDecoder, RunEncoder};
use sink::Steps;
use steps::{PathCoder, RUNS};
use walk::{Coded, RayPlace};

pub use sink::{LeafTests, PathSink};
pub(crate) use steps::PathScratch;
pub use topology::BvhTopology;

/// The streams of a tile, each as its rays: of each class, then of its shadow rays, light by light.
/// `index` is the tree's [`ray_index`](crate::tile::Tree::ray_index).
fn streams<'a>(
    order: &'a CodingOrder<'_>,
    index: &'a [u32],
    lights: usize,
) -> impl Iterator<Item = impl Iterator<Item = RayPlace> + 'a> + 'a {
    let kinds = move || std::iter::once(None).chain((0..lights).map(Some));
    let streams = order.classes.iter().flat_map(move |class| kinds().map(move |light| (class, light)));
    streams.map(move |(ClassRays { rays, .. }, light)| {
        rays.iter().filter_map(move |&(sample, node)| {
            let first = index[node as usize];
            let ray = match light {
                None => first,
                Some(light) => first + 1 + order.tree.nodes[node as usize].shadows.rank(light)?,
            };
            Some(RayPlace { sample, ray, any_hit: light.is_some() })
        })
    })
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
    let mut coded = 0;
    for rays in streams(order, &order.tree.ray_index(), lights) {
        coder.scratch.rows.restart(order.rect);
        for place in rays {
            let (ray, given) = (place.ray, paths.ray(place.ray as usize));
            let equals = |other: u32| paths.ray(other as usize) == given;
            let fits = coder
                .ray(place, given, equals, &mut ())
                .map_err(|why| format!("the path of ray {ray} does not fit the tree: {why}"))?;
            coded += if let Coded::Steps(steps) = fits { u64::from(steps) } else { 0 };
        }
    }
    let mut out = Vec::new();
    for run in coder.code.runs {
        let bytes = run.finish();
        out.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        out.extend_from_slice(&bytes);
    }
    out.extend_from_slice(&coder.code.coder.finish());
    // What a reader would refuse is not written.
    let most = Limits::default().path_steps_max(out.len(), paths.spans.len() as u64);
    if coded > most {
        return Err(format!(
            "{coded} path steps in {} bytes are more than a reader takes; use smaller tiles",
            out.len()
        ));
    }
    Ok(out)
}

/// Decodes the paths of a tile.
///
/// # Errors
/// Says so when a step is impossible or there are more than `limits` allow.
pub fn decode(
    bytes: &[u8],
    order: &CodingOrder<'_>,
    lights: usize,
    topology: &BvhTopology,
    limits: &Limits,
    scratch: &mut PathScratch,
) -> Result<Paths, String> {
    let mut sink = Steps::default();
    let rays = decode_to(bytes, order, lights, topology, limits, scratch, &mut sink)?.rays;
    let spans = rays.into_iter().map(|path| sink.spans[path as usize]).collect();
    Ok(Paths { steps: sink.steps, spans })
}

/// Which path each ray of a tile has. Rays may share one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SharedPaths {
    /// Per ray, in ray order, its path, counted from 0 as they were decoded.
    pub rays: Vec<u32>,
    /// Per path the number of its steps.
    pub steps: Vec<u32>,
}

/// Decodes the paths of a tile to `sink`, which is given each path once, however many rays have it.
///
/// # Errors
/// As [`decode`].
pub fn decode_to<S: PathSink>(
    mut bytes: &[u8],
    order: &CodingOrder<'_>,
    lights: usize,
    topology: &BvhTopology,
    limits: &Limits,
    scratch: &mut PathScratch,
    sink: &mut S,
) -> Result<SharedPaths, String> {
    let index = order.tree.ray_index();
    let rays = index.last().map_or(0, |&rays| rays as usize);
    let (mut runs, most) = (Vec::with_capacity(RUNS), limits.path_steps_max(bytes.len(), rays as u64));
    for _ in 0..RUNS {
        let (length, rest) = bytes.split_first_chunk::<4>().ok_or("the paths end within a length")?;
        let length = u32::from_le_bytes(*length) as usize;
        let (run, rest) = rest.split_at_checked(length).ok_or("a run of the paths is longer than the column")?;
        runs.push(RunDecoder::new(run));
        bytes = rest;
    }
    let runs: [RunDecoder<'_>; RUNS] = runs.try_into().map_err(|_| "the paths lack a run")?;
    let mut coder = PathCoder::new(Decoder::new(bytes), runs, topology, scratch, most);
    let mut out = SharedPaths { rays: vec![0; rays], steps: Vec::new() };
    for rays in streams(order, &index, lights) {
        coder.scratch.rows.restart(order.rect);
        for place in rays {
            out.rays[place.ray as usize] = match coder.ray(place, &[], |_| false, sink)? {
                Coded::Like(other) => out.rays[other as usize],
                Coded::Steps(steps) => {
                    out.steps.push(steps);
                    out.steps.len() as u32 - 1
                }
            };
        }
    }
    Ok(out)
}
