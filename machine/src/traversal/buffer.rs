//! The ray buffer in front of the units of a core, and the hits behind them: what the SRP sees of them.

use std::collections::VecDeque;

use crate::link::{RayMessage, RayRef};
use crate::ti::DispatchCounters;
use crate::time::{TiCycle, When};

/// The ray buffer of a core.
#[derive(Debug)]
pub struct RayBuffer {
    entries: usize,
    waiting: VecDeque<RayMessage>,
    results: VecDeque<RayMessage>,
    /// Rays that came and have not finished.
    inside: usize,
    /// Cycles before this one are in the counters.
    accounted: TiCycle,
    counters: DispatchCounters,
}

impl RayBuffer {
    /// A buffer of so many entries.
    pub fn new(entries: u32) -> Self {
        Self {
            entries: entries as usize,
            waiting: VecDeque::new(),
            results: VecDeque::new(),
            inside: 0,
            accounted: TiCycle::default(),
            counters: DispatchCounters::default(),
        }
    }

    /// Whether an entry is free.
    #[inline]
    pub fn has_room(&self) -> bool {
        self.waiting.len() < self.entries
    }

    /// A ray comes at cycle `now`, and can be taken from the next on.
    ///
    /// # Panics
    /// When no entry is free.
    pub fn push(&mut self, now: TiCycle, ray: RayRef) {
        assert!(self.has_room(), "the ray buffer is full");
        self.waiting.push_back(RayMessage { at: now + 1, ray });
        self.inside += 1;
    }

    /// When ray number `number` of those that wait can be taken.
    pub fn taken_from(&self, number: usize) -> When {
        When::from(self.waiting.get(number).map(|ray| ray.at))
    }

    /// Takes up to `most` rays that can be taken at cycle `now`.
    pub fn take(&mut self, now: TiCycle, most: usize) -> impl Iterator<Item = RayRef> {
        let ready = self.waiting.iter().take(most).take_while(|ray| ray.at <= now).count();
        self.counters.rays += ready as u64;
        self.waiting.drain(..ready).map(|message| message.ray)
    }

    /// Rays are through at cycle `now`.
    pub fn finish(&mut self, now: TiCycle, rays: &mut VecDeque<RayRef>) {
        self.inside -= rays.len();
        self.results.extend(rays.drain(..).map(|ray| RayMessage { at: now, ray }));
    }

    /// Hits that the SRP has not taken yet.
    #[inline]
    pub fn results(&mut self) -> &mut VecDeque<RayMessage> {
        &mut self.results
    }

    /// Rays that came and have not finished.
    #[inline]
    pub fn inside(&self) -> usize {
        self.inside
    }

    /// Accounts for the cycles before `now`, in which nothing has changed and `places` for rays were free.
    pub fn account(&mut self, now: TiCycle, places: usize) {
        self.counters = self.counters_before(now, places);
        self.accounted = now;
    }

    /// The counters with the cycles before `now`, in which nothing has changed.
    pub fn counters_before(&self, now: TiCycle, places: usize) -> DispatchCounters {
        let (mut counters, gap) = (self.counters, now.since(self.accounted));
        counters.active += if self.inside > 0 { gap } else { 0 };
        counters.full += if !self.waiting.is_empty() && places == 0 { gap } else { 0 };
        counters
    }

    /// Rays that were taken.
    pub fn rays(&self) -> u64 {
        self.counters.rays
    }

    /// What waits, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        format!("ray buffer {} of {}", self.waiting.len(), self.entries)
    }
}
