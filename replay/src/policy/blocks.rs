//! The policies of a [`Policy`] at work: blocks of samples, whose size each tile has from [`super::rate`] and whose steps are
//! those of [`super::adaptive`].

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Camera, Meta};

use super::adaptive::{KnownPast, Rules, TileRules};
use super::history::{History, Trust};
use super::lattice::check_tile;
use super::rate::{RateController, Rates};
use super::sampler::{SamplePolicy, Sampler};
use super::tree::Forest;
use super::view::TileView;
use super::{Apron, NamedPolicy, Policy, cells};
use crate::counts::TileStats;
use crate::error::Result;
use rayreel_machine::work::PolicyReads;
use rayreel_machine::work::history::HistoryWork;

impl SamplePolicy for Policy {
    fn name(&self) -> String {
        self.kind().into()
    }

    fn text(&self) -> String {
        toml::to_string(self).expect("the values of a policy are words and numbers, which TOML can hold")
    }

    fn sampler(&self, meta: &Meta) -> Result<Box<dyn Sampler>> {
        if let Some(sampler) = cells::sampler(self, meta)? {
            return Ok(sampler);
        }
        Ok(Box::new(BlockSampler::new(self, meta)?))
    }
}

impl SamplePolicy for NamedPolicy {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn text(&self) -> String {
        self.policy.text()
    }

    fn sampler(&self, meta: &Meta) -> Result<Box<dyn Sampler>> {
        self.policy.sampler(meta)
    }
}

/// A [`Policy`] at work.
#[derive(Clone)]
struct BlockSampler {
    rules: Rules,
    control: RateController,
    /// Each tile has a block or a limit of its own.
    has_rates: bool,
    now: Now,
    /// What the frame before brought, and what is kept of this one.
    histories: Option<Histories>,
}

/// Two histories that take turns.
#[derive(Clone)]
struct Histories {
    before: History,
    /// The one before may be looked at.
    is_open: bool,
    now: History,
    trust: Trust,
}

/// The frame at work.
#[derive(Clone, Default)]
struct Now {
    frame: u32,
    camera: Option<Camera>,
    rates: Rates,
}

impl BlockSampler {
    fn new(policy: &Policy, meta: &Meta) -> Result<Self> {
        let rules = Rules::new(policy, meta)?;
        check_tile(meta.tile, policy)?;
        let has_rates = policy.multirate().is_some() || matches!(policy, Policy::Foveated(_));
        let histories = match policy {
            Policy::Temporal(temporal) => {
                let empty = History::new(&temporal.history, meta);
                Some(Histories {
                    before: empty.clone(),
                    is_open: false,
                    now: empty,
                    trust: Trust::new(&temporal.history, meta.tile_count()),
                })
            }
            _ => None,
        };
        Ok(Self { rules, control: RateController::new(policy, meta), has_rates, now: Now::default(), histories })
    }

    fn tile(&self, view: &TileView) -> TileRules<'_> {
        let eye = self.now.camera.map_or(Vec3::ZERO, |camera| camera.eye);
        let past = self.histories.as_ref().filter(|histories| histories.is_open).map(|histories| KnownPast {
            frame: self.now.frame,
            history: &histories.before,
            is_trusted: histories.trust.of(view.index()),
        });
        self.rules.tile(self.now.rates.tile(view.index()), eye, past)
    }
}

impl Sampler for BlockSampler {
    fn deep(&self) -> bool {
        self.rules.deep()
    }

    fn fork(&self) -> Option<Box<dyn Sampler>> {
        Some(Box::new(self.clone()))
    }

    fn reads(&self) -> PolicyReads {
        self.rules.reads(self.has_rates)
    }

    fn begin_frame(&mut self, frame: u32, camera: &Camera) {
        self.now = Now { frame, camera: Some(*camera), rates: self.control.rates(frame, camera) };
        if let Some(histories) = &mut self.histories {
            std::mem::swap(&mut histories.before, &mut histories.now);
            histories.is_open = !self.now.rates.is_first();
            if !histories.is_open {
                histories.trust.forget();
            }
            histories.now.begin(camera);
        }
    }

    fn begin_tile(&self, view: &mut TileView) {
        self.tile(view).trace_references(view);
    }

    fn shared_rows(&self, view: &TileView) -> Vec<u32> {
        self.tile(view).shared_rows(view.rect())
    }

    fn shares_first_row(&self) -> bool {
        self.rules.reads_neighbours()
    }

    fn waiting_from(&self, view: &TileView) -> (u32, u32) {
        self.tile(view).waiting_from(view.rect())
    }

    fn step_x(&self, view: &mut TileView, right: Option<&Forest>) {
        self.tile(view).step_x(view, right);
    }

    fn step_y(&self, view: &mut TileView, below: Option<&Forest>) {
        self.tile(view).step_y(view, below);
        if let Some(audit) = self.rules.audit {
            let error = audit.run(view, self.now.frame);
            view.audited(error);
        }
    }

    fn end_row(&mut self, row: &[TileStats]) {
        self.now.rates.finished(row);
    }

    fn history(&self, view: &TileView, places: &[u32]) -> HistoryWork {
        let Some(Histories { before, now, .. }) = &self.histories else { return HistoryWork::default() };
        let (kept, kept_below) = now.kept(view);
        HistoryWork { reads: before.spans(places), kept, kept_below }
    }

    fn keep(&mut self, tiles: &[TileView]) {
        if let Some(histories) = &mut self.histories {
            for tile in tiles {
                histories.now.keep(tile);
                histories.trust.learn(tile);
            }
        }
    }

    fn end_frame(&mut self, tiles: &[TileStats]) {
        if let Some(camera) = &self.now.camera {
            self.control.learn(self.now.frame, camera, &self.now.rates, tiles);
        }
    }

    fn block(&self, tile: u32) -> u32 {
        self.now.rates.tile(tile).block
    }

    fn factor(&self, tile: u32) -> f64 {
        self.now.rates.tile(tile).relax
    }

    fn apron(&self) -> Apron {
        self.rules.apron
    }
}
