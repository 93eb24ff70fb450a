//! The adaptive policies on real traces: against the independent reference, and with the untraced hits poisoned.

use std::path::Path;

use rayreel_formats::trace::Trace;
use rayreel_replay::image::resolve::Resolver;
use rayreel_replay::policy::{Adaptive, Apron, Limit, NamedPolicy, Policy, Refine};
use rayreel_replay::{FrameReplay, Options, TileSource, replay};

use crate::common::capture;
use crate::common::scenes::moving;
use crate::common::trace::open;
use rayreel_testkit::poison::Poisoned;
use rayreel_testkit::reference::{self, Origin, Outcome};
use rayreel_testkit::{adaptive, preset, switches};

/// Traces of several scenes and both grids; a tile of 24 is a multiple of every block.
fn traces(folder: &Path) -> Vec<(String, Trace)> {
    let room = moving(folder);
    let captures = [
        ("cornell", "--size 50x27 --samples 2x2"),
        ("cornell", "--size 61x50 --samples 1x1"),
        ("teapot", "--size 47x26 --samples 2x2"),
        ("chess", "--size 47x26 --samples 2x2"),
        ("chess", "--size 73x41 --samples 1x1 --frames 60"),
        (room.as_str(), "--size 37x25 --samples 2x2 --frames 2"),
    ];
    let all = captures.iter().enumerate().map(|(i, (scene, options))| {
        let file = folder.join(format!("{i}.rtrace"));
        capture(scene, &format!("{options} --tile 24"), &file);
        (format!("{scene} {options}"), open(&file))
    });
    all.collect()
}

fn policies() -> Vec<Adaptive> {
    let mut list = Vec::new();
    for block in [2, 3, 4, 8] {
        for refine in [Refine::Direct, Refine::Hierarchical] {
            for apron in [Apron::Share, Apron::Retrace] {
                list.push(adaptive(block, refine, apron));
            }
        }
    }
    let mut strict = adaptive(4, Refine::Hierarchical, Apron::Share);
    strict.sampling.similarity.position = Limit::At(0.08);
    strict.sampling.similarity.plane = Limit::At(0.004);
    list.push(strict);
    list.extend(["multirate", "aggressive"].map(|name| preset(name, 8)));
    list.extend(switches::draw(12, 5));
    list
}

fn run<S: TileSource>(source: &S, policy: &Adaptive) -> FrameReplay {
    let frame = source.meta().first_frame;
    replay(source, &Policy::Adaptive(policy.clone()), [frame], Options::default()).unwrap().frames.remove(0)
}

#[track_caller]
fn assert_same(trace: &Trace, frame: &FrameReplay, expected: &Outcome, what: &str) {
    let (width, height) = trace.meta().grid();
    let mut resolver = Resolver::new(trace.meta().width, trace.meta().height, trace.meta().samples);
    for (i, (x, y)) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).enumerate() {
        let how = Origin::from(frame.states.state(x, y));
        assert_eq!(how, expected.how[i], "{what}: sample ({x}, {y})");
        resolver.add(x, y, expected.colours[i].into());
    }
    let (image, bits) = (resolver.finish(), |v: &[f32; 3]| v.map(f32::to_bits));
    let wrong = image.pixels.iter().zip(&frame.image.pixels).position(|(a, b)| bits(a) != bits(b));
    assert_eq!(wrong, None, "{what}: colour of a pixel");
    let counts = &frame.stats.counts;
    let number = |how| expected.count(how);
    assert_eq!(counts.samples_traced, number(Origin::R) + number(Origin::Traced) + number(Origin::Partial), "{what}");
    assert_eq!(counts.samples_partial, number(Origin::Partial), "{what}");
    assert_eq!(counts.samples_interpolated, number(Origin::Interpolated), "{what}");
    assert_eq!(counts.samples_apron, expected.samples_apron, "{what}");
    let kinds = [counts.rays_full, counts.rays_traced, counts.rays_apron]
        .map(|rays| [rays.primary, rays.reflection, rays.refraction, rays.shadow]);
    assert_eq!(kinds, [expected.rays_full, expected.rays_traced, expected.rays_apron], "{what}");
}

#[test]
fn real_traces_replay_like_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    for (name, trace) in traces(folder.path()) {
        let (mut ratios, mut partial) = (Vec::new(), 0);
        for policy in policies() {
            let what = format!("{name} {policy:?}");
            let frame = run(&trace, &policy);
            let expected = reference::replay(&trace, &policy, trace.meta().first_frame);
            assert_same(&trace, &frame, &expected, &what);
            partial += expected.count(Origin::Partial);
            ratios.push(frame.stats.counts.similarity_ratio().unwrap());
        }
        // The comparison means something: some samples pass and some fail.
        assert!(ratios.iter().any(|r| *r > 0.2) && ratios.iter().all(|r| *r < 1.0), "{name}: {ratios:?}");
        // All but the Cornell box have hits below the first that differ where those above do not.
        assert!(partial > 100 || name.starts_with("cornell"), "{name}: {partial} samples decided hit by hit");
    }
}

#[test]
fn untraced_hits_of_real_traces_are_never_read() {
    let folder = tempfile::tempdir().unwrap();
    for (name, trace) in traces(folder.path()) {
        for policy in policies() {
            let clean = run(&trace, &policy);
            let outcome = reference::replay(&trace, &policy, trace.meta().first_frame);
            assert!(clean.stats.counts.samples_interpolated > 0, "{name} {policy:?}: nothing to poison");
            let frame = run(&Poisoned::new(&trace, &outcome, 11), &policy);
            assert_eq!(frame.image, clean.image, "{name} {policy:?}");
            assert_eq!(frame.states, clean.states, "{name} {policy:?}");
            let rays = |f: &FrameReplay| (f.stats.counts.rays_traced, f.stats.counts.rays_apron);
            assert_eq!(rays(&frame), rays(&clean), "{name} {policy:?}");
            assert_ne!(frame.reference, clean.reference, "{name}: the poison is real");
        }
    }
}

/// Tiles are how the work is cut, not what is seen: other tiles, same picture and counts.
#[test]
fn tiles_do_not_show_in_real_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let of = |tile: u32| {
        let file = folder.path().join(format!("{tile}.rtrace"));
        capture("cornell", &format!("--size 60x34 --samples 2x2 --tile {tile}"), &file);
        open(&file)
    };
    let traces = [8, 24, 128].map(of);
    for refine in [Refine::Direct, Refine::Hierarchical] {
        let policy = adaptive(8, refine, Apron::Share);
        let frames = traces.each_ref().map(|trace| run(trace, &policy));
        for frame in &frames[1..] {
            assert_eq!((&frame.image, &frame.states), (&frames[0].image, &frames[0].states));
            assert_eq!(frame.stats.counts, frames[0].stats.counts);
        }
    }
}

/// Undersampling of `chess` misses the target by far. What a first frame does about it, beside moving the limit of colours as far as it
/// once did, brings it nearer.
#[test]
fn a_first_frame_that_misses_its_target_is_mended() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.rtrace");
    capture("chess", "--size 512x256 --samples 1x1", &file);
    let trace = open(&file);
    let psnr = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|&change| change.into()).collect();
        let policy = NamedPolicy::load("multirate", &changes).unwrap().policy;
        let frame = replay(&trace, &policy, [trace.meta().first_frame], Options::default()).unwrap().frames.remove(0);
        frame.stats.quality.and_then(|quality| quality.psnr_db()).unwrap()
    };
    let mended = psnr(&[]);
    let detail = psnr(&["target.first_correct=1"]);
    let correct = psnr(&["target.first_detail=1", "target.strictest=0.2"]);
    let before = psnr(&["target.first_correct=1", "target.first_detail=1", "target.strictest=0.2"]);
    assert!(before < 37.5, "it misses 40.2 dB by far: {before}");
    assert!(mended > before + 0.8, "{mended} dB, {before} before");
    assert!(
        detail > before + 0.3 && correct > before + 0.1,
        "each part does some of it: {detail} and {correct}, {before} before"
    );
}
