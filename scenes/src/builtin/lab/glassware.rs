//! The vessels of the laboratory. One unit is ten centimetres.

use glam::{DVec2, DVec3};

use crate::modelling::{
    Part,
    lathe::lathe,
    profile::{Knot, c, s, sample},
    tube,
    vessel::Vessel,
};

/// Sides of a large vessel.
const SIDES: usize = 42;

/// A conical flask; the height is 1.62 times `size`, the foot's radius 0.62 times.
pub fn erlenmeyer(size: f64) -> Vessel {
    let k = |sharp: bool, r: f64, y: f64| Knot { point: DVec2::new(r, y) * size, sharp };
    let knots = [
        k(false, 0.0, 0.03),
        k(false, 0.40, 0.02),
        k(false, 0.50, 0.0),
        k(false, 0.585, 0.03),
        k(false, 0.62, 0.11),
        k(true, 0.59, 0.21),
        k(true, 0.255, 1.10),
        k(false, 0.205, 1.26),
        k(false, 0.20, 1.50),
        k(false, 0.222, 1.575),
        k(false, 0.262, 1.60),
    ];
    Vessel::new(&knots, 0.12 * size, 0.028, SIDES)
}

/// A beaker with a lip.
pub fn beaker(radius: f64, height: f64) -> Vessel {
    let knots = [
        s(0.0, 0.02),
        s(radius * 0.7, 0.012),
        s(radius * 0.86, 0.0),
        s(radius * 0.97, 0.04),
        c(radius, 0.13),
        c(radius, height - 0.16),
        s(radius * 1.015, height - 0.06),
        s(radius * 1.07, height),
    ];
    Vessel::new(&knots, 0.13, 0.030, SIDES).spout(0.26, 0.15 * radius + 0.05)
}

/// A flask with a round body of `radius` and a neck up to `height`.
pub fn round_flask(radius: f64, neck: f64, height: f64) -> Vessel {
    let mut knots: Vec<Knot> = (0..=9)
        .map(|i| {
            let angle = f64::from(i) * 0.30;
            let r = if i == 0 { 0.0 } else { libm::sin(angle) * radius };
            s(r, (1.0 - libm::cos(angle)) * radius)
        })
        .filter(|knot| knot.point.y < radius || knot.point.x > neck * 1.5)
        .collect();
    let shoulder = radius * 2.0;
    knots.extend([
        s(neck * 1.06, shoulder + 0.08),
        c(neck, shoulder + 0.28),
        c(neck, height - 0.10),
        s(neck * 1.12, height - 0.03),
        s(neck * 1.28, height),
    ]);
    Vessel::new(&knots, 0.16 * radius, 0.030, SIDES)
}

/// A measuring cylinder without its foot, which is [`cylinder_foot`].
pub fn cylinder(radius: f64, height: f64) -> Vessel {
    let knots = [
        s(0.0, 0.16),
        s(radius * 0.8, 0.16),
        c(radius, 0.22),
        c(radius, height - 0.20),
        s(radius * 1.02, height - 0.10),
        s(radius * 1.14, height),
    ];
    Vessel::new(&knots, 0.14, 0.028, 32).spout(0.2, 0.11)
}

/// A six-sided plate with a socket.
pub fn cylinder_foot(radius: f64) -> Part {
    let profile =
        sample(&[c(0.0, 0.0), c(radius * 2.1, 0.0), c(radius * 2.1, 0.07), c(radius * 1.05, 0.13), c(0.0, 0.13)], 0.5);
    lathe(&profile, 6)
}

/// A test tube.
pub fn test_tube(radius: f64, height: f64) -> Vessel {
    let knots = [
        s(0.0, 0.0),
        s(radius * 0.52, radius * 0.15),
        s(radius * 0.88, radius * 0.52),
        c(radius, radius),
        c(radius, height - 0.12),
        s(radius * 1.04, height - 0.05),
        s(radius * 1.22, height),
    ];
    Vessel::new(&knots, 0.16, 0.022, 22)
}

/// A reagent bottle; its stopper is [`stopper`].
pub fn bottle(radius: f64, height: f64) -> Vessel {
    let neck = radius * 0.36;
    let shoulder = height - radius * 0.95;
    let knots = [
        s(0.0, 0.03),
        s(radius * 0.75, 0.02),
        s(radius * 0.9, 0.0),
        c(radius, 0.10),
        c(radius, shoulder),
        s(radius * 0.82, shoulder + radius * 0.38),
        s(neck * 1.08, shoulder + radius * 0.58),
        c(neck, shoulder + radius * 0.74),
        c(neck, height - 0.05),
        s(neck * 1.35, height),
    ];
    Vessel::new(&knots, 0.16 * height, 0.034, 22)
}

/// A ground stopper with a flat grip that hangs in the neck of a bottle of `radius`; it touches no glass.
pub fn stopper(radius: f64) -> Part {
    let neck = radius * 0.36;
    let knots = [
        c(0.0, -neck * 1.3),
        c(neck * 0.62, -neck * 1.3),
        c(neck * 0.80, 0.05),
        c(neck * 1.25, 0.07),
        s(neck * 1.45, 0.07 + neck * 0.35),
        s(neck * 0.7, 0.07 + neck * 0.75),
        s(neck * 0.95, 0.07 + neck * 1.5),
        s(neck * 0.6, 0.07 + neck * 1.95),
        c(0.0, 0.07 + neck * 2.05),
    ];
    lathe(&sample(&knots, neck * 0.9), 14).crease(50.0)
}

/// A flat dish with vertical sides.
pub fn dish(radius: f64) -> Vessel {
    let knots = [s(0.0, 0.0), c(radius * 0.96, 0.0), s(radius, 0.04), s(radius, 0.2), s(radius, 0.26)];
    Vessel::new(&knots, 0.2, 0.028, 40)
}

/// The jacket of a straight condenser of the given length along y: a bore for the vapour inside, water round it.
pub fn condenser(length: f64) -> Part {
    let (bore, tube, jacket) = (0.085, 0.13, 0.31);
    let end = |y: f64, inwards: f64| {
        [
            c(tube, y + 0.55 * inwards),
            s(tube * 1.5, y + 0.60 * inwards),
            s(jacket * 0.92, y + 0.72 * inwards),
            c(jacket, y + 0.90 * inwards),
        ]
    };
    let mut knots = vec![c(bore, 0.0), c(tube, 0.0)];
    knots.extend(end(0.0, 1.0));
    knots.extend(end(length, -1.0).into_iter().rev());
    knots.extend([c(tube, length), c(bore, length), c(bore, 0.0)]);
    lathe(&sample(&knots, 0.16), 32).crease(50.0)
}

/// A retort: a round bulb whose top bends over into a long neck towards +x. Closed solid without opening for the eye:
/// its mouth is a narrow ring. `level` splits it into dry glass and wet liquid.
pub fn retort(level: f64) -> (Part, [Part; 2]) {
    let (path, radii) = retort_axis();
    let sides = 40;
    let wet = path.iter().position(|p| p.y > level).unwrap_or(1);
    let wall = |radius: f64| (radius - 0.03).max(radius * 0.4);
    let outside = |range: std::ops::Range<usize>| range.map(|i| (i, radii[i])).collect::<Vec<_>>();
    let last = path.len() - 1;
    let mut glass = outside(wet..path.len());
    glass.extend((wet..=last).rev().map(|i| (i, wall(radii[i]))));
    let inner = wall(radii[wet]);
    let surface = [(wet, inner), (wet, inner * 0.9), (wet, 0.0)];
    let part = |rows: &[(usize, f64)]| tube::sweep(&path, rows, sides).crease(55.0);
    (part(&glass), [part(&outside(0..wet + 1)), part(&surface)])
}

/// The axis of the retort and its radius at each station.
fn retort_axis() -> (Vec<DVec3>, Vec<f64>) {
    const BULB: f64 = 1.0;
    let (mut path, mut radii) = (Vec::new(), Vec::new());
    // The lower half of the bulb, a little past its middle, upright.
    for i in 0..=14 {
        let angle = f64::from(i) * 0.125;
        path.push(DVec3::new(0.0, BULB * (1.0 - libm::cos(angle)), 0.0));
        radii.push(if i == 0 { 0.0 } else { BULB * libm::sin(angle) });
    }
    // The bend: round a centre to the right, narrowing all the way.
    let start = path[path.len() - 1];
    let bend = 1.12;
    let steps = 20;
    for i in 1..=steps {
        let t = f64::from(i) / f64::from(steps);
        let angle = t * 2.0;
        let at = DVec3::new(bend * (1.0 - libm::cos(angle)), bend * libm::sin(angle), 0.0);
        path.push(start + at);
        let ease = t * t * (3.0 - 2.0 * t);
        radii.push(radii[14] + (0.33 - radii[14]) * (0.25 * t + 0.75 * ease));
    }
    let (from, to) = (path[path.len() - 2], path[path.len() - 1]);
    let way = (to - from).normalize_or_zero();
    for i in 1..=6 {
        let t = f64::from(i) / 6.0;
        path.push(to + way * (t * 3.4));
        radii.push(0.33 - 0.19 * t);
    }
    (path, radii)
}
