//! Single plants: lavender, cypress, olive, round trees and bushes, grass, poppies.

use glam::{DAffine3, DVec2, DVec3};

use crate::modelling::{
    Part,
    lathe::lathe_with,
    paint,
    part::sin_cos,
    scatter::{Cluster, Rng},
};

/// A direction: `turn` in turns about the vertical axis, `lean` in radians from it.
fn leaning(turn: f64, lean: f64) -> DVec3 {
    let (s, c) = sin_cos(std::f64::consts::TAU * turn);
    let (ls, lc) = sin_cos(lean);
    DVec3::new(ls * s, lc, ls * c)
}

/// The leafy body of a bush of lavender.
fn lavender_dome(out: &mut Cluster, seed: u32) {
    let dome = lathe_with(4, 7, |row, angle, _| {
        let (s, c) = sin_cos(std::f64::consts::FRAC_PI_2 * row as f64 / 3.0);
        let lump = 1.0 + 0.12 * libm::sin(angle * 3.0 + f64::from(seed));
        if row == 3 { DVec2::new(0.0, 0.38) } else { DVec2::new(0.31 * c * lump, 0.38 * s - 0.03) }
    });
    let dome = Cluster::of(&dome.crease(85.0)).with_uv(|p, _| DVec2::new(0.0, 0.08 + 0.95 * p.y));
    out.stamp(&dome, &DAffine3::IDENTITY, DVec2::ZERO);
}

/// Root and tip of each spike of a bush of lavender, and the way it leans. The golden angle, as in a
/// sunflower, spreads them evenly over the dome; random numbers shift them a little.
fn lavender_spikes(rng: &mut Rng, spikes: usize) -> Vec<(DVec3, DVec3, DVec3)> {
    let spike = |i: usize| {
        let share = (i as f64 + 0.5) / spikes as f64;
        let lean = 1.2 * share.sqrt() + rng.between(-0.07, 0.07);
        let way = leaning(i as f64 * 0.618_034 + rng.between(-0.03, 0.03), lean);
        let reach = rng.between(0.56, 0.74) * (1.0 - 0.16 * share);
        (way * (0.42 * reach), way * reach + DVec3::Y * 0.05, way)
    };
    (0..spikes).map(spike).collect()
}

/// A bush of lavender, 0.75 m high and wide: a low green dome that bristles with flower spikes on stalks.
#[must_use]
pub fn lavender(spikes: usize, seed: u32) -> Cluster {
    let mut rng = Rng::new(seed);
    let mut out = Cluster::default();
    lavender_dome(&mut out, seed);
    for (root, tip, way) in lavender_spikes(&mut rng, spikes) {
        let from = root + (tip - root) * 0.22;
        let stalk = way.cross(DVec3::Y).normalize_or(DVec3::X) * 0.008;
        let low = DVec2::new(0.0, 0.1);
        out.polygon(&[(root - stalk, low), (root + stalk, low), (from, DVec2::new(0.0, 0.3))], way);
        let mut ear = Cluster::default();
        ear.spindle(from, tip, 0.030, 0.42, 3);
        out.stamp(&ear.with_uv(|_, uv| DVec2::new(0.0, 0.52 + 0.44 * uv.y)), &DAffine3::IDENTITY, DVec2::ZERO);
    }
    out
}

/// The same bush for a distance: spikes are plain cones.
#[must_use]
pub fn lavender_far(spikes: usize, seed: u32) -> Cluster {
    let mut rng = Rng::new(seed);
    let mut out = Cluster::default();
    lavender_dome(&mut out, seed);
    let radius = 0.20 / (spikes as f64).sqrt();
    for (root, tip, _) in lavender_spikes(&mut rng, spikes) {
        let mut ear = Cluster::default();
        ear.spindle(root + (tip - root) * 0.1, tip, radius, 0.0, 3);
        out.stamp(&ear.with_uv(|_, uv| DVec2::new(0.0, 0.36 + 0.58 * uv.y)), &DAffine3::IDENTITY, DVec2::ZERO);
    }
    out
}

/// Radius of a cypress of height 1 at height `t`.
fn flame(t: f64) -> f64 {
    0.115 * libm::pow((t * 1.02 + 0.02).min(1.0), 0.45) * libm::pow((1.0 - t).max(0.0), 0.62) * 1.75
}

/// A cypress of height 1: a dark body under upright sprays.
#[must_use]
pub fn cypress(sprays: usize, seed: u32) -> Cluster {
    let mut rng = Rng::new(seed);
    let mut out = Cluster::default();
    let body = lathe_with(13, 10, |row, angle, _| {
        let t = 0.03 + 0.95 * row as f64 / 12.0;
        let lump = 1.0 + 0.16 * (paint::noise(angle * 1.6, t * 9.0, seed) - 0.5);
        DVec2::new(if row == 0 || row == 12 { 0.0 } else { 0.86 * flame(t) * lump }, t)
    });
    out.stamp(&Cluster::of(&body.crease(85.0)).with_uv(|_, _| DVec2::new(0.0, 0.12)), &DAffine3::IDENTITY, DVec2::ZERO);
    for i in 0..sprays {
        let share = (i as f64 + 0.5) / sprays as f64;
        // More of them where the flame is wide.
        let t = 0.03 + 0.93 * (0.8 * share + 0.2 * share * share);
        let turn = i as f64 * 0.618_034 + rng.between(-0.02, 0.02);
        let side = leaning(turn, std::f64::consts::FRAC_PI_2);
        let radius = flame(t) * rng.between(0.80, 1.0);
        let base = side * (radius * 0.86) + DVec3::Y * t;
        let length = rng.between(0.055, 0.085) * (1.0 - 0.35 * t);
        let tip = side * (radius + rng.between(0.004, 0.018)) * (1.0 - 0.25 * t) + DVec3::Y * (t + length);
        let mut spray = Cluster::default();
        spray.spindle(base - DVec3::Y * 0.012, tip, length * 0.22, 0.4, 3);
        let tone = rng.between(0.0, 0.35);
        out.stamp(&spray.with_uv(|_, uv| DVec2::new(0.0, 0.2 + 0.45 * uv.y + tone)), &DAffine3::IDENTITY, DVec2::ZERO);
    }
    out
}

/// A leaf from `base` along `way`: a slim diamond, lit by `normal`.
pub fn leaf(out: &mut Cluster, base: DVec3, way: DVec3, across: DVec3, normal: DVec3, tone: f64) {
    let (middle, uv) = (base + way * 0.5, DVec2::new(0.0, tone));
    out.polygon(&[(base, uv), (middle + across, uv), (base + way, uv), (middle - across, uv)], normal);
}

/// Leaves on and in a ball of a crown.
fn crown(out: &mut Cluster, rng: &mut Rng, centre: DVec3, radius: DVec3, leaves: usize, size: DVec2) {
    for _ in 0..leaves {
        let away = rng.direction();
        let depth = 1.0 - 0.45 * rng.unit() * rng.unit();
        let base = centre + away * radius * depth;
        let face = (away + rng.direction() * 0.9).normalize_or(away);
        let way = face.cross(rng.direction()).normalize_or(DVec3::Y);
        let way = (way + away * 0.5 + DVec3::Y * 0.1).normalize_or(away);
        let across = face.cross(way).normalize_or(DVec3::X) * (size.x * rng.between(0.8, 1.2));
        // Lower and inner leaves are darker: the sky does not reach them.
        let tone = (0.52 + 0.30 * away.y - 0.7 * (1.0 - depth) + rng.between(-0.2, 0.2)).clamp(0.06, 0.94);
        leaf(out, base, way * (size.y * rng.between(0.75, 1.25)), across, away, tone);
    }
}

/// Trunk and leaves of an olive tree, 4.5 m high.
#[must_use]
pub fn olive(leaves: usize, seed: u32) -> (Cluster, Cluster) {
    let mut rng = Rng::new(seed);
    let (mut wood, mut out) = (Cluster::default(), Cluster::default());
    let fork = DVec3::new(rng.between(-0.15, 0.15), 1.25, rng.between(-0.15, 0.15));
    limb(&mut wood, DVec3::new(0.0, -0.2, 0.0), fork, 0.34, 0.21, seed);
    let arms = 5;
    for i in 0..arms {
        let way = leaning((f64::from(i) + rng.between(-0.2, 0.2)) / f64::from(arms), rng.between(0.55, 0.85));
        let elbow = fork + way * rng.between(0.9, 1.2);
        let end = elbow + (way + DVec3::Y * 0.9).normalize_or(way) * rng.between(0.7, 1.1);
        limb(&mut wood, fork - way * 0.1, elbow, 0.15, 0.10, seed + 1);
        limb(&mut wood, elbow - way * 0.04, end, 0.10, 0.03, seed + 2);
        for ball in [end, elbow + DVec3::Y * 0.45] {
            let radius = DVec3::new(0.92, 0.68, 0.92) * rng.between(0.85, 1.12);
            crown(&mut out, &mut rng, ball, radius, leaves / 11, DVec2::new(0.040, 0.26));
        }
    }
    let top = fork + DVec3::Y * 2.1;
    crown(&mut out, &mut rng, top, DVec3::new(1.0, 0.75, 1.0), leaves / 11, DVec2::new(0.040, 0.26));
    (wood, out)
}

/// A knotty branch from `a` to `b`.
pub fn limb(out: &mut Cluster, a: DVec3, b: DVec3, from: f64, to: f64, seed: u32) {
    let axis = (b - a).normalize_or(DVec3::Y);
    let side = axis.cross(if axis.x.abs() < 0.8 { DVec3::X } else { DVec3::Z }).normalize_or(DVec3::Z);
    let across = axis.cross(side);
    const ROWS: usize = 4;
    let part = Part::grid(ROWS, 6, true, |row, column| {
        let t = row as f64 / (ROWS - 1) as f64;
        // Counter-clockwise about the axis: the bark is the front.
        let (s, c) = sin_cos(std::f64::consts::TAU * column as f64 / 6.0);
        let knot = 1.0 + 0.5 * (paint::noise(column as f64 * 1.3, t * 3.0, seed) - 0.5);
        a + (b - a) * t + (side * c + across * s) * ((from + (to - from) * t) * knot)
    });
    out.stamp(
        &Cluster::of(&part.crease(70.0)).with_uv(|p, _| DVec2::new(p.x * 0.9 + p.z * 0.7, p.y * 0.8)),
        &DAffine3::IDENTITY,
        DVec2::ZERO,
    );
}

/// A round tree or bush of radius 1 on the ground: dark lumps under leaves, without trunk.
#[must_use]
pub fn bush(leaves: usize, size: f64, seed: u32) -> Cluster {
    let mut rng = Rng::new(seed);
    let mut out = Cluster::default();
    for i in 0..5 {
        let way = leaning(f64::from(i) * 0.618_034, 0.2 + 0.24 * f64::from(i));
        let (centre, radius) = (way * 0.48 + DVec3::Y * 0.34, rng.between(0.42, 0.54));
        let lump = lathe_with(4, 6, |row, _, _| {
            let (s, c) = sin_cos(std::f64::consts::PI * (row as f64 / 3.0 - 0.5));
            DVec2::new(if row == 0 || row == 3 { 0.0 } else { 0.78 * radius * c }, 0.78 * radius * s)
        });
        let lump = Cluster::of(&lump.crease(85.0)).with_uv(|p, _| DVec2::new(0.0, 0.2 + 0.2 * p.y));
        out.stamp(&lump, &DAffine3::from_translation(centre), DVec2::ZERO);
        for _ in 0..leaves / 5 {
            let away = rng.direction();
            let base = centre + away * (radius * rng.between(0.72, 0.98));
            let way = (away + rng.direction() * 1.1).normalize_or(away) * (size * rng.between(0.7, 1.3));
            let across = way.cross(away + rng.direction()).normalize_or(DVec3::X) * (0.42 * size);
            let uv = DVec2::new(0.0, (0.5 + 0.3 * away.y + rng.between(-0.2, 0.2)).clamp(0.06, 0.94));
            out.polygon(&[(base - across, uv), (base + across, uv), (base + way, uv)], away);
        }
    }
    out
}

/// A tuft of grass, 0.35 m high.
#[must_use]
pub fn grass(blades: usize, seed: u32) -> Cluster {
    let mut rng = Rng::new(seed);
    let mut out = Cluster::default();
    for i in 0..blades {
        let way = leaning(i as f64 * 0.618_034 + rng.between(-0.1, 0.1), rng.between(0.1, 0.9));
        let base = DVec3::new(rng.between(-0.13, 0.13), -0.03, rng.between(-0.13, 0.13));
        let side = leaning(rng.unit(), std::f64::consts::FRAC_PI_2) * 0.016;
        let tip = base + way * rng.between(0.18, 0.36);
        let uv = |v: f64| DVec2::new(0.0, v);
        // Grass is lit like the ground it covers, not blade by blade.
        out.polygon(&[(base - side, uv(0.15)), (base + side, uv(0.15)), (tip, uv(0.9))], DVec3::Y);
    }
    out
}

/// The cup of a poppy on its stalk, 0.45 m high: stalk first, then petals.
#[must_use]
pub fn poppy(seed: u32) -> (Cluster, Cluster) {
    let mut rng = Rng::new(seed);
    let (mut stalk, mut cup) = (Cluster::default(), Cluster::default());
    let head = DVec3::new(rng.between(-0.06, 0.06), rng.between(0.34, 0.46), rng.between(-0.06, 0.06));
    stalk.spindle(DVec3::ZERO, head, 0.008, 0.3, 3);
    for k in 0..5 {
        let (a, b) = (f64::from(k) / 5.0, f64::from(k + 1) / 5.0);
        let rim = |turn: f64| head + leaning(turn, 0.95) * 0.065;
        let points = [(head, DVec2::ZERO), (rim(a), DVec2::ZERO), (rim(b), DVec2::ZERO)];
        cup.polygon(&points, leaning((a + b) / 2.0, 0.7));
    }
    (stalk, cup)
}
