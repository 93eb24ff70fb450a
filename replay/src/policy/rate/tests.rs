//! Feedback, cuts and rings on made-up ratios, by hand.

use rayreel_formats::math::vec3;
use rayreel_formats::scene::Meta;

use super::*;
use crate::counts::Counts;
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

/// A multirate policy of blocks 2 to 16 that starts at 4, with these changes.
fn controller(changes: &[&str]) -> RateController {
    let fixed =
        ["start=4", "finest=2", "coarsest=16", "raise=0.8", "lower=0.4", "alternate=0.1", "hold=1", "cut_change=1"];
    let all: Vec<String> = fixed.iter().chain(changes).map(|s| (*s).into()).collect();
    RateController::new(&NamedPolicy::load("multirate", &all).unwrap().policy, &meta())
}

fn stats(ratios: &[f64; 8]) -> Vec<TileStats> {
    let counts = |ratio: f64| Counts {
        samples_full: 1000,
        samples_traced: 1000 - (ratio * 1000.0).round() as u64,
        samples_interpolated: (ratio * 1000.0).round() as u64,
        ..Counts::default()
    };
    (0..8)
        .zip(ratios)
        .map(|(tile, &ratio)| TileStats { tile, counts: counts(ratio), audited: SquaredError::default(), factor: 1.0 })
        .collect()
}

/// The blocks of tile 0 over frames from `first` on, all of whose tiles have these ratios.
fn blocks(control: &mut RateController, first: u32, ratios: &[f64]) -> Vec<u32> {
    let step = |(frame, &ratio): (u32, &f64)| {
        let rates = control.rates(frame, &camera(0.0));
        control.learn(frame, &camera(0.0), &rates, &stats(&[ratio; 8]));
        rates.blocks()[0]
    };
    (first..).zip(ratios).map(step).collect()
}

#[test]
fn blocks_follow_the_ratio_of_the_frame_before() {
    // Even and odd frames alike: 0.95 and 0.2 are past the shifted thresholds too.
    let ratios = [0.95, 0.95, 0.95, 0.95, 0.2, 0.2, 0.2, 0.2, 0.2];
    assert_eq!(blocks(&mut controller(&[]), 0, &ratios), [4, 8, 16, 16, 16, 8, 4, 2, 2]);
}

#[test]
fn nothing_changes_in_the_band() {
    assert_eq!(blocks(&mut controller(&[]), 0, &[0.41, 0.79, 0.6, 0.799, 0.401, 0.5]), [4; 6]);
}

#[test]
fn thresholds_are_inclusive_and_alternate() {
    // 0.8 raises in even frames, 0.9 in odd ones; 0.4 lowers in even, 0.3 in odd.
    assert_eq!(blocks(&mut controller(&[]), 0, &[0.8, 0.85, 0.6]), [4, 8, 8]);
    assert_eq!(blocks(&mut controller(&[]), 1, &[0.85, 0.8, 0.6]), [4, 4, 8]);
    assert_eq!(blocks(&mut controller(&[]), 1, &[0.9, 0.6]), [4, 8]);
    assert_eq!(blocks(&mut controller(&[]), 1, &[0.35, 0.4, 0.6]), [4, 4, 2]);
    assert_eq!(blocks(&mut controller(&[]), 1, &[0.3, 0.6]), [4, 2]);
}

#[test]
fn a_change_needs_frames_in_a_row() {
    let mut control = controller(&["hold=3"]);
    assert_eq!(blocks(&mut control, 0, &[0.95, 0.95, 0.6, 0.95, 0.95, 0.95, 0.6]), [4, 4, 4, 4, 4, 4, 8]);
    // The opposite wish starts the count again, and so does a change.
    assert_eq!(blocks(&mut controller(&["hold=2"]), 0, &[0.95, 0.1, 0.95, 0.95, 0.95, 0.95]), [4, 4, 4, 4, 8, 8]);
}

#[test]
fn a_ratio_on_a_threshold_holds_its_block() {
    // Coarser blocks find less: the ratio crosses the threshold with every change. With a band it does not.
    let chase = |changes: &[&str]| {
        let (mut control, mut ratio, mut seen) = (controller(changes), 0.7, Vec::new());
        for frame in 0..12 {
            let block = blocks(&mut control, frame, &[ratio])[0];
            seen.push(block);
            ratio = if control.rates(frame + 1, &camera(0.0)).blocks()[0] > 4 { 0.6 } else { 0.7 };
        }
        seen.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    assert_eq!(chase(&["lower=0.65", "raise=0.65", "alternate=0"]), 11, "to and fro");
    assert_eq!(chase(&["lower=0.4", "raise=0.65", "alternate=0"]), 1, "once");
    // Equal thresholds that alternate: odd frames leave both ratios alone, so it is half as often.
    assert_eq!(chase(&["lower=0.65", "raise=0.65", "alternate=0.1"]), 6);
}

#[test]
fn a_cut_starts_again() {
    let start = |control: &RateController, frame, degrees| control.rates(frame, &camera(degrees)).blocks() == [4; 8];
    let mut control = controller(&["cut_deg=10"]);
    assert!(start(&control, 7, 0.0), "a first frame");
    assert_eq!(blocks(&mut control, 7, &[0.95, 0.95]), [4, 8]);
    assert!(!start(&control, 9, 9.9), "the next frame, hardly turned");
    assert!(start(&control, 9, 10.1), "turned");
    assert!(start(&control, 10, 0.0) && start(&control, 8, 0.0), "not the next frame");
    // The frame after a turn follows on from the start, not from before.
    let (at, turned) = (control.rates(9, &camera(50.0)), camera(50.0));
    control.learn(9, &turned, &at, &stats(&[0.95; 8]));
    assert_eq!(control.rates(10, &turned).blocks(), [8; 8]);
}

#[test]
fn ratios_that_change_too_much_are_a_cut() {
    let mut control = controller(&["cut_change=0.3"]);
    // From 0.95 to 0.5 in the mean: seen after frame 2, so frame 3 starts again, and frame 4 follows frame 3.
    assert_eq!(blocks(&mut control, 0, &[0.95, 0.95, 0.5, 0.95, 0.95]), [4, 8, 16, 4, 8]);
    // Half of the tiles change by 0.5: 0.25 in the mean is none.
    let mut control = controller(&["cut_change=0.3"]);
    for (frame, other) in [(0, 0.95), (1, 0.95), (2, 0.45)] {
        let rates = control.rates(frame, &camera(0.0));
        control.learn(frame, &camera(0.0), &rates, &stats(&[0.95, other, 0.95, other, 0.95, other, 0.95, other]));
    }
    assert_eq!(control.rates(3, &camera(0.0)).blocks()[0], 16);
}

#[test]
fn each_tile_goes_its_own_way() {
    let mut control = controller(&[]);
    let rates = control.rates(0, &camera(0.0));
    control.learn(0, &camera(0.0), &rates, &stats(&[0.95, 0.5, 0.1, 0.95, 0.1, 0.95, 0.5, 0.5]));
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
    assert_eq!(RateController::blocks(&policy), [2, 4, 8, 16]);
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
    assert_eq!(rates("adaptive-8").tile(5), TileRate { block: 8, left: 8, relax: 1.0 });
}
