//! Frames of the policy with a history, one after the other.

use rayreel_replay::TileSource;
use rayreel_replay::policy::{Adaptive, Apron, Temporal};

use super::maker::{Maker, Memory};
use super::outcome::Outcome;
use crate::past::Past;
use crate::recorded::read;

/// What is known from frame to frame.
pub struct Chronicle {
    policy: Temporal,
    past: Option<Past>,
    /// By tile: checks, and those that were mistaken, the older the less.
    trust: Vec<(u64, u64)>,
}

/// A frame: what the controller of blocks and limits has decided, which this does not look at.
pub struct Page<'a> {
    /// Its number.
    pub frame: u32,
    /// By tile the block and the factor on the colour limit.
    pub rates: &'a [(u32, f64)],
    /// It is a first one, or comes after a cut.
    pub is_first: bool,
}

/// What came of a frame.
pub struct Written {
    /// All that a frame without a history has too.
    pub outcome: Outcome,
    /// By tile what audits found: the squared error and the number of values.
    pub audited: Vec<(u64, u64)>,
    /// By tile what is kept: samples, and hits below their primary ones.
    pub kept: Vec<(usize, usize)>,
}

impl Chronicle {
    /// Nothing is known yet.
    pub fn new(policy: &Temporal) -> Self {
        Self { policy: policy.clone(), past: None, trust: Vec::new() }
    }

    /// The next frame.
    pub fn frame<S: TileSource>(&mut self, source: &S, page: &Page<'_>) -> Written {
        let (meta, rules) = (source.meta(), &self.policy.history);
        let recorded = read(source, page.frame, true);
        let sampling = self.policy.multirate.sampling.clone();
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
        let target = &self.policy.multirate.target;
        let audited = tiles.iter().map(|area| match target.psnr_db.value() {
            Some(_) => maker.audit(area, meta.samples as usize, page.frame.into(), target.audit.into()),
            None => (0, 0),
        });
        let audited = audited.collect();
        let mut past = Past::new(rules, &recorded);
        let mut kept = vec![(0, 0); tiles.len()];
        for (entry, x, y) in Past::places(rules, &recorded) {
            let known = maker.known[y * recorded.width + x].as_ref().expect("every sample is decided");
            past.keep(entry, &known.tree, known.age);
            let tile = tiles.iter().position(|area| (area.x0..area.x1).contains(&x) && (area.y0..area.y1).contains(&y));
            let sums = &mut kept[tile.expect("tiles cover the frame")];
            *sums = (sums.0 + 1, sums.1 + past.below(entry));
        }
        for (area, sums) in tiles.iter().zip(&mut self.trust) {
            let new = maker.history.checked.get(&(area.x0, area.y0)).copied().unwrap_or_default();
            *sums = (sums.0 / 2 + new.0, sums.1 / 2 + new.1);
        }
        let outcome = maker.account(&tiles, &before);
        self.past = Some(past);
        Written { outcome, audited, kept }
    }
}
