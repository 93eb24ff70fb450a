//! Holding a quality: the limit on colour differences is moved so that the picture comes out at the PSNR asked for, as a video
//! encoder moves its quantiser.
//!
//! The limit of a tile is multiplied by a factor. The policy cannot see the error of its picture. It estimates it from a few
//! pixels that are traced whole, the audits ([`super::audit`]). The error is taken to grow with the factor to the power of
//! `GROWTH`. So an error found under any factor gives the error at factor 1, and that the factor at which the error would be
//! on target.
//!
//! - **After a frame**, all tiles of the next one have the factor that would have put the last frames on target, each of which
//!   counts less than the one after it (`target.decay`): audits are few, and their chance moves the picture less so.
//! - **In a first frame**, and after a cut, each row of tiles has its own factor. It follows from the rows that are finished,
//!   which end two rows above: the row just above is still at work. Suppose that the rest of the frame is like these rows, the
//!   last ones above all (a quiet wall above says little of the bench below it). Then this factor makes the whole frame end on
//!   target. It is at most 1: limits that are loose above and strict below cost more rays than one limit between them.
//!
//!   A limit alone does not find what slips between R-samples. So where the factor is below 1, a tile below one that is full of detail
//!   has a finer block (`target.first_detail`). And audits come two rows late. Corrections do not: they see at once what neighbours say,
//!   and their limits are stricter from the first row on (`target.first_correct`).
//!
//! The target is not pursued at any price. Where much is traced anyway, a stricter limit costs many rays for little. So the
//! factor goes below 1 only as far as the traced share of the samples stays below `target.share`. That share, too, is one of the
//! last frames: were it of one, a strict frame would forbid the next to be strict, and that one allow it again.
//!
//! POLICIES.md has the formulas and a worked example.

mod seen;

use super::Target;
use crate::counts::TileStats;
use seen::{GROWTH, Past, Seen};

/// The rows above may have spent so much of the error allowed that little or none is left for the rest of the frame. The rest
/// is still allowed this fraction of the target's error, or it would be traced whole.
const LEAST_REST: f64 = 0.25;

/// Smallest factor, whatever `target.strictest`. At 0 every sample would be traced, and no error found would ever say that the
/// limit may be looser. A smaller `target.first_correct` counts as this in the error of a first frame.
const LEAST_FACTOR: f64 = 0.01;

/// Chooses the factor on the colour limit, frame by frame.
#[derive(Clone, Debug)]
pub struct LimitController {
    target: Target,
    /// Mean squared error that is aimed at, in 8-bit levels; none without a target.
    aim: Option<f64>,
    /// The factor that the frames before ask for.
    factor: Option<f64>,
    /// What was seen of them, the older the less.
    past: Past,
}

/// A first frame, whose rows of tiles choose the factor of rows below.
#[derive(Clone, Debug)]
pub struct FirstFrame {
    controller: LimitController,
    seen: Seen,
    /// What was seen of the rows, those further up the less.
    past: Past,
    total: u64,
}

impl LimitController {
    /// For a policy's target.
    pub fn new(target: &Target) -> Self {
        let aim = target.psnr_db.value().map(|db| 255.0 * 255.0 * libm::pow(10.0, -db / 10.0));
        Self { target: target.clone(), aim, factor: None, past: Past::default() }
    }

    /// The factor for a frame that follows the last one.
    pub fn factor(&self) -> f64 {
        self.factor.unwrap_or(1.0)
    }

    /// A first frame of `total` samples.
    pub fn first(&self, total: u64) -> FirstFrame {
        FirstFrame {
            controller: Self { factor: None, ..self.clone() },
            seen: Seen::default(),
            past: Past::default(),
            total,
        }
    }

    /// Takes note of the tiles of a finished frame. `first` says that it followed no other.
    pub fn learn(&mut self, tiles: &[TileStats], first: bool) {
        let Some(aim) = self.aim else { return };
        let mut seen = Seen::default();
        tiles.iter().for_each(|stats| seen.add(stats));
        if first {
            // The next frame has the limits of correction as they are, and with them the error that stricter ones spared this one.
            let Target { first_correct, first_growth, .. } = self.target;
            seen.unit /= libm::pow(first_correct.max(LEAST_FACTOR), first_growth);
            self.past = Past::default();
        }
        self.past.add(&seen, self.target.decay);
        let factor = libm::pow(aim / self.past.unit(aim), 1.0 / GROWTH);
        self.factor = Some(self.limited(factor, self.past.share()));
    }

    /// A factor within the policy's range, where this share of the samples is `traced`.
    fn limited(&self, factor: f64, traced: f64) -> f64 {
        let Target { strictest, loosest, share, .. } = self.target;
        // From three quarters of the share on the floor rises to 1, so that nothing jumps.
        let free = if share > 0.0 { ((share - traced) / (0.25 * share)).clamp(0.0, 1.0) } else { 0.0 };
        factor.clamp((1.0 + (strictest - 1.0) * free).max(LEAST_FACTOR), loosest.max(1.0))
    }
}

impl FirstFrame {
    /// The factor on the limits of correction.
    pub fn correct(&self) -> f64 {
        if self.controller.aim.is_some() { self.controller.target.first_correct } else { 1.0 }
    }

    /// Whether a tile is so full of detail that the one two rows below begins with a finer block, should its factor be `factor`.
    pub fn is_detailed(&self, above: &TileStats, factor: f64) -> bool {
        let between = above.counts.samples_intermediate();
        let traced = between - above.counts.samples_interpolated;
        factor < 1.0 && between > 0 && traced as f64 / between as f64 >= self.controller.target.first_detail
    }

    /// Takes note of a finished row of tiles; the factor for the next row to begin.
    pub fn row(&mut self, tiles: &[TileStats]) -> f64 {
        let Some(aim) = self.controller.aim else { return 1.0 };
        let mut row = Seen::default();
        tiles.iter().for_each(|stats| {
            self.seen.add(stats);
            row.add(stats);
        });
        self.past.add(&row, self.controller.target.decay);
        let found = self.seen.mean(aim);
        let unit = self.past.unit(aim);
        let done = self.seen.samples as f64 / self.total as f64;
        let rest = if done < 1.0 { (aim - done * found) / (1.0 - done) } else { aim };
        self.controller.limited(libm::pow(rest.max(LEAST_REST * aim) / unit, 1.0 / GROWTH).min(1.0), self.seen.share())
    }
}

#[cfg(test)]
mod tests;
