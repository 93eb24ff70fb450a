//! Frames of the policy with a history, one after the other.

use rayreel_replay::policy::{Adaptive, Apron, Temporal};
use rayreel_replay::{FrameReplay, TileSource};

use super::maker::{Maker, Memory};
use super::outcome::Outcome;
use crate::past::Past;
use crate::recorded::read;

/// What is known from frame to frame.
struct Chronicle {
    policy: Temporal,
    past: Option<Past>,
    /// By tile: checks, and those that were mistaken, the older the less.
    trust: Vec<(u64, u64)>,
}

/// A frame: what the controller of blocks and limits has decided, which is not decided here.
struct Page<'a> {
    /// Its number.
    frame: u32,
    /// By tile the block and the factor on the colour limit.
    rates: &'a [(u32, f64)],
    /// It is a first one, or comes after a cut.
    is_first: bool,
}

/// What came of a frame.
pub struct Written {
    /// All that a frame without a history has too.
    pub outcome: Outcome,
    /// By tile what audits found: the squared error and the number of values.
    pub audited: Vec<(u64, u64)>,
    /// By tile what is kept: samples, and hits below their primary ones.
    pub kept: Vec<(usize, usize)>,
    /// By entry the hits below its primary one.
    pub below: Vec<usize>,
}

/// Tells frames that were replayed once more, with the blocks and limits that they had.
pub fn retell<S: TileSource>(source: &S, policy: &Temporal, frames: &[FrameReplay]) -> Vec<Written> {
    let (mut chronicle, mut next) = (Chronicle::new(policy), None);
    let pages = frames.iter().map(|frame| {
        let tiles = frame.blocks.tiles().iter().zip(&frame.stats.tiles);
        let rates: Vec<_> = tiles.map(|(&block, tile)| (block, tile.factor)).collect();
        let is_first = next.replace(frame.frame + 1) != Some(frame.frame);
        chronicle.frame(source, &Page { frame: frame.frame, rates: &rates, is_first })
    });
    pages.collect()
}

impl Chronicle {
    /// Nothing is known yet.
    fn new(policy: &Temporal) -> Self {
        Self { policy: policy.clone(), past: None, trust: Vec::new() }
    }

    /// The next frame.
    fn frame<S: TileSource>(&mut self, source: &S, page: &Page<'_>) -> Written {
        let (meta, rules) = (source.meta(), &self.policy.history);
        let recorded = read(source, page.frame, true);
        let target = &self.policy.multirate.target;
        let mut sampling = self.policy.multirate.sampling.clone();
        if page.is_first && target.psnr_db.value().is_some() {
            sampling.correct = super::stricter(&sampling.correct, target.first_correct);
        }
        let adaptive = Adaptive { block: 0, apron: Apron::Share, sampling };
        let mut tiles = super::areas(meta, page.rates);
        if page.is_first {
            self.past = None;
            self.trust = vec![(0, 0); tiles.len()];
        }
        for (area, (checks, mistaken)) in tiles.iter_mut().zip(&self.trust) {
            area.is_trusted = *mistaken as f64 <= rules.trust * *checks as f64;
        }
        let memory = Memory { rules, frame: page.frame, past: self.past.as_ref() };
        let (mut maker, before) = super::decide(meta, &tiles, Maker::new(&adaptive, &recorded, Some(memory)));
        let audited = tiles.iter().map(|area| match target.psnr_db.value() {
            Some(_) => maker.audit(area, meta.samples as usize, page.frame.into(), target.audit.into()),
            None => (0, 0),
        });
        let audited = audited.collect();
        let mut past = Past::new(rules, &recorded);
        let (mut kept, mut below) = (vec![(0, 0); tiles.len()], Vec::new());
        for (entry, x, y) in Past::places(rules, &recorded) {
            let known = maker.known[y * recorded.width + x].as_ref().expect("every sample is decided");
            past.keep(entry, &known.tree, known.age);
            let tile = tiles.iter().position(|area| (area.x0..area.x1).contains(&x) && (area.y0..area.y1).contains(&y));
            let sums = &mut kept[tile.expect("tiles cover the frame")];
            below.push(past.below(entry));
            *sums = (sums.0 + 1, sums.1 + below[entry]);
        }
        for (area, sums) in tiles.iter().zip(&mut self.trust) {
            let new = maker.history.checked.get(&(area.x0, area.y0)).copied().unwrap_or_default();
            *sums = (sums.0 / 2 + new.0, sums.1 / 2 + new.1);
        }
        let outcome = maker.account(&tiles, &before);
        self.past = Some(past);
        Written { outcome, audited, kept, below }
    }
}
