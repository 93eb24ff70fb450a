//! What lies about: microscope, mortar, notebook, and the bottles on shelf and wall bench.

use glam::DVec3;

use crate::{
    builtin::lab::{
        apparatus::GAP,
        furniture::SHELF,
        glassware as ware,
        room::BACK,
        stock::{BLUE, CLEAR, GREEN, ORANGE, PINK, RED, Stock, VIOLET, YELLOW},
    },
    modelling::{
        Part, SceneBuilder, block,
        lathe::lathe,
        profile::{Knot, c, s, sample},
        tube,
        vessel::along,
    },
};

/// A brass and black microscope that looks along +x before it is turned.
pub fn microscope(out: &mut SceneBuilder, stock: &Stock, at: DVec3, turn: f64) {
    let place = |p: Part| p.turned(turn).at(at.x, at.y, at.z);
    let foot = block::bevelled(DVec3::new(-0.7, 0.004, -0.55), DVec3::new(0.85, 0.22, 0.55), 0.06);
    out.object("microscope", &place(foot), stock.iron);
    let arm = [(-0.45, 0.2), (-0.62, 1.4), (-0.55, 2.3), (0.1, 2.75)].map(|(x, y)| DVec3::new(x, y, 0.0));
    out.extend(&place(tube::rod(&tube::rounded(&arm, 0.5, 8), 0.16, 20)), stock.iron);
    let stage = block::bevelled(DVec3::new(-0.6, 1.12, -0.5), DVec3::new(0.75, 1.22, 0.5), 0.03);
    out.object("stage", &place(stage), stock.iron);
    let slide = block::block(DVec3::new(-0.1, 1.228, -0.38), DVec3::new(0.2, 1.25, 0.38));
    out.object("slide", &place(slide), stock.glass);
    // The tube leans back by a sixth of a right angle; everything on it is turned on a lathe.
    let (low, high) = (DVec3::new(0.12, 1.42, 0.0), DVec3::new(-0.52, 4.0, 0.0));
    let barrel = [
        c(0.0, 0.0),
        c(0.06, 0.0),
        c(0.10, 0.16),
        c(0.13, 0.18),
        c(0.13, 0.42),
        c(0.20, 0.46),
        c(0.20, 0.60),
        s(0.17, 0.64),
        s(0.17, 1.0),
        c(0.17, 1.9),
        c(0.14, 1.92),
        c(0.14, 2.3),
        c(0.19, 2.34),
        s(0.19, 2.5),
        c(0.15, 2.56),
        c(0.0, 2.54),
    ];
    out.object("eyepiece tube", &place(along(lathe(&sample(&barrel, 0.2), 32), low, high)), stock.brass);
    let knob = sample(
        &[
            c(0.0, -0.5),
            c(0.2, -0.5),
            c(0.22, -0.46),
            c(0.22, -0.34),
            c(0.08, -0.3),
            c(0.08, 0.3),
            c(0.22, 0.34),
            c(0.22, 0.46),
            c(0.2, 0.5),
            c(0.0, 0.5),
        ],
        1.0,
    );
    for (y, size) in [(1.75, 1.0), (1.42, 0.7)] {
        let knob = along(lathe(&knob, 24).scaled(size), DVec3::ZERO, DVec3::Z).at(-0.58, y, 0.0);
        out.object("focus knob", &place(knob), stock.brass);
    }
    let mirror = lathe(&sample(&[c(0.0, 0.0), c(0.26, 0.0), s(0.28, 0.03), c(0.26, 0.06), c(0.0, 0.04)], 0.1), 28);
    let mirror = along(mirror, DVec3::new(0.1, 0.55, 0.0), DVec3::new(0.5, 1.2, 0.0));
    out.object("lamp mirror", &place(mirror), stock.chrome);
    let yoke = [DVec3::new(0.1, 0.2, 0.0), DVec3::new(0.1, 0.54, 0.0)];
    out.extend(&place(tube::rod(&yoke, 0.05, 10)), stock.iron);
}

/// A porcelain mortar with its pestle.
pub fn mortar(out: &mut SceneBuilder, stock: &Stock, at: DVec3) {
    let bowl = [
        c(0.0, 0.004),
        c(0.42, 0.004),
        s(0.44, 0.08),
        s(0.40, 0.16),
        s(0.62, 0.45),
        s(0.72, 0.80),
        s(0.75, 0.86),
        s(0.69, 0.88),
        s(0.62, 0.78),
        s(0.45, 0.42),
        s(0.2, 0.26),
        s(0.0, 0.24),
    ];
    out.object("mortar", &lathe(&sample(&bowl, 0.13), 40).at(at.x, at.y, at.z), stock.porcelain);
    let pestle = [
        s(0.0, 0.0),
        s(0.14, 0.04),
        s(0.19, 0.16),
        s(0.13, 0.32),
        s(0.09, 0.6),
        s(0.10, 1.1),
        s(0.14, 1.3),
        s(0.08, 1.42),
        s(0.0, 1.44),
    ];
    let foot = at + DVec3::new(-0.16, 0.30, 0.02);
    let pestle = along(lathe(&sample(&pestle, 0.13), 20), foot, foot + DVec3::new(0.9, 1.0, -0.1));
    out.object("pestle", &pestle, stock.porcelain);
}

/// A notebook with a pencil across it.
pub fn notebook(out: &mut SceneBuilder, stock: &Stock, at: DVec3, turn: f64) {
    let place = |p: Part| p.turned(turn).at(at.x, at.y, at.z);
    let block_of = |inset: f64, y0: f64, y1: f64| {
        block::bevelled(DVec3::new(-1.05 + inset, y0, -0.75 + inset), DVec3::new(1.05, y1, 0.75 - inset), 0.012)
    };
    out.object("notebook", &place(block_of(0.0, 0.004, 0.045)), stock.cloth);
    out.extend(&place(block_of(0.05, 0.046, 0.17)), stock.paper);
    out.extend(&place(block_of(0.0, 0.172, 0.21)), stock.cloth);
    let (tip, end) = (DVec3::new(-0.75, 0.262, 0.35), DVec3::new(0.6, 0.262, -0.2));
    let pencil = |profile: &[Knot]| along(lathe(&sample(profile, 1.0), 6), tip, end).crease(20.0);
    out.object("pencil", &place(pencil(&[c(0.0, 0.0), c(0.018, 0.07), c(0.0, 0.07)])), stock.iron);
    out.extend(&place(pencil(&[c(0.018, 0.071), c(0.05, 0.21)])), stock.cork);
    out.extend(&place(pencil(&[c(0.05, 0.211), c(0.05, 1.46), c(0.0, 1.46)])), stock.paint);
}

/// Bottles on the shelf, larger ones and flasks on the wall bench.
pub fn bottles(out: &mut SceneBuilder, stock: &Stock) {
    const ROW: [(usize, f64, f64, f64); 14] = [
        (BLUE, 0.50, 1.5, 0.62),
        (CLEAR, 0.42, 1.3, 0.5),
        (RED, 0.55, 1.75, 0.55),
        (YELLOW, 0.46, 1.4, 0.7),
        (VIOLET, 0.50, 1.65, 0.5),
        (GREEN, 0.44, 1.35, 0.66),
        (ORANGE, 0.55, 1.8, 0.6),
        (PINK, 0.46, 1.5, 0.45),
        (BLUE, 0.52, 1.7, 0.4),
        (YELLOW, 0.42, 1.3, 0.6),
        (RED, 0.48, 1.5, 0.66),
        (CLEAR, 0.54, 1.75, 0.6),
        (GREEN, 0.46, 1.45, 0.5),
        (VIOLET, 0.50, 1.6, 0.65),
    ];
    let mut x = -2.0;
    for (i, (liquid, radius, height, fill)) in ROW.into_iter().enumerate() {
        x += radius + 0.12;
        let at = DVec3::new(x, SHELF, BACK + 0.95 + 0.12 * if i % 2 == 0 { 1.0 } else { -1.0 });
        bottle(out, stock, &format!("shelf bottle {}", i + 1), at, (radius, height), Some((liquid, fill)));
        x += radius + 0.16;
    }
    for (i, (at, radius, height, fill)) in [
        (DVec3::new(-1.4, 0.0, -11.6), 0.85, 2.9, Some((BLUE, 0.6))),
        (DVec3::new(0.9, 0.0, -12.2), 0.75, 2.5, None),
        (DVec3::new(3.0, 0.0, -11.4), 0.8, 2.7, Some((ORANGE, 0.5))),
        (DVec3::new(13.5, 0.0, -11.8), 0.85, 2.9, Some((GREEN, 0.55))),
        (DVec3::new(-14.5, 0.0, -11.6), 0.85, 2.8, Some((RED, 0.5))),
    ]
    .into_iter()
    .enumerate()
    {
        bottle(out, stock, &format!("bench bottle {}", i + 1), at, (radius, height), fill);
    }
}

/// A bottle with its stopper; without a fill it is of amber glass.
fn bottle(
    out: &mut SceneBuilder,
    stock: &Stock,
    name: &str,
    at: DVec3,
    (radius, height): (f64, f64),
    fill: Option<(usize, f64)>,
) {
    let glass = if fill.is_some() { stock.glass } else { stock.amber_glass };
    let fill = fill.map(|(liquid, share)| (height * share, stock.liquids[liquid]));
    let vessel = ware::bottle(radius, height);
    let top = at.y + GAP + vessel.height();
    vessel.build(out, name, glass, fill, |p| p.at(at.x, at.y + GAP, at.z));
    out.object(&format!("{name} stopper"), &ware::stopper(radius).at(at.x, top, at.z), glass);
}
