//! How far the experiment is, over everything that is to be done.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use rayreel_study::point::key::Point;
use rayreel_study::point::task::Missing;
use rayreel_study::point::wanted::Figures;

use crate::plan::Capture;

/// What is told while the experiment runs.
pub struct Progress<'a> {
    /// Work done, of [`Self::total`].
    pub done: u64,
    /// All the work that was missing.
    pub total: u64,
    /// What is being done.
    pub doing: &'a dyn Fn() -> String,
    /// A figure that was found just now, for people who do not want to wait for all of them.
    pub found: Option<&'a str>,
}

/// Whoever is told; from any thread, one at a time.
pub type Tell<'a> = dyn FnMut(&Progress<'_>) + Send + 'a;

/// What work belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Item {
    /// A capture: tracing it.
    Capture(usize),
    /// A point: replaying it.
    Point(usize),
}

/// Adds up the work of all threads.
pub struct Meter<'a>(Mutex<Inner<'a>>);

struct Inner<'a> {
    tell: &'a mut Tell<'a>,
    total: u64,
    done: u64,
    /// Work done of the items that are not finished.
    open: BTreeMap<Item, u64>,
}

impl Inner<'_> {
    fn all_done(&self) -> u64 {
        self.done + self.open.values().sum::<u64>()
    }
}

impl<'a> Meter<'a> {
    /// Nothing of `total` is done.
    pub fn new(total: u64, tell: &'a mut Tell<'a>) -> Self {
        Self(Mutex::new(Inner { tell, total, done: 0, open: BTreeMap::new() }))
    }

    fn locked<T>(&self, change: impl FnOnce(&mut Inner<'a>) -> T) -> T {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Item `item` of weight `weight` is done to `part` of `whole`.
    pub fn tell(&self, item: Item, weight: u64, (part, whole): (u64, u64), doing: &dyn Fn() -> String) {
        let done = u128::from(weight) * u128::from(part.min(whole)) / u128::from(whole.max(1));
        self.locked(|inner| {
            inner.open.insert(item, done as u64);
            let (done, total) = (inner.all_done(), inner.total);
            (inner.tell)(&Progress { done, total, doing, found: None });
        });
    }

    /// A figure was found.
    pub fn found(&self, text: &str) {
        self.locked(|inner| {
            let (done, total, doing) = (inner.all_done(), inner.total, || text.to_owned());
            (inner.tell)(&Progress { done, total, doing: &doing, found: Some(text) });
        });
    }

    /// An item is finished.
    pub fn close(&self, item: Item, weight: u64) {
        self.locked(|inner| {
            inner.open.remove(&item);
            inner.done += weight;
        });
    }

    /// Work of this weight is all that is left.
    pub fn left(&self, weight: u64) {
        self.locked(|inner| inner.done = inner.total.saturating_sub(weight));
    }
}

/// Measured work on a sample at the paper's size, in tenths of a microsecond of a core: to capture it,
const CAPTURE: u64 = 35;
/// to trace it without coding it,
const TRACE: u64 = 10;
/// to decode it,
const DECODE: u64 = 12;
/// to replay it under a policy,
const REPLAY: u64 = 4;
/// to simulate all its rays.
const MACHINE: u64 = 380;

/// Expected work of capturing, or of tracing what is not captured.
pub fn capture_weight(capture: &Capture) -> u64 {
    capture.samples() * if capture.is_live() { TRACE } else { CAPTURE }
}

/// Expected work on what is missing of a point: a replay that need not decode is much faster, and an adaptive policy traces
/// less than a third.
pub fn point_weight(capture: &Capture, point: &Point, missing: Missing) -> u64 {
    if !missing.any() {
        return 0;
    }
    let frames = u64::from(capture.meta.frames);
    let simulated = match &point.wanted.figures {
        Figures::Row => {
            if missing.row && point.machine.is_some() {
                frames
            } else {
                0
            }
        }
        Figures::Frames { simulated, .. } => simulated.len() as u64,
    };
    let machine = if point.policy.policy.kind() == "full" { MACHINE } else { MACHINE * 3 / 10 };
    let replay = if capture.is_live() { REPLAY } else { DECODE + REPLAY };
    capture.samples() / frames * (replay * frames + machine * simulated)
}
