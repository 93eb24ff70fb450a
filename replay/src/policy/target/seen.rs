//! What audits found and what was traced, of a frame and of the frames before it.

use crate::counts::TileStats;
use crate::image::psnr::SquaredError;

/// The squared error grows with the colour limit to this power. Measured on the five built-in scenes it is 0.4 (provence) to
/// 0.9 (lab).
pub const GROWTH: f64 = 0.7;

/// The estimate begins as if so many values had been audited and found on target: a few first audits do not move it far.
const PRIOR: f64 = 192.0;

/// What was seen of a frame so far.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Squared error of the audited values.
    pub found: SquaredError,
    /// What its sum would be had every tile had factor 1.
    pub unit: f64,
    /// Samples of the finished tiles.
    pub samples: u64,
    /// Those that were traced.
    pub traced: u64,
}

impl Seen {
    /// A finished tile.
    pub fn add(&mut self, stats: &TileStats) {
        self.found = self.found + stats.audited;
        self.unit += stats.audited.sum as f64 / libm::pow(stats.factor, GROWTH);
        self.samples += stats.counts.samples_full;
        self.traced += stats.counts.samples_traced;
    }

    /// The traced share of the samples.
    pub fn share(&self) -> f64 {
        if self.samples > 0 { self.traced as f64 / self.samples as f64 } else { 0.0 }
    }

    /// Mean squared error as found, 8-bit levels.
    pub fn mean(&self, aim: f64) -> f64 {
        mean(self.found.sum as f64, self.found.values as f64, aim)
    }
}

/// What was seen of frames or of rows, each of which counts less than the one after it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Past {
    /// What audits found at factor 1: squared error and values.
    unit: f64,
    values: f64,
    /// Samples, and those of them that were traced.
    samples: f64,
    traced: f64,
}

impl Past {
    /// One more, which counts in full.
    pub fn add(&mut self, seen: &Seen, decay: f64) {
        self.unit = self.unit * decay + seen.unit;
        self.values = self.values * decay + seen.found.values as f64;
        self.samples = self.samples * decay + seen.samples as f64;
        self.traced = self.traced * decay + seen.traced as f64;
    }

    /// Mean squared error at factor 1.
    pub fn unit(&self, aim: f64) -> f64 {
        mean(self.unit, self.values, aim)
    }

    /// The traced share of the samples.
    pub fn share(&self) -> f64 {
        if self.samples > 0.0 { self.traced / self.samples } else { 0.0 }
    }
}

/// The mean of so many values, begun as if some had been found on target.
fn mean(sum: f64, values: f64, aim: f64) -> f64 {
    (sum + aim * PRIOR) / (values + PRIOR)
}
