//! Tests of the factor on the colour limit.

use super::*;
use crate::counts::Counts;
use crate::image::psnr::SquaredError;
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
