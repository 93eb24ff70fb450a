//! What the tests of several crates share: synthetic frames, and a slow reference of the adaptive policies. Never part of a build.

pub mod poison;
pub mod reference;
pub mod rules;
pub mod second_read;
pub mod switches;
pub mod synthetic;
pub mod trees;

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
pub fn preset(name: &str, block: u32) -> Adaptive {
    match NamedPolicy::load(name, &[]).unwrap().policy {
        Policy::Multirate(own) => Adaptive { block, apron: Apron::Share, sampling: own.sampling },
        other => panic!("{name} is {other:?}"),
    }
}
