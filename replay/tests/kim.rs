//! `kim2016` on recorded scenes, whose lights have places: shading from attributes and convexity against the slow second
//! implementation, and what a machine is charged for them.

mod common;

use common::{FrameWork, work_of};
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::srp::KernelId;
use rayreel_machine::system::NoProbe;
use rayreel_machine::work::Round;
use rayreel_replay::image::resolve::Resolver;
use rayreel_replay::policy::view::SampleState;
use rayreel_replay::policy::{Adaptive, Policy};
use rayreel_replay::simulate::simulate;
use rayreel_replay::{FrameReplay, NamedPolicy, Options, PathSource, Replayer, TileSource};
use rayreel_testkit::golden::traces;
use rayreel_testkit::poison::Poisoned;
use rayreel_testkit::reference::{self, Origin};

fn kim(sets: &[&str]) -> Adaptive {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    match NamedPolicy::load("kim2016", &sets).unwrap().policy {
        Policy::Adaptive(adaptive) => adaptive,
        other => panic!("{other:?}"),
    }
}

fn run<S: TileSource>(source: &S, policy: &Adaptive) -> FrameReplay {
    let frame = source.meta().first_frame;
    let policy = Policy::Adaptive(policy.clone());
    Replayer::new(source, &policy, Options::default()).unwrap().frame(frame).unwrap()
}

fn works(trace: &Trace, policy: &Adaptive) -> FrameWork {
    work_of(trace, &Policy::Adaptive(policy.clone()), [trace.meta().first_frame]).remove(0)
}

const VARIANTS: [&[&str]; 8] = [
    &[],
    &["shade=colour"],
    &["similarity.convexity=off"],
    &["similarity.convexity=0"],
    &["block=4", "refine=hierarchical", "similarity.normal_deg=60", "similarity.shadow=false"],
    &["block=8", "similarity.object_id=false", "similarity.normal_deg=off", "shade_ambient=0.01"],
    &["block=3", "similarity.secondary=true", "similarity.colour=0.3", "similarity.unlike=0.5"],
    &["correct.passes=0", "similarity.convexity=0.02", "apron=retrace"],
];

#[test]
fn equals_the_reference() {
    let mut interpolated = 0;
    for trace in traces() {
        let (meta, frame_number) = (trace.meta(), trace.meta().first_frame);
        for sets in VARIANTS {
            let policy = kim(sets);
            if !meta.tile.is_multiple_of(policy.block) {
                continue;
            }
            let expected = reference::replay(&trace, &policy, frame_number);
            let frame = run(&trace, &policy);
            let mut resolver = Resolver::new(meta.width, meta.height, meta.samples);
            for (i, (how, colour)) in expected.how.iter().zip(&expected.colours).enumerate() {
                let (x, y) = ((i % expected.width) as u32, (i / expected.width) as u32);
                assert_eq!(Origin::from(frame.states.state(x, y)), *how, "{sets:?}: ({x}, {y})");
                assert_eq!(frame.states.round(x, y), expected.rounds[i], "{sets:?}: ({x}, {y})");
                resolver.add(x, y, (*colour).into());
            }
            let bits = |v: &[f32; 3]| v.map(f32::to_bits);
            assert!(resolver.finish().pixels.iter().map(bits).eq(frame.image.pixels.iter().map(bits)), "{sets:?}");
            interpolated += expected.count(Origin::Interpolated);
            let poisoned = run(&Poisoned::new(&trace, &expected, 3), &policy);
            assert_eq!((&poisoned.image, &poisoned.states), (&frame.image, &frame.states), "{sets:?}: poison");
        }
    }
    assert!(interpolated > 10_000, "{interpolated}");
}

/// Shading changes colours and no decision of the steps; convexity has more traced the smaller its limit is.
#[test]
fn both_settings_do_something() {
    for trace in traces() {
        let plain = ["correct.passes=0", "shade=colour"];
        let (shaded, colours) = (run(&trace, &kim(&plain[..1])), run(&trace, &kim(&plain)));
        assert_eq!(shaded.states, colours.states);
        assert_ne!(shaded.image, colours.image);
        let traced = |limit: &str| run(&trace, &kim(&[plain[0], &format!("similarity.convexity={limit}")]));
        let traced = ["off", "0.1", "0.01", "0"].map(|limit| traced(limit).stats.counts.samples_traced);
        assert!(traced.is_sorted() && traced[0] < traced[3], "{traced:?}");
    }
}

/// Each interpolated sample has its attributes made once, and is shaded once if something was hit.
#[test]
fn machines_are_charged_for_shading() {
    for trace in traces() {
        for sets in [&["block=4", "refine=hierarchical"][..], &[], &["correct.passes=0", "shade=colour"]] {
            let policy = kim(sets);
            let (frame, works) = works(&trace, &policy);
            let sum =
                |of: fn(&Round) -> u32| works.iter().flat_map(|w| &w.rounds).map(|r| u64::from(of(r))).sum::<u64>();
            let (made, attributes, shaded) = (sum(|r| r.interpolated), sum(|r| r.attributes), sum(|r| r.shaded));
            if sets.contains(&"shade=colour") {
                assert_eq!(shaded, 0);
                assert!(attributes < made, "what nothing reads is not made");
            } else {
                assert!(attributes == made && shaded <= made && shaded > made / 2, "{made} {attributes} {shaded}");
            }
            let interpolated = (0..trace.meta().grid().1)
                .flat_map(|y| (0..trace.meta().grid().0).map(move |x| (x, y)))
                .filter(|&(x, y)| frame.states.state(x, y) == SampleState::Interpolated);
            assert!(interpolated.count() as u64 <= made, "what was corrected was made before");
            let machine = NamedMachine::load("sgrt-ti2", &[]).unwrap();
            let policy = Policy::Adaptive(policy);
            let mut replayer = Replayer::new(&trace, &policy, Options::default()).unwrap();
            let named = (machine.name.as_str(), &machine.config);
            let topology = trace.topology();
            let ran = simulate(&mut replayer, trace.meta().first_frame, &topology, named, &mut NoProbe).unwrap();
            let kernel = |id: KernelId| ran.stats.cores.iter().map(move |core| core.srp.kernels[id as usize]);
            assert_eq!(kernel(KernelId::Reshade).map(|k| k.items).sum::<u64>(), shaded);
            assert_eq!(kernel(KernelId::Attributes).map(|k| k.items).sum::<u64>(), attributes);
            let ops = u64::from(machine.config.srp.kernels.shade.ops);
            assert_eq!(kernel(KernelId::Reshade).map(|k| k.ops).sum::<u64>(), shaded * ops);
        }
    }
}
