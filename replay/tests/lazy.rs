//! Attributes of interpolated hits that are made when a test reads them: nothing else changes, and what is made is what the slow
//! second implementation reads.

mod common;

use common::{FrameWork, work_of};
use rayreel_formats::trace::Trace;
use rayreel_machine::work::TileWork;
use rayreel_replay::NamedPolicy;
use rayreel_replay::policy::{Adaptive, Apron, Attributes, First, Limit, Policy};
use rayreel_testkit::golden::traces;
use rayreel_testkit::{preset, reference};

fn works(trace: &Trace, policy: &Adaptive) -> FrameWork {
    work_of(trace, &Policy::Adaptive(policy.clone()), [trace.meta().first_frame]).remove(0)
}

fn with(policy: &Adaptive, attributes: Attributes) -> Adaptive {
    let mut policy = policy.clone();
    policy.sampling.attributes = attributes;
    policy
}

/// The rules of `multirate` and of the paper, with blocks of all sizes.
fn policies() -> Vec<Adaptive> {
    let mut all: Vec<_> = [2, 4, 8, 16].map(|block| preset("multirate", block)).into();
    let Policy::Adaptive(paper) = NamedPolicy::load("paper-ss", &[]).unwrap().policy else { panic!("it is adaptive") };
    all.extend([2, 3, 8].map(|block| Adaptive { block, ..paper.clone() }));
    // Everything below is compared: no colour excuses.
    let mut strict = preset("multirate", 4);
    (strict.sampling.similarity.unlike, strict.sampling.secondary) = (Limit::Off, false);
    all.extend([strict.clone(), Adaptive { apron: Apron::Retrace, ..strict }]);
    all
}

fn attributes(works: &[TileWork]) -> u64 {
    works.iter().flat_map(|work| &work.rounds).map(|round| u64::from(round.attributes)).sum()
}

#[test]
fn only_what_is_read_is_made() {
    let mut total = (0, 0);
    for trace in traces() {
        let tile = trace.meta().tile;
        for policy in policies().iter().filter(|policy| tile.is_multiple_of(policy.block)) {
            let (eager, eager_works) = works(&trace, &with(policy, Attributes::Eager));
            let (lazy, lazy_works) = works(&trace, &with(policy, Attributes::Lazy));
            assert_eq!(lazy, eager, "decisions, colours and rays are the same");
            let (all, made) = (attributes(&eager_works), attributes(&lazy_works));
            let second = reference::replay(&trace, &with(policy, Attributes::Lazy), trace.meta().first_frame);
            if policy.apron == Apron::Share {
                assert_eq!(made, second.attributes, "{policy:?}");
            }
            // A row that two tiles test may be made twice.
            (total.0, total.1) = (total.0 + made, total.1 + all);
            for (lazy, eager) in lazy_works.iter().zip(&eager_works) {
                assert!(lazy.secondary_hits <= eager.secondary_hits, "tile {}", lazy.tile);
                assert_eq!(lazy.rays, eager.rays);
            }
        }
    }
    assert!(total.0 < total.1, "{} of {}", total.0, total.1);
}

fn first(policy: &Adaptive, first: First, excused: Limit) -> Adaptive {
    let mut policy = with(policy, Attributes::Lazy);
    (policy.sampling.similarity.first, policy.sampling.similarity.unlike_primary) = (first, excused);
    policy
}

fn compared(works: &[TileWork]) -> u64 {
    works.iter().flat_map(|work| &work.rounds).map(|round| u64::from(round.tests)).sum()
}

/// What a test looks at first decides nothing. Looking at colours first spares pairs of hits, and attributes.
#[test]
fn the_order_of_tests_decides_nothing() {
    let mut total = [(0, 0); 2];
    for trace in traces() {
        let tile = trace.meta().tile;
        for policy in policies().iter().filter(|policy| tile.is_multiple_of(policy.block)) {
            for excused in [Limit::Off, Limit::At(0.1), Limit::At(0.9)] {
                let orders = [First::Hits, First::Colours].map(|order| works(&trace, &first(policy, order, excused)));
                assert_eq!(orders[0].0, orders[1].0, "{policy:?}");
                for (total, (_, works)) in total.iter_mut().zip(&orders) {
                    *total = (total.0 + compared(works), total.1 + attributes(works));
                }
            }
        }
    }
    assert!(total[1].0 < total[0].0 && total[1].1 <= total[0].1, "{total:?}");
}
