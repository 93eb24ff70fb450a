//! What the integration tests share: synthetic frames, and a slow reference of the adaptive policy.
#![allow(dead_code, reason = "each test binary uses a part of it")]

pub mod poison;
pub mod reference;
pub mod study;
pub mod synthetic;

use rayreel_replay::policy::{Adaptive, Apron, Correct, Limit, Policy, Refine, Similarity};

/// What the paper evaluated, with these switches.
pub fn adaptive(block: u32, refine: Refine, apron: Apron) -> Adaptive {
    let similarity = Similarity {
        object_id: true,
        normal_deg: Limit::At(10.0),
        shadow: true,
        position: Limit::Off,
        plane: Limit::Off,
        texture: Limit::Off,
        colour: Limit::Off,
        predict: false,
        secondary: false,
        unlike: Limit::Off,
    };
    let correct = Correct { passes: 0, colour: Limit::Off };
    Adaptive { block, refine, apron, secondary: false, similarity, correct }
}

/// The same as a policy.
pub fn policy(block: u32, refine: Refine, apron: Apron) -> Policy {
    Policy::Adaptive(adaptive(block, refine, apron))
}
