//! `temporal` on flights through real scenes: against the second implementation, with untraced hits poisoned, and how far the colour is
//! off that stands for a shading which no trace holds.

use rayreel_formats::trace::Trace;
use rayreel_replay::image::srgb;
use rayreel_replay::policy::{NamedPolicy, Policy, Temporal};
use rayreel_replay::{FrameReplay, Options, TileSource, replay};
use rayreel_testkit::poison::Poisoned;
use rayreel_testkit::reference::retell;
use rayreel_testkit::same::assert_same;

use crate::common::capture;
use crate::common::trace::open;

fn temporal(sets: &[&str]) -> Temporal {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    match NamedPolicy::load("temporal", &sets).unwrap().policy {
        Policy::Temporal(temporal) => temporal,
        other => panic!("{other:?}"),
    }
}

fn run<S: TileSource>(source: &S, policy: &Temporal) -> Vec<FrameReplay> {
    let frames = source.meta().frame_numbers();
    replay(source, &Policy::Temporal(policy.clone()), frames, Options::default()).unwrap().frames
}

/// Traces of slow paths.
fn flights(folder: &std::path::Path, size: &str) -> Vec<(&'static str, Trace)> {
    let all = [("teapot", 103), ("lab", 103), ("provence", 103)].map(|(scene, first)| {
        let file = folder.join(format!("{scene}.rtrace"));
        capture(scene, &format!("--size {size} --samples 2x2 --frames {first}..{}", first + 4), &file);
        (scene, open(&file))
    });
    all.into()
}

#[test]
fn real_flights_replay_like_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    for (scene, trace) in flights(folder.path(), "48x28") {
        let deep = ["history.step=1", "history.depth=3", "history.refresh=3", "history.trust=1"];
        for sets in [&[][..], &["attributes=eager", "secondary=false"], &deep] {
            // No cut by the ratios: the second implementation takes frames as they come.
            let mut policy = temporal(sets);
            policy.multirate.cut_change = 1.0;
            let frames = run(&trace, &policy);
            let told = retell(&trace, &policy, &frames);
            for (frame, written) in frames.iter().zip(&told) {
                let what = format!("{scene} {}: {sets:?}", frame.frame);
                assert_same(trace.meta(), frame, &written.outcome, &written.audited, &what);
            }
            let spared = told.iter().flat_map(|written| written.outcome.traced.iter().flatten());
            assert!(spared.map(|traced| traced.spared).sum::<u32>() > 500, "{scene}: {sets:?}");
            let outcomes = frames.iter().zip(&told).map(|(frame, written)| (frame.frame, &written.outcome));
            let poisoned = Poisoned { source: &trace, outcomes: outcomes.collect(), seed: 17 };
            for (frame, clean) in run(&poisoned, &policy).iter().zip(&frames) {
                assert_eq!((&frame.image, &frame.states), (&clean.image, &clean.states), "{scene}: {sets:?}");
                assert_eq!(frame.stats.counts.rays_traced, clean.stats.counts.rays_traced, "{scene}: {sets:?}");
                assert_ne!(frame.reference, clean.reference, "{scene}: the poison is real");
            }
        }
    }
}

/// Where the history was right its colour can be held against the true one: so far is it off where it stands for one that is not known.
#[test]
fn colours_that_stand_for_others_are_near_them() {
    let folder = tempfile::tempdir().unwrap();
    let size = std::env::var("RAYREEL_STAND_IN_SIZE").ok();
    for (scene, trace) in flights(folder.path(), size.as_deref().unwrap_or("96x48")) {
        // In a small picture entries of the preset are far apart.
        let policy = temporal(if size.is_some() { &[] } else { &["history.step=1"] });
        let frames = run(&trace, &policy);
        let told = retell(&trace, &policy, &frames);
        let twins = told.iter().flat_map(|written| &written.outcome.history.twins);
        let shown = |v: f32| f64::from(srgb::code(v));
        let off = |[a, b]: &[[f32; 3]; 2]| (0..3).map(|i| (shown(a[i]) - shown(b[i])).abs()).sum::<f64>() / 3.0;
        let mut levels: Vec<f64> = twins.map(off).collect();
        levels.sort_by(f64::total_cmp);
        let at = |share: f64| levels[((levels.len() - 1) as f64 * share) as usize];
        let hits = told[1..].iter().flat_map(|written| written.outcome.traced.iter().flatten()).filter(|hit| hit.hit);
        let stood_for = hits.clone().filter(|hit| hit.stood_for).count() as f64 / hits.clone().count() as f64;
        let known = hits.clone().filter(|hit| hit.spared > 0).count() as f64 / hits.count() as f64;
        let mean = levels.iter().sum::<f64>() / levels.len() as f64;
        println!(
            "{scene}: of the traced hits {:.1} % had lights that were known, {:.2} % others than recorded; colours off by {mean:.1} levels \
             in the mean, median {:.1}, 90 % {:.1}, 99 % {:.1}",
            100.0 * known,
            100.0 * stood_for,
            at(0.5),
            at(0.9),
            at(0.99)
        );
        assert!(known > 0.04, "{scene}: the history is used");
        assert!(stood_for < 0.03 && at(0.5) < 6.0, "{scene}");
    }
}
