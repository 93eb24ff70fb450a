//! A second implementation of the policies of cells: the whole frame at once, slow and obvious, written from POLICIES.md and not
//! from the code it checks.

mod attributes;
mod colours;
mod making;

use rayreel_replay::TileSource;
use rayreel_replay::policy::{Apron, Policy, Refine};

use crate::policies::adaptive;
use crate::recorded::read;
use crate::reference::area::{Area, on};
use crate::reference::maker::Maker;
use crate::reference::{Origin, Outcome};
use making::{Cell, Making};

pub use making::Work;

/// Replays one frame; what became of its samples, and what was done in each round.
///
/// # Panics
/// When the policy is none of cells.
pub fn replay<S: TileSource>(source: &S, policy: &Policy, frame: u32) -> (Outcome, Vec<Work>) {
    let (block, deep) = match policy {
        Policy::Whitted1980(values) => (values.block, false),
        Policy::Mitchell1987(values) => (values.block, false),
        Policy::Jin2009(values) => {
            let p = &values.priority;
            (values.block, p.soid + p.ssn + p.ssc + p.ste > 0)
        }
        other => panic!("{other:?} has no cells"),
    };
    let meta = source.meta();
    let recorded = read(source, frame, deep);
    let tiles: Vec<_> = (0..meta.tile_count()).map(|i| Area::new(meta.tile_rect(i), (block, 1.0))).collect();
    // The bill is the same as that of blocks which share their aprons.
    let shared = adaptive(block, Refine::Direct, Apron::Share);
    let (width, height, n) = (recorded.width, recorded.height, block as usize);
    let maker = Maker::new(&shared, &recorded, None);
    let mut making = Making { maker, width, rounds: Vec::new() };
    let lines = |size: usize| (0..size).filter(|at| on(*at, n, size - 1)).collect::<Vec<_>>();
    let (columns, rows) = (lines(width), lines(height));
    for &y in &rows {
        columns.iter().for_each(|x| making.maker.whole(y * width + x, Origin::R, 0));
    }
    for (j, &ya) in rows.iter().enumerate() {
        for (i, &xa) in columns.iter().enumerate() {
            let (xb, yb) = (*columns.get(i + 1).unwrap_or(&xa), *rows.get(j + 1).unwrap_or(&ya));
            let cell = Cell { xa, xb, ya, yb };
            match policy {
                Policy::Whitted1980(values) => colours::whitted(&mut making, values, cell),
                Policy::Mitchell1987(values) => colours::mitchell(&mut making, values, cell),
                Policy::Jin2009(values) => attributes::jin(&mut making, values, cell),
                _ => unreachable!("checked above"),
            }
        }
    }
    let Making { maker, rounds, .. } = making;
    let before = maker.traced.clone();
    (maker.account(&tiles, &before), rounds)
}
