//! Feedback, cuts and rings on made-up tiles, by hand.

use rayreel_formats::math::vec3;
use rayreel_formats::scene::Meta;

use super::*;
use crate::counts::{Counts, RayCounts};
use crate::image::psnr::SquaredError;
use crate::policy::{NamedPolicy, Policy};

/// Tiles of 16 samples, 4 x 2 of them, the last column and row cut.
fn meta() -> Meta {
    Meta {
        tool: String::new(),
        scene: String::new(),
        scene_hash: [0; 32],
        width: 60,
        height: 30,
        samples: 1,
        tile: 16,
        first_frame: 0,
        frames: 100,
        max_depth: 1,
        min_weight: 0.0,
        lights: Vec::new(),
    }
}

/// A camera that looks along -z, turned by `degrees` about the y axis.
fn camera(degrees: f64) -> Camera {
    let (s, c) = (libm::sin(degrees.to_radians()) as f32, libm::cos(degrees.to_radians()) as f32);
    let (right, down, forward) = (vec3(c, 0.0, s) * 0.02, vec3(0.0, -0.02, 0.0), vec3(s, 0.0, -c));
    Camera { eye: vec3(1.0, 2.0, 3.0), corner: forward - right * 30.0 - down * 15.0, right, down }
}

/// A multirate policy of blocks 2 to 16 that starts at 4, with these changes. At block 4 it raises at a balance of 0.5, at block 8 of
/// 0.25.
fn controller(changes: &[&str]) -> RateController {
    let fixed =
        ["start=4", "finest=2", "coarsest=16", "raise=1", "lower=4", "alternate=0.25", "hold=1", "cut_change=1"];
    let all: Vec<String> = fixed.iter().chain(changes).map(|s| (*s).into()).collect();
    RateController::new(&NamedPolicy::load("multirate", &all).unwrap().policy, &meta())
}

/// Tiles of 1000 samples, 100 of them R-samples, and so many traced I-samples for each; three rays a traced sample.
fn stats(balances: &[f64; 8]) -> Vec<TileStats> {
    let counts = |balance: f64| {
        let traced = (balance * 100.0).round() as u64;
        Counts {
            samples_full: 1000,
            samples_reference: 100,
            samples_traced: 100 + traced,
            samples_interpolated: 900 - traced,
            rays_traced: RayCounts { primary: 100 + traced, shadow: 200 + 2 * traced, ..RayCounts::default() },
            ..Counts::default()
        }
    };
    let tile = |(tile, &balance): (u32, &f64)| TileStats {
        tile,
        counts: counts(balance),
        audited: SquaredError::default(),
        factor: 1.0,
    };
    (0..8).zip(balances).map(tile).collect()
}

/// The blocks of tile 0 over frames from `first` on, all of whose tiles have these balances.
fn blocks(control: &mut RateController, first: u32, balances: &[f64]) -> Vec<u32> {
    let step = |(frame, &balance): (u32, &f64)| {
        let rates = control.rates(frame, &camera(0.0));
        control.learn(frame, &camera(0.0), &rates, &stats(&[balance; 8]));
        rates.blocks()[0]
    };
    (first..).zip(balances).map(step).collect()
}

#[test]
fn blocks_follow_the_balance_of_the_frame_before() {
    // Even and odd frames alike: 0.1 and 6 are past the further thresholds too.
    let balances = [0.1, 0.1, 0.1, 0.1, 6.0, 6.0, 6.0, 6.0, 6.0];
    assert_eq!(blocks(&mut controller(&[]), 0, &balances), [4, 8, 16, 16, 16, 8, 4, 2, 2]);
}

#[test]
fn nothing_changes_in_the_band() {
    assert_eq!(blocks(&mut controller(&[]), 0, &[0.51, 3.99, 1.0, 3.9, 0.6, 2.0]), [4; 6]);
}

#[test]
fn thresholds_are_inclusive_and_alternate() {
    // 0.5 raises in even frames, 0.4 in odd ones; 4 lowers in even, 5 in odd.
    assert_eq!(blocks(&mut controller(&[]), 0, &[0.5, 0.4, 1.0]), [4, 8, 8]);
    assert_eq!(blocks(&mut controller(&[]), 1, &[0.45, 0.5, 1.0]), [4, 4, 8]);
    assert_eq!(blocks(&mut controller(&[]), 1, &[0.4, 1.0]), [4, 8]);
    assert_eq!(blocks(&mut controller(&[]), 1, &[4.5, 4.0, 1.0]), [4, 4, 2]);
    assert_eq!(blocks(&mut controller(&[]), 1, &[5.0, 1.0]), [4, 2]);
}

/// A block twice as large must have few traced I-samples: half as many for each R-sample at each step up.
#[test]
fn the_larger_the_block_the_less_it_is_raised() {
    let next =
        |start: u32, balance: f64| blocks(&mut controller(&[&format!("start={start}")]), 0, &[balance, balance])[1];
    assert_eq!([next(2, 1.0), next(4, 0.5), next(8, 0.25)], [4, 8, 16]);
    assert_eq!([next(2, 1.01), next(4, 0.51), next(8, 0.26)], [2, 4, 8]);
    assert_eq!([next(16, 0.0), next(2, 9.0)], [16, 2], "within the range");
}

/// Dear samples and lenient limits: what a finer grid finds is worth less.
#[test]
fn thresholds_grow_with_rays_and_limit() {
    let balance = Balance::new(&multirate(), 1.0);
    let asks = |traced: f64, rays: u64, factor: f64| {
        let mut tile = stats(&[traced; 8]).remove(0);
        tile.counts.rays_traced = RayCounts { primary: tile.counts.samples_traced * rays, ..RayCounts::default() };
        balance.asks(4, factor, &tile)
    };
    // Four times the rays: twice the thresholds.
    assert_eq!([asks(4.0, 3, 1.0), asks(4.0, 12, 1.0), asks(8.0, 12, 1.0), asks(1.0, 12, 1.0)], [-1, 0, -1, 1]);
    assert_eq!([asks(2.0, 3, 0.5), asks(0.5, 3, 0.5), asks(4.0, 3, 2.0)], [-1, 0, 0]);
    // Nothing but R-samples asks for nothing.
    let mut bare = stats(&[0.0; 8]).remove(0);
    bare.counts.samples_reference = bare.counts.samples_full;
    assert_eq!(balance.asks(4, 1.0, &bare), 0);
}

/// The preset with the thresholds of [`controller`].
fn multirate() -> Multirate {
    let set = ["start=4", "finest=2", "coarsest=16", "raise=1", "lower=4"].map(String::from);
    match NamedPolicy::load("multirate", &set).unwrap().policy {
        Policy::Multirate(multirate) => multirate,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_change_needs_frames_in_a_row() {
    let mut control = controller(&["hold=3"]);
    assert_eq!(blocks(&mut control, 0, &[0.1, 0.1, 1.0, 0.1, 0.1, 0.1, 1.0]), [4, 4, 4, 4, 4, 4, 8]);
    // The opposite wish starts the count again, and so does a change.
    assert_eq!(blocks(&mut controller(&["hold=2"]), 0, &[0.1, 9.0, 0.1, 0.1, 0.1, 0.1]), [4, 4, 4, 4, 8, 8]);
}

#[test]
fn a_balance_on_a_threshold_holds_its_block() {
    // A larger block has a larger balance, and crosses the threshold with every change. With a band it does not.
    let chase = |changes: &[&str]| {
        let (mut control, mut balance, mut seen) = (controller(changes), 0.5, Vec::new());
        for frame in 0..12 {
            let block = blocks(&mut control, frame, &[balance])[0];
            seen.push(block);
            balance = if control.rates(frame + 1, &camera(0.0)).blocks()[0] > 4 { 1.1 } else { 0.5 };
        }
        seen.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    assert_eq!(chase(&["raise=1", "lower=1", "alternate=0"]), 11, "to and fro");
    assert_eq!(chase(&["raise=1", "lower=4", "alternate=0"]), 1, "once");
    // Equal thresholds that alternate: odd frames leave both balances alone, so it is half as often.
    assert_eq!(chase(&["raise=1", "lower=1", "alternate=0.25"]), 6);
}

#[test]
fn a_cut_starts_again() {
    let start = |control: &RateController, frame, degrees| control.rates(frame, &camera(degrees)).blocks() == [4; 8];
    let mut control = controller(&["cut_deg=10"]);
    assert!(start(&control, 7, 0.0), "a first frame");
    assert_eq!(blocks(&mut control, 7, &[0.1, 0.1]), [4, 8]);
    assert!(!start(&control, 9, 9.9), "the next frame, hardly turned");
    assert!(start(&control, 9, 10.1), "turned");
    assert!(start(&control, 10, 0.0) && start(&control, 8, 0.0), "not the next frame");
    // The frame after a turn follows on from the start, not from before.
    let (at, turned) = (control.rates(9, &camera(50.0)), camera(50.0));
    control.learn(9, &turned, &at, &stats(&[0.1; 8]));
    assert_eq!(control.rates(10, &turned).blocks(), [8; 8]);
}

/// A unit vector of f32 is not quite one: its product with itself may be below 1.
#[test]
fn the_same_camera_is_no_cut_at_any_limit() {
    for degrees in 0_u8..90 {
        let (mut control, view) = (controller(&["cut_deg=0"]), camera(degrees.into()));
        let rates = control.rates(0, &view);
        control.learn(0, &view, &rates, &stats(&[0.1; 8]));
        assert_eq!(control.rates(1, &view).blocks(), [8; 8], "{degrees}");
    }
}

#[test]
fn ratios_that_change_too_much_are_a_cut() {
    let mut control = controller(&["cut_change=0.3"]);
    // From 0.99 interpolated to 0.5 in the mean: seen after frame 2, so frame 3 starts again, and frame 4 follows frame 3.
    assert_eq!(blocks(&mut control, 0, &[0.1, 0.1, 4.5, 0.1, 0.1]), [4, 8, 16, 4, 8]);
    // Half of the tiles change by as much: 0.24 in the mean is none.
    let mut control = controller(&["cut_change=0.3"]);
    for (frame, other) in [(0, 0.1), (1, 0.1), (2, 4.5)] {
        let rates = control.rates(frame, &camera(0.0));
        control.learn(frame, &camera(0.0), &rates, &stats(&[0.1, other, 0.1, other, 0.1, other, 0.1, other]));
    }
    assert_eq!(control.rates(3, &camera(0.0)).blocks()[0], 16);
}

#[test]
fn each_tile_goes_its_own_way() {
    let mut control = controller(&[]);
    let rates = control.rates(0, &camera(0.0));
    control.learn(0, &camera(0.0), &rates, &stats(&[0.1, 1.0, 9.0, 0.1, 9.0, 0.1, 1.0, 1.0]));
    let rates = control.rates(1, &camera(0.0));
    assert_eq!(rates.blocks(), [8, 4, 2, 8, 2, 8, 4, 4]);
    let left: Vec<_> = (0..8).map(|tile| rates.tile(tile).left).collect();
    // The first of each row has no neighbour and stands for it.
    assert_eq!(left, [8, 8, 4, 2, 2, 2, 8, 4]);
    assert!((0..8).all(|tile| rates.tile(tile).relax == 1.0));
}

/// Middles of the tiles: x 8, 24, 40, 54, y 8 and 23 (the last are cut off at 60 and 30). Gaze at (24, 8), so distances in
/// heights of 30 are 16/30, 0, 16/30, 1 above and below with 15/30 more down.
#[test]
fn rings_by_hand() {
    let fixed =
        ["gaze_x=0.4", "gaze_y=0.26666666666666666", "inner=0.2", "outer=0.8", "finest=2", "coarsest=16", "relax=4"];
    let policy = NamedPolicy::load("foveated", &fixed.map(String::from)).unwrap().policy;

    let control = RateController::new(&policy, &meta());
    let rates = control.rates(3, &camera(0.0));
    let far = libm::hypot(16.0, 15.0) / 30.0;
    let distances = [16.0 / 30.0, 0.0, 16.0 / 30.0, 1.0, far, 0.5, far, libm::hypot(30.0, 15.0) / 30.0];
    for (tile, distance) in (0..).zip(distances) {
        let way = ((distance - 0.2f64) / 0.6).clamp(0.0, 1.0);
        let relax = rates.tile(tile).relax;
        assert!((relax - (1.0 + 3.0 * way)).abs() < 1.0e-9, "tile {tile}: {relax}");
    }
    // Three steps over 0.6: the next block each 0.2, the largest from 0.8 on.
    assert_eq!(rates.blocks(), [4, 2, 4, 16, 8, 4, 8, 16]);
    // A single ring if both radii are equal.
    let Policy::Foveated(rings) = policy else { unreachable!("loaded as foveated") };
    let sharp = Policy::Foveated(Foveated { inner: 0.5, outer: 0.5, ..rings });
    assert_eq!(RateController::new(&sharp, &meta()).rates(0, &camera(0.0)).blocks(), [16, 2, 16, 16, 16, 2, 16, 16]);
}

#[test]
fn fixed_policies_have_one_rate() {
    let rates =
        |name: &str| RateController::new(&NamedPolicy::load(name, &[]).unwrap().policy, &meta()).rates(0, &camera(0.0));
    assert_eq!(rates("full").blocks(), [1; 8]);
    assert_eq!(rates("adaptive-8").blocks(), [8; 8]);
    assert_eq!(rates("adaptive-8").tile(5), TileRate { block: 8, left: 8, relax: 1.0, correct: 1.0 });
}
