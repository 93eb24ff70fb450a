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

use super::Target;
use crate::counts::TileStats;
use crate::image::psnr::SquaredError;

/// The squared error grows with the colour limit to this power. Measured on the five built-in scenes it is 0.4 (provence) to
/// 0.9 (lab).
const GROWTH: f64 = 0.7;

/// The estimate begins as if so many values had been audited and found on target: a few first audits do not move it far.
const PRIOR: f64 = 192.0;

/// The rows above may have spent so much of the error allowed that little or none is left for the rest of the frame. The rest
/// is still allowed this fraction of the target's error, or it would be traced whole.
const LEAST_REST: f64 = 0.25;

/// Smallest factor, whatever `target.strictest`. At 0 every sample would be traced, and no error found would ever say that the
/// limit may be looser. A smaller `target.first_correct` counts as this in the error of a first frame.
const LEAST_FACTOR: f64 = 0.01;

/// What was seen of a frame so far.
#[derive(Clone, Debug, Default)]
struct Seen {
    /// Squared error of the audited values.
    found: SquaredError,
    /// What its sum would be had every tile had factor 1.
    unit: f64,
    /// Samples of the finished tiles.
    samples: u64,
    /// Those that were traced.
    traced: u64,
}

impl Seen {
    fn add(&mut self, stats: &TileStats) {
        self.found = self.found + stats.audited;
        self.unit += stats.audited.sum as f64 / libm::pow(stats.factor, GROWTH);
        self.samples += stats.counts.samples_full;
        self.traced += stats.counts.samples_traced;
    }

    /// The traced share of the samples.
    fn share(&self) -> f64 {
        if self.samples > 0 { self.traced as f64 / self.samples as f64 } else { 0.0 }
    }

    /// Mean squared error as found, 8-bit levels.
    fn mean(&self, aim: f64) -> f64 {
        mean(self.found.sum as f64, self.found.values as f64, aim)
    }
}

/// The mean of so many values, begun as if some had been found on target.
fn mean(sum: f64, values: f64, aim: f64) -> f64 {
    (sum + aim * PRIOR) / (values + PRIOR)
}

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

/// What was seen of frames or of rows, each of which counts less than the one after it.
#[derive(Clone, Copy, Debug, Default)]
struct Past {
    /// What audits found at factor 1: squared error and values.
    unit: f64,
    values: f64,
    /// Samples, and those of them that were traced.
    samples: f64,
    traced: f64,
}

impl Past {
    /// One more, which counts in full.
    fn add(&mut self, seen: &Seen, decay: f64) {
        self.unit = self.unit * decay + seen.unit;
        self.values = self.values * decay + seen.found.values as f64;
        self.samples = self.samples * decay + seen.samples as f64;
        self.traced = self.traced * decay + seen.traced as f64;
    }

    /// Mean squared error at factor 1.
    fn unit(&self, aim: f64) -> f64 {
        mean(self.unit, self.values, aim)
    }

    /// The traced share of the samples.
    fn share(&self) -> f64 {
        if self.samples > 0.0 { self.traced / self.samples } else { 0.0 }
    }
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
        }
        if first {
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
mod tests {
    use super::*;
    use crate::counts::Counts;
    use crate::policy::Limit;

    const TOTAL: u64 = 8 * 1024;

    fn controller(db: f64) -> LimitController {
        LimitController::new(&Target {
            psnr_db: Limit::At(db),
            audit: 8,
            strictest: 0.25,
            loosest: 4.0,
            share: 0.4,
            first_detail: 0.25,
            first_correct: 1.0,
            first_growth: 0.35,
            decay: 0.75,
        })
    }

    /// The same, with stricter limits of correction in first frames.
    fn stricter(db: f64) -> LimitController {
        let target = Target { first_correct: 0.5, ..controller(db).target };
        LimitController::new(&target)
    }

    /// A tile of 1024 samples, `traced` of which were traced, whose audits found a mean squared error of `mean`.
    fn tile(mean: f64, traced: u64, factor: f64) -> TileStats {
        let values = 3_000_000;
        let counts = Counts { samples_full: 1024, samples_traced: traced, ..Counts::default() };
        let audited = SquaredError { sum: (mean * values as f64) as u64, values };
        TileStats { tile: 0, counts, audited, factor }
    }

    /// 20 dB is a mean squared error of a hundredth of 255^2.
    const AIM: f64 = 650.25;

    /// The factor after a first frame of such tiles.
    fn after(mean: f64, traced: u64, factor: f64) -> f64 {
        let mut limit = controller(20.0);
        limit.learn(&[tile(mean, traced, factor); 8], true);
        limit.factor()
    }

    /// The example of POLICIES.md, figure by figure. A tile has 3000 audited values.
    #[test]
    fn the_worked_example_of_the_policies() {
        let tiles = |sum, traced, factor: f64| {
            let counts = Counts { samples_full: TOTAL, samples_traced: traced, ..Counts::default() };
            [TileStats { tile: 0, counts, audited: SquaredError { sum, values: 3000 }, factor }]
        };
        let near = |found: f64, written: f64| assert!((found - written).abs() < 5.0e-4, "{found}, not {written}");
        let mut limit = stricter(20.0);
        near(limit.aim.unwrap(), 650.25);
        // A first frame with twice the error that is aimed at, and a fifth of its samples traced.
        limit.learn(&tiles(3_901_500, TOTAL / 5, 1.0), true);
        near(limit.factor(), 0.277);
        // The next frame comes out on target.
        limit.learn(&tiles(1_950_750, TOTAL / 5, limit.factor()), false);
        near(limit.factor(), 0.279);
        // Had it traced 0.4375 of its samples, both frames together would have 0.3357.
        let mut strict = stricter(20.0);
        strict.learn(&tiles(3_901_500, TOTAL / 5, 1.0), true);
        strict.learn(&tiles(1_950_750, TOTAL * 7 / 16, strict.factor()), false);
        near(strict.factor(), 0.518);
        let mut dear = stricter(20.0);
        dear.learn(&tiles(3_901_500, TOTAL * 7 / 20, 1.0), true);
        near(dear.factor(), 0.625);
        let mut first = stricter(20.0).first(8 * TOTAL);
        near(first.row(&tiles(3_901_500, TOTAL / 5, 1.0)), 0.316);
    }

    #[test]
    fn on_target_the_limit_stays() {
        assert_eq!(controller(20.0).factor(), 1.0);
        assert!((after(AIM, 100, 1.0) - 1.0).abs() < 1.0e-5);
        assert!((after(AIM, 100, 0.5) - 0.5).abs() < 1.0e-3, "whatever it is");
    }

    #[test]
    fn what_stricter_corrections_spared_a_first_frame_the_next_one_will_have() {
        let mut limit = stricter(20.0);
        limit.learn(&[tile(AIM, 100, 1.0); 8], true);
        assert!((limit.factor() - libm::pow(0.5, 0.35 / GROWTH)).abs() < 1.0e-3, "{}", limit.factor());
        // Corrections that let nothing pass: the error is as if they were LEAST_FACTOR.
        let target = Target { first_correct: 0.0, loosest: 99.0, strictest: 0.01, ..limit.target.clone() };
        let mut nothing = LimitController::new(&target);
        nothing.learn(&[tile(AIM, 100, 1.0); 8], true);
        assert!((nothing.factor() - libm::pow(LEAST_FACTOR, 0.35 / GROWTH)).abs() < 1.0e-3, "{}", nothing.factor());
        // Later frames are as strict as the ones after them.
        (0..40).for_each(|_| limit.learn(&[tile(AIM, 100, 1.0); 8], false));
        assert!((limit.factor() - 1.0).abs() < 1.0e-3, "{}", limit.factor());
    }

    #[test]
    fn an_error_off_target_is_met_by_its_power() {
        let growth = |factor: f64| AIM * libm::pow(factor, GROWTH);
        for factor in [0.3, 0.7, 1.5, 3.0] {
            // What was found is what this factor brings more than the aim.
            assert!((after(growth(1.0 / factor), 100, 1.0) - factor).abs() < 1.0e-3, "{factor}");
        }
        assert_eq!((after(growth(10.0), 100, 1.0), after(growth(0.1), 100, 1.0)), (0.25, 4.0), "within the range");
    }

    #[test]
    fn where_much_is_traced_it_is_not_made_stricter() {
        let bad = 9.0 * AIM;
        assert_eq!(after(bad, 500, 1.0), 1.0, "more than the share of 0.4");
        assert_eq!(after(bad, 300, 1.0), 0.25, "less than three quarters of it");
        // 0.35 is half of the way from 0.4 to 0.3.
        assert!((after(bad, 358, 1.0) - 0.625).abs() < 1.0e-2);
        assert!(after(0.5 * AIM, 500, 1.0) > 1.0, "looser it may be");
    }

    #[test]
    fn what_is_much_is_said_by_the_last_frames_together() {
        let bad = 9.0 * AIM;
        // 500 of 1024 samples is more than the share of 0.4, 300 less than three quarters of it; here they take turns.
        let mut limit = controller(20.0);
        limit.learn(&[tile(bad, 500, 1.0); 8], true);
        let factors: Vec<f64> = (0..40)
            .map(|frame| {
                limit.learn(&[tile(bad, [300, 500][frame % 2], 1.0); 8], false);
                limit.factor()
            })
            .collect();
        let (even, odd) = (factors[38], factors[39]);
        // Weighed by 0.75 they have (300 + 0.75 * 500) / 1.75 and (500 + 0.75 * 300) / 1.75 in the end.
        let floor = |traced: f64| 1.0 - 0.75 * ((0.4 - traced / 1024.0) / 0.1).clamp(0.0, 1.0);
        assert!((even - floor(675.0 / 1.75)).abs() < 1.0e-3, "{even}");
        assert!((odd - floor(725.0 / 1.75)).abs() < 1.0e-3, "{odd}");
        // A cut forgets.
        limit.learn(&[tile(bad, 300, 1.0); 8], true);
        assert_eq!(limit.factor(), 0.25);
    }

    #[test]
    fn no_target_out_of_reach_breaks_it() {
        let mut limit = LimitController::new(&Target { strictest: 0.0, share: 1.0, ..controller(99.0).target });
        for (frame, mean) in [9.0e4, 0.0, 9.0e4, 9.0e4].into_iter().enumerate() {
            limit.learn(&[tile(mean, 0, limit.factor()); 8], frame == 0);
            assert!((LEAST_FACTOR..=4.0).contains(&limit.factor()), "{}", limit.factor());
        }
        assert!(limit.factor() < 0.1);
    }

    #[test]
    fn older_frames_count_less() {
        let mut limit = controller(20.0);
        // At factor 1 the first frame had a quarter of the error aimed at, the second as much as that.
        limit.learn(&[tile(AIM * 0.25, 100, 1.0); 8], true);
        let first = limit.factor();
        assert!((first - libm::pow(4.0, 1.0 / GROWTH).min(4.0)).abs() < 1.0e-2, "{first}");
        limit.learn(&[tile(AIM, 100, 1.0); 8], false);
        let mean = (0.75 * 0.25 + 1.0) / 1.75;
        assert!((limit.factor() - libm::pow(1.0 / mean, 1.0 / GROWTH)).abs() < 1.0e-3, "{}", limit.factor());
        // The same again and again: that is what counts.
        (0..40).for_each(|_| limit.learn(&[tile(AIM * 0.5, 100, 1.0); 8], false));
        assert!((limit.factor() - libm::pow(2.0, 1.0 / GROWTH)).abs() < 1.0e-3);
        limit.learn(&[tile(AIM, 100, 1.0); 8], true);
        assert!((limit.factor() - 1.0).abs() < 1.0e-3, "a cut forgets");
    }

    #[test]
    fn a_first_frame_is_steered_row_by_row() {
        let mut frame = controller(20.0).first(TOTAL);
        // On target: nothing to change. Much too good: not looser within a first frame.
        assert!((frame.row(&[tile(AIM, 100, 1.0)]) - 1.0).abs() < 1.0e-4);
        assert_eq!(frame.row(&[tile(0.0, 100, 1.0)]), 1.0);
        // What was saved may be spent: 2 rows of 8 took half of their due, the third takes 1.8 times: all on target.
        let mut frame = controller(20.0).first(TOTAL);
        frame.row(&[tile(0.0, 100, 1.0)]);
        frame.row(&[tile(0.0, 100, 1.0)]);
        assert_eq!(frame.row(&[tile(2.5 * AIM, 100, 1.0)]), 1.0);
        // Twice the error from the start: seven eighths of the frame have 6/7 of the aim left, and twice the error to meet.
        let mut frame = controller(20.0).first(TOTAL);
        let factor = frame.row(&[tile(2.0 * AIM, 100, 1.0)]);
        assert!((factor - libm::pow(6.0 / 7.0 / 2.0, 1.0 / GROWTH)).abs() < 1.0e-3, "{factor}");
    }

    #[test]
    fn a_first_frame_expects_what_its_last_rows_were_like() {
        let rows = |above: f64, below: f64| {
            let mut frame = controller(20.0).first(TOTAL);
            (0..3).for_each(|_| _ = frame.row(&[tile(above, 100, 1.0)]));
            frame.row(&[tile(below, 100, 1.0)])
        };
        assert!((rows(AIM, AIM) - 1.0).abs() < 1.0e-4);
        // Half of the frame has 4.5 / 4 of the aim. The rest may have 0.875 of it, and is expected to have what the rows had by their weights.
        let older: f64 = 0.75 + 0.75 * 0.75 + 0.75 * 0.75 * 0.75;
        let expected = (3.0 + 0.5 * older) / (1.0 + older);
        let factor = libm::pow(0.875 / expected, 1.0 / GROWTH);
        assert!((rows(0.5 * AIM, 3.0 * AIM) - factor).abs() < 1.0e-3, "{factor}");
        assert!(factor < rows(4.0 / 3.0 * AIM, 0.5 * AIM), "the same error, but further up");
    }

    #[test]
    fn a_tile_below_much_detail_begins_finer_where_the_target_is_missed() {
        let frame = controller(20.0).first(TOTAL);
        // 1000 I-samples, of which so many were traced: from a quarter on.
        let above = |traced: u64| {
            let counts = Counts {
                samples_full: 1064,
                samples_reference: 64,
                samples_traced: 64 + traced,
                samples_interpolated: 1000 - traced,
                ..Counts::default()
            };
            TileStats { counts, ..tile(AIM, 0, 1.0) }
        };
        assert!(frame.is_detailed(&above(250), 0.99) && !frame.is_detailed(&above(249), 0.99));
        assert!(!frame.is_detailed(&above(1000), 1.0), "the target is met");
        let grid = Counts { samples_full: 4, samples_reference: 4, samples_traced: 4, ..Counts::default() };
        assert!(!frame.is_detailed(&TileStats { counts: grid, ..tile(AIM, 0, 1.0) }, 0.5), "no I-samples");
        assert_eq!((frame.correct(), stricter(20.0).first(TOTAL).correct()), (1.0, 0.5));
    }

    #[test]
    fn without_a_target_nothing_moves() {
        let mut limit = LimitController::new(&Target { psnr_db: Limit::Off, ..controller(20.0).target });
        limit.learn(&[tile(9.0 * AIM, 100, 1.0); 8], true);
        let mut first = limit.first(TOTAL);
        assert_eq!((limit.factor(), first.row(&[tile(9.0 * AIM, 100, 1.0)]), first.correct()), (1.0, 1.0, 1.0));
    }
}
