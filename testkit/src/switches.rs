//! Policies over many combinations of switches, for the comparison with the second implementation.

use rayreel_replay::policy::{Adaptive, Apron, Correct, First, Limit, Refine, Shade};

use crate::policies::adaptive;
use crate::random::Random;

/// `count` policies whose switches are drawn by chance; blocks of 2, 3, 4 and 8.
pub fn draw(count: usize, seed: u64) -> Vec<Adaptive> {
    let mut random = Random(seed);
    (0..count).map(|_| one(&mut random)).collect()
}

fn one(random: &mut Random) -> Adaptive {
    let mut flag = |of: u32| random.remainder(of) == 0;
    let refine = if flag(3) { Refine::Direct } else { Refine::Hierarchical };
    let apron = if flag(2) { Apron::Share } else { Apron::Retrace };
    let (object_id, shadow, predict) = (!flag(4), !flag(3), flag(2));
    let (secondary, deep, stand_in) = (!flag(3), !flag(3), flag(2));
    let (first, weighed) = (if flag(2) { First::Hits } else { First::Colours }, flag(2));
    let mut pick = |list: &[f64]| match list[random.remainder(list.len() as u32) as usize] {
        value if value < 0.0 => Limit::Off,
        value => Limit::At(value),
    };
    let mut policy = adaptive(pick(&[2.0, 3.0, 4.0, 8.0]).value().unwrap() as u32, refine, apron);
    let mut tests = &mut policy.sampling.similarity;
    (tests.object_id, tests.shadow, tests.predict, tests.secondary) = (object_id, shadow, predict, deep);
    tests.normal_deg = pick(&[-1.0, 5.0, 20.0, 20.0]);
    tests.position = pick(&[-1.0, -1.0, -1.0, 0.2]);
    tests.plane = pick(&[-1.0, -1.0, -1.0, 0.1]);
    tests.texture = pick(&[-1.0, -1.0, 0.1]);
    tests.colour = pick(&[-1.0, 0.05, 0.1, 0.3]);
    tests.unlike = pick(&[-1.0, 0.1, 0.8]);
    (tests.unlike_primary, tests.first) = (pick(&[-1.0, 0.1, 0.5]), first);
    (policy.sampling.secondary, policy.sampling.stand_in) = (secondary, stand_in);
    policy.sampling.correct = Correct {
        passes: pick(&[0.0, 1.0, 8.0]).value().unwrap() as u32,
        colour: pick(&[-1.0, 0.02, 0.1]),
        colour_alone: pick(&[-1.0, 0.05, 0.2]),
        weighed,
    };
    tests = &mut policy.sampling.similarity;
    tests.convexity = pick(&[-1.0, -1.0, 0.0, 0.1]);
    if !secondary && pick(&[0.0, 1.0]) == Limit::At(1.0) {
        policy.sampling.shade = Shade::Attributes;
        policy.sampling.shade_ambient = 0.2;
    }
    policy
}
