//! A second implementation of the adaptive policies: the whole frame at once, slow and obvious, written from POLICIES.md and
//! not from the code it checks. It shares the trace format's functions (rays, colours, normals) and nothing else.

mod account;
pub(crate) mod area;
mod audit;
mod chronicle;
mod draw;
pub(crate) mod maker;
mod outcome;
mod rates;

use rayreel_formats::scene::Meta;
use rayreel_replay::TileSource;
use rayreel_replay::policy::{Adaptive, Apron, Correct, Limit};

use crate::past::Traced;
use crate::recorded::read;
use area::{Area, on};
use maker::Maker;

pub use crate::recorded::Rays;
pub use chronicle::{Written, retell};
pub use outcome::{Origin, Outcome, Sought};
pub use rates::{Plan, plans};

/// Replays one frame with one block for all tiles.
pub fn replay<S: TileSource>(source: &S, policy: &Adaptive, frame: u32) -> Outcome {
    let tiles = source.meta().tile_count() as usize;
    replay_tiles(source, policy, &vec![(policy.block, 1.0); tiles], frame)
}

/// Replays one frame with a block and a factor on the colour limit for each tile.
pub fn replay_tiles<S: TileSource>(source: &S, policy: &Adaptive, rates: &[(u32, f64)], frame: u32) -> Outcome {
    let recorded = read(source, frame, policy.sampling.secondary || policy.sampling.similarity.secondary);
    let tiles = areas(source.meta(), rates);
    let (maker, before) = decide(source.meta(), &tiles, Maker::new(policy, &recorded, None));
    maker.account(&tiles, &before)
}

/// Replays one frame and audits pixels; what the audits found too: per tile the squared error and the number of values.
pub fn replay_audited<S: TileSource>(
    source: &S,
    policy: &Adaptive,
    rates: &[(u32, f64)],
    (frame, every): (u32, u64),
) -> (Outcome, Vec<(u64, u64)>) {
    let recorded = read(source, frame, policy.sampling.secondary || policy.sampling.similarity.secondary);
    let tiles = areas(source.meta(), rates);
    let (mut maker, before) = decide(source.meta(), &tiles, Maker::new(policy, &recorded, None));
    let n = source.meta().samples as usize;
    let found = tiles.iter().map(|area| maker.audit(area, n, u64::from(frame), every)).collect();
    (maker.account(&tiles, &before), found)
}

/// The rules of correction with both limits multiplied.
pub fn stricter(correct: &Correct, factor: f64) -> Correct {
    let times = |limit: Limit| limit.value().map_or(Limit::Off, |limit| Limit::At(limit * factor));
    Correct { colour: times(correct.colour), colour_alone: times(correct.colour_alone), ..correct.clone() }
}

/// The tiles of a frame, by block and factor on the colour limit.
fn areas(meta: &Meta, rates: &[(u32, f64)]) -> Vec<Area> {
    (0..meta.tile_count()).map(|i| Area::new(meta.tile_rect(i), rates[i as usize])).collect()
}

/// All steps; and what was traced before correction.
fn decide<'a>(meta: &Meta, tiles: &[Area], mut maker: Maker<'a>) -> (Maker<'a>, Vec<Vec<Traced>>) {
    let (width, height) = (maker.frame.width, maker.frame.height);
    let (columns, policy) = (meta.tile_grid().0, maker.policy);
    let last = (width - 1, height - 1);
    for (i, area) in tiles.iter().enumerate() {
        let left = if (i as u32).is_multiple_of(columns) { area.n } else { tiles[i - 1].n };
        for (x, y) in area.samples() {
            let in_lattice = on(x, area.n, last.0) && on(y, area.n, last.1);
            if in_lattice || x == area.x0 && on(y, left, last.1) {
                maker.trace_whole(area, y * width + x, Origin::R, 0);
            }
        }
    }
    for area in tiles {
        let mut ends: Vec<usize> = (area.x0..area.x1).filter(|&x| on(x, area.n, last.0)).collect();
        ends.extend((area.x1 < width).then_some(area.x1));
        for y in (area.y0..area.y1).filter(|&y| on(y, area.n, last.1)) {
            for pair in ends.windows(2) {
                let line: Vec<usize> = (pair[0]..=pair[1]).map(|x| y * width + x).collect();
                maker.fill(area, &line, 1, f64::INFINITY);
            }
            // The last R-row is kept for the tile below.
            let is_last = !(y + 1..area.y1).any(|y| on(y, area.n, last.1));
            if is_last && area.y1 < height && policy.apron == Apron::Share {
                (area.x0..area.x1).for_each(|x| maker.read(area, y * width + x, 1));
            }
        }
    }
    let after_x: Vec<bool> = maker.known.iter().map(Option::is_some).collect();
    for area in tiles {
        for x in area.x0..area.x1 {
            let mut ends: Vec<usize> = (area.y0..area.y1).filter(|&y| after_x[y * width + x]).collect();
            ends.extend((area.y1 < height).then_some(area.y1));
            for pair in ends.windows(2) {
                let line: Vec<usize> = (pair[0]..=pair[1]).map(|y| y * width + x).collect();
                maker.fill(area, &line, 1 + area.levels(policy.sampling.refine), f64::INFINITY);
            }
        }
    }
    let before = maker.traced.clone();
    tiles.iter().for_each(|area| maker.correct(area));
    (maker, before)
}
