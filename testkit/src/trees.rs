//! Made-up ray trees of up to four bounces: smooth fields with an edge here and there, at every depth, so that hits of one
//! sample are interpolated and others traced.

use rayreel_formats::half::Half3;
use rayreel_formats::math::{Vec3, vec3};
use rayreel_formats::oct::Oct;
use rayreel_formats::tile::{Hit, Radiance, RayClass, RayNode, ShadowState, Shadows, Tile};

use crate::random::Random;

/// Where a hit of a tree is: in the picture and along the tree.
struct Spot {
    u: f32,
    v: f32,
    class: RayClass,
    seed: u64,
}

/// Appends the tree of a sample at `(frame, x, y)` of a grid of `(w, h)` samples.
pub(crate) fn push(tile: &mut Tile, seed: u64, (w, h): (u32, u32), (frame, x, y): (u32, u32, u32)) {
    let shift = frame as f32 * 0.02;
    let spot = Spot { u: x as f32 / w as f32 + shift, v: y as f32 / h as f32, class: RayClass::PRIMARY, seed };
    let mut random = Random(seed ^ u64::from(y) << 24 ^ u64::from(x));
    hit(tile, &spot, &mut random);
}

/// A number from 0 to 1 that is smooth over the picture, another one for each `salt` and place in the tree.
fn smooth(spot: &Spot, salt: u64) -> f32 {
    let mut random = Random(spot.seed.wrapping_mul(31) ^ u64::from(spot.class.0) << 8 ^ salt);
    let mut turn = |range: f32| (random.unit() - 0.5) * range;
    let (a, b, c) = (turn(12.0), turn(12.0), turn(6.0));
    0.5 + 0.5 * libm::sinf(a * spot.u + b * spot.v + c)
}

fn hit(tile: &mut Tile, spot: &Spot, random: &mut Random) {
    let depth = spot.class.depth();
    // A few samples are outliers, and fields are cut into few values: objects and shapes have edges.
    let odd = random.remainder(60) == 0;
    let object = (smooth(spot, 1) * 2.6) as u32 + u32::from(odd);
    let met = smooth(spot, 2) < 0.9;
    let shape = (smooth(spot, 3) * 5.0) as u32;
    let deep = depth < 4 && met;
    let (reflect, refract) = (deep && shape > 0, deep && (shape == 2 || shape == 3));
    let mut shadows = Shadows::default();
    if met {
        shadows.set(0, if smooth(spot, 4) < 0.7 { ShadowState::Lit } else { ShadowState::Blocked });
        shadows.set(usize::from(smooth(spot, 5) < 0.8), ShadowState::Lit);
    }
    tile.tree.nodes.push(RayNode { class: spot.class, hit: met, reflect, refract, shadows });
    let normal = vec3(smooth(spot, 6) - 0.5, smooth(spot, 7) - 0.5, 1.0).normalized();
    let t = 1.0 + smooth(spot, 8);
    tile.hits.push(if met { Hit { triangle: object * 4, t, normal: Oct::encode(normal) } } else { Hit::MISS });
    let colour = |salt: u64| vec3(smooth(spot, salt), smooth(spot, salt + 1), smooth(spot, salt + 2));
    let tint = vec3(0.2, 0.1, 0.3) * (object as f32 * 0.3);
    let weight = |on, salt| if on { Half3::from_vec3(colour(salt) * 0.6) } else { Half3::ZERO };
    // Some colours are above what a display shows, some are black.
    let local = if object == 2 { colour(20) * 2.0 } else { colour(20) * 0.3 + tint };
    let local = Half3::from_vec3(if odd { Vec3::ZERO } else { local });
    tile.radiance.push(Radiance { local, reflect: weight(reflect, 30), refract: weight(refract, 40) });
    let children = [(reflect, spot.class.reflection()), (refract, spot.class.refraction())];
    for (_, class) in children.into_iter().filter(|(on, _)| *on) {
        hit(tile, &Spot { class, ..*spot }, random);
    }
}
