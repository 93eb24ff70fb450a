//! What closes an opening: sashes, panes, curtains, shutters, doors.

use glam::DVec3;

use crate::{
    builtin::provence::{
        materials::Materials,
        plan::{Opening, REVEAL},
    },
    modelling::{
        Part, SceneBuilder,
        block::{bevelled, block, rectangle},
    },
};

/// Sine and cosine of the 45 degrees at which slats hang, so that they shed rain.
const SLANT: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Sash bars, panes, curtains and shutters of a window.
pub fn glaze(out: &mut SceneBuilder, m: &Materials, name: &str, o: &Opening, put: &impl Fn(Part) -> Part) {
    let (l, r, b, t) = (o.x - o.width / 2.0, o.x + o.width / 2.0, o.y, o.y + o.height);
    let z = -REVEAL + 0.08;
    let bar = |x0: f64, y0: f64, x1: f64, y1: f64| block(DVec3::new(x0, y0, z - 0.05), DVec3::new(x1, y1, z + 0.05));
    let third = |k: f64| b + 0.06 + (o.height - 0.12) * k / 3.0;
    let mut sash = bar(l, b, l + 0.06, t)
        .with(bar(r - 0.06, b, r, t))
        .with(bar(l + 0.06, b, r - 0.06, b + 0.06))
        .with(bar(l + 0.06, t - 0.06, r - 0.06, t))
        .with(bar(o.x - 0.045, b + 0.06, o.x + 0.045, t - 0.06));
    let mut panes = Vec::new();
    for (x0, x1) in [(l + 0.06, o.x - 0.045), (o.x + 0.045, r - 0.06)] {
        for k in [1.0, 2.0] {
            sash = sash.with(bar(x0, third(k) - 0.015, x1, third(k) + 0.015));
        }
        for k in 0..3 {
            let k = f64::from(k);
            let (low, high) =
                (third(k) + if k > 0.5 { 0.015 } else { 0.0 }, third(k + 1.0) - if k < 1.5 { 0.015 } else { 0.0 });
            panes.push(block(DVec3::new(x0, low, z - 0.006), DVec3::new(x1, high, z + 0.006)));
        }
    }
    out.object(&format!("{name} sash"), &put(sash), m.sash);
    let panes = panes.into_iter().fold(Part::default(), Part::with);
    out.object(&format!("{name} panes"), &put(panes), m.pane);
    let room = rectangle(DVec3::new(l, b, -REVEAL - 0.29), DVec3::X * o.width, DVec3::Y * o.height);
    out.object(&format!("{name} room"), &put(room), m.room);
    for (from, to) in [(l, l + 0.36 * o.width), (r, r - 0.36 * o.width)] {
        out.object(&format!("{name} curtain"), &put(curtain(from, to, b + 0.02, t - 0.02)), m.curtain);
    }
    let mut shutters = Part::default();
    for (hinge, way) in [(l - 0.13, -1.0), (r + 0.13, 1.0)] {
        shutters = shutters.with(shutter(hinge, way, b + 0.02, t - 0.02, o.width / 2.0));
    }
    out.object(&format!("{name} shutters"), &put(shutters), m.shutter);
}

/// A curtain in soft folds, wider at the top.
fn curtain(from: f64, to: f64, low: f64, high: f64) -> Part {
    let swap = from > to;
    let part = Part::grid(5, 17, false, |row, column| {
        let (s, t) = (column as f64 / 16.0, row as f64 / 4.0);
        let gather = 0.62 + 0.38 * t * t;
        let x = from + (to - from) * s * gather;
        DVec3::new(x, low + (high - low) * t, -REVEAL - 0.12 + 0.035 * libm::sin(s * 25.0) * (0.4 + 0.6 * s))
    });
    (if swap { part.flipped() } else { part }).crease(80.0)
}

/// A louvred shutter folded back against the wall.
fn shutter(hinge: f64, way: f64, low: f64, high: f64, width: f64) -> Part {
    let at = |s: f64| hinge + way * (0.03 + s * width);
    let bar = |s0: f64, y0: f64, s1: f64, y1: f64, z0: f64, z1: f64| {
        let (x0, x1) = (at(s0).min(at(s1)), at(s0).max(at(s1)));
        block(DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1))
    };
    let mut part = bar(0.0, low, 0.13, high, 0.05, 0.10)
        .with(bar(0.87, low, 1.0, high, 0.05, 0.10))
        .with(bar(0.13, low, 0.87, low + 0.09, 0.05, 0.10))
        .with(bar(0.13, high - 0.09, 0.87, high, 0.05, 0.10));
    let slats = ((high - low - 0.18) / 0.085) as usize;
    let pitch = (high - low - 0.18) / slats as f64;
    for i in 0..slats {
        let y = low + 0.09 + pitch * (i as f64 + 0.5);
        let slat =
            block(DVec3::new(at(0.13).min(at(0.87)), -0.008, -0.03), DVec3::new(at(0.13).max(at(0.87)), 0.008, 0.03));
        part = part.with(slat.map(|p| DVec3::new(p.x, y + (p.y - p.z) * SLANT, 0.072 + (p.y + p.z) * 0.8 * SLANT)));
    }
    part
}

/// A door of upright planks with a ledge across.
pub fn planks(o: &Opening) -> Part {
    let count = libm::ceil(o.width / 0.17) as usize;
    let step = o.width / count as f64;
    let left = o.x - o.width / 2.0;
    let mut part = Part::default();
    for i in 0..count {
        let x = left + i as f64 * step;
        let board = bevelled(
            DVec3::new(x + 0.004, o.y + 0.06, -REVEAL - 0.05),
            DVec3::new(x + step - 0.004, o.y + o.height, -REVEAL + 0.03),
            0.012,
        );
        part = part.with(board);
    }
    for y in [0.35, o.height - 0.45] {
        part = part.with(block(
            DVec3::new(left + 0.05, o.y + y, -REVEAL + 0.03),
            DVec3::new(left + o.width - 0.05, o.y + y + 0.12, -REVEAL + 0.06),
        ));
    }
    // What shows between the boards is wood, too.
    part.with(block(DVec3::new(left, o.y, -REVEAL - 0.08), DVec3::new(left + o.width, o.y + o.height, -REVEAL - 0.05)))
}
