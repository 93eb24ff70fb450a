//! The policies that tests ask for most.

use rayreel_replay::policy::{Adaptive, Apron, Limit, NamedPolicy, Policy, Refine, Sampling, Similarity};

/// What the paper evaluated, with these switches.
pub fn adaptive(block: u32, refine: Refine, apron: Apron) -> Adaptive {
    let similarity = Similarity { object_id: true, normal_deg: Limit::At(10.0), shadow: true, ..Similarity::NONE };
    let sampling = Sampling { refine, similarity, ..Sampling::NONE };
    Adaptive { block, apron, sampling }
}

/// The same as a policy.
pub fn policy(block: u32, refine: Refine, apron: Apron) -> Policy {
    Policy::Adaptive(adaptive(block, refine, apron))
}

/// What a multirate preset does between samples, with one block for all tiles.
///
/// # Panics
/// When there is no such preset, or it is of another kind.
pub fn preset(name: &str, block: u32) -> Adaptive {
    match NamedPolicy::load(name, &[]).unwrap().policy {
        Policy::Multirate(multirate) => Adaptive { block, apron: Apron::Share, sampling: multirate.sampling },
        other => panic!("{name} is {other:?}"),
    }
}
