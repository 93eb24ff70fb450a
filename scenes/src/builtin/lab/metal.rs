//! Metal things: handles, the tap, stands, clamps, tripod and burner.

use glam::{DVec2, DVec3};

use crate::{
    builtin::lab::stock::Stock,
    modelling::{
        Part, SceneBuilder, block,
        lathe::{lathe, sphere},
        part::sin_cos,
        profile::{c, s, sample},
        tube,
    },
};

/// A bow handle on a front that faces +z.
pub fn handle(at: DVec3) -> Part {
    let path = [(-0.62, 0.0), (-0.62, 0.24), (0.62, 0.24), (0.62, 0.0)].map(|(x, z)| at + DVec3::new(x, 0.0, z));
    tube::rod(&tube::rounded(&path, 0.14, 2), 0.055, 8)
}

/// A ring of round wire about the y axis.
pub fn ring(radius: f64, wire: f64, segments: usize) -> Part {
    const SIDES: u32 = 8;
    let circle: Vec<DVec2> = (0..=SIDES)
        .map(|i| {
            let (sin, cos) = sin_cos(std::f64::consts::TAU * f64::from(i % SIDES) / f64::from(SIDES));
            DVec2::new(radius + cos * wire, sin * wire)
        })
        .collect();
    lathe(&circle, segments)
}

/// A swan-necked tap with two valves, standing at `at`, pouring towards +z.
pub fn chrome_tap(out: &mut SceneBuilder, stock: &Stock, at: DVec3) {
    let place = |part: Part| part.at(at.x, at.y, at.z);
    let knots = [c(0.0, 0.0), c(0.42, 0.0), s(0.44, 0.06), s(0.3, 0.14), s(0.22, 0.3), s(0.2, 0.6), c(0.0, 0.66)];
    out.object("tap", &place(lathe(&sample(&knots, 0.1), 32)), stock.chrome);
    let neck = [(0.5, 0.0), (3.4, 0.0), (3.4, 2.1), (1.9, 2.1)].map(|(y, z)| DVec3::new(0.0, y, z));
    out.extend(&place(tube::rod(&tube::rounded(&neck, 0.95, 9), 0.12, 18)), stock.chrome);
    let nozzle = [c(0.0, 1.6), c(0.15, 1.6), s(0.17, 1.7), s(0.17, 1.95), c(0.13, 2.02), c(0.0, 2.02)];
    out.extend(&place(lathe(&sample(&nozzle, 0.1), 20).at(0.0, 0.0, 2.1)), stock.chrome);
    for side in [-1.0, 1.0] {
        let pipe = [DVec3::new(0.0, 0.35, 0.0), DVec3::new(side * 0.9, 0.35, 0.0)];
        out.extend(&place(tube::rod(&pipe, 0.1, 14)), stock.chrome);
        let knob = sphere(DVec3::new(side * 0.9, 0.38, 0.0), 0.19, 16);
        out.extend(&place(knob), stock.chrome);
        for turn in [20.0, 110.0] {
            let lever = [DVec3::new(-0.4, 0.0, 0.0), DVec3::new(0.4, 0.0, 0.0)];
            let lever = tube::rod(&lever, 0.06, 10).turned(turn).at(side * 0.9, 0.62, 0.0);
            out.extend(&place(lever), stock.chrome);
        }
        let stem = [DVec3::new(side * 0.9, 0.4, 0.0), DVec3::new(side * 0.9, 0.62, 0.0)];
        out.extend(&place(tube::rod(&stem, 0.07, 10)), stock.chrome);
    }
}

/// A heavy foot with a rod of the given height; the rod stands at `at`, the foot reaches towards +z.
pub fn stand(out: &mut SceneBuilder, stock: &Stock, name: &str, at: DVec3, height: f64) {
    let foot = block::bevelled(DVec3::new(-0.75, 0.004, -0.35), DVec3::new(0.75, 0.16, 1.75), 0.04);
    out.object(name, &foot.at(at.x, at.y, at.z), stock.iron);
    let rod = [at + DVec3::Y * 0.15, at + DVec3::Y * height];
    out.extend(&tube::rod(&rod, 0.065, 16), stock.steel);
}

/// A clamp from the rod of a stand at `from` to a ring about `to`, whose opening has `radius` and runs along `axis`.
pub fn clamp(out: &mut SceneBuilder, stock: &Stock, name: &str, from: DVec3, to: DVec3, axis: DVec3, radius: f64) {
    let boss = block::bevelled(DVec3::new(-0.15, -0.17, -0.15), DVec3::new(0.15, 0.17, 0.15), 0.04);
    out.object(name, &boss.at(from.x, from.y, from.z), stock.iron);
    let way = (to - from).normalize_or_zero();
    let arm = [from - way * 0.4, to - way * (radius + 0.05)];
    out.extend(&tube::rod(&arm, 0.05, 12), stock.steel);
    let jaw = ring(radius + 0.06, 0.05, 24);
    out.extend(&crate::modelling::vessel::along(jaw, to, to + axis), stock.iron);
    let screw = sphere(from + DVec3::new(0.26, 0.0, 0.0), 0.1, 12);
    out.extend(&screw, stock.brass);
}

/// A ring on three legs with a wire gauze on top, `height` above the bench.
pub fn tripod(out: &mut SceneBuilder, stock: &Stock, at: DVec3, height: f64, radius: f64) {
    let place = |part: Part| part.at(at.x, at.y, at.z);
    out.object("tripod", &place(ring(radius, 0.06, 40).at(0.0, height - 0.09, 0.0)), stock.iron);
    for i in 0..3 {
        let (sin, cos) = sin_cos(0.5 + 2.0944 * f64::from(i));
        let leg = [
            DVec3::new(sin * radius, height - 0.1, cos * radius),
            DVec3::new(sin * (radius + 0.3), 0.004, cos * (radius + 0.3)),
        ];
        out.extend(&place(tube::rod(&leg, 0.055, 10)), stock.iron);
    }
    let gauze = [c(0.0, height - 0.025), c(radius + 0.12, height - 0.025), c(radius + 0.12, height), c(0.0, height)];
    let gauze = lathe(&sample(&gauze, 0.5), 40).planar_uv(DVec2::ZERO, 0.5);
    out.object("gauze", &place(gauze), stock.gauze);
}

/// A Bunsen burner and its hose, which runs along the bench to `end`, beyond its edge, and hangs down there.
pub fn burner(out: &mut SceneBuilder, stock: &Stock, at: DVec3, end: DVec3) {
    let place = |part: Part| part.at(at.x, at.y, at.z);
    let base =
        [c(0.0, 0.004), c(0.46, 0.004), s(0.48, 0.05), s(0.40, 0.12), s(0.16, 0.18), s(0.12, 0.24), c(0.0, 0.26)];
    out.object("burner", &place(lathe(&sample(&base, 0.07), 32)), stock.iron);
    let barrel = [
        c(0.0, 0.2),
        c(0.17, 0.22),
        c(0.17, 0.42),
        c(0.105, 0.44),
        s(0.10, 0.6),
        s(0.10, 1.0),
        c(0.115, 1.05),
        c(0.115, 1.12),
        c(0.08, 1.12),
        c(0.08, 0.9),
        c(0.0, 0.9),
    ];
    out.extend(&place(lathe(&sample(&barrel, 0.12), 28)), stock.brass);
    let hose = [
        at + DVec3::new(-0.1, 0.3, 0.0),
        at + DVec3::new(-0.75, 0.3, -0.1),
        at + DVec3::new(-1.0, 0.09, -0.5),
        DVec3::new(end.x, 0.09, end.z + 1.6),
        end,
        end - DVec3::Y * 1.6,
    ];
    out.object("gas hose", &tube::rod(&tube::rounded(&hose, 0.5, 6), 0.08, 14), stock.rubber);
}
