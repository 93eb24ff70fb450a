//! What is set up on the island: the distillation, the burette, the retort, the rack, the hot plate.

use glam::{DVec2, DVec3};

use crate::{
    builtin::lab::{
        glassware as ware,
        metal::{burner, clamp, ring, stand, tripod},
        stock::{BLUE, CLEAR, GREEN, ORANGE, PINK, RED, Stock, VIOLET, YELLOW},
    },
    modelling::{
        Part, SceneBuilder, block,
        lathe::lathe,
        part::sin_cos,
        profile::{c, s, sample},
        tube,
        vessel::{Vessel, along},
    },
};

/// Glass does not touch what it stands on: coincident faces would flicker.
pub const GAP: f64 = 0.006;

/// Flask over a burner, condenser, receiver.
pub fn distillation(out: &mut SceneBuilder, stock: &Stock, at: DVec3) {
    let here = |x: f64, y: f64, z: f64| at + DVec3::new(x, y, z);
    tripod(out, stock, at, 1.5, 0.85);
    burner(out, stock, at, here(-1.6, 0.09, -2.95));
    let flask = ware::round_flask(0.86, 0.24, 2.75);
    let base = here(0.0, 1.5 + GAP, 0.0);
    flask.build(out, "still", stock.glass, Some((0.80, stock.liquids[ORANGE])), |p| p.at(base.x, base.y, base.z));
    let neck = here(0.0, 1.5 + 2.75, 0.0);
    let cork = lathe(&sample(&[c(0.0, -0.28), c(0.19, -0.28), c(0.25, 0.16), c(0.0, 0.16)], 1.0), 28);
    out.object("still cork", &cork.at(neck.x, neck.y, neck.z), stock.cork);
    stand(out, stock, "still stand", here(-0.2, 0.0, -1.5), 5.4);
    let grip = here(-0.2, 3.75, -1.5);
    clamp(out, stock, "still clamp", grip, here(0.0, 3.75, 0.0), DVec3::Y, 0.27);
    // The tube bends over and runs down into the condenser.
    let (from, to) = (here(1.05, 4.42, 0.0), here(4.35, 3.1, 0.0));
    let way = (to - from).normalize_or_zero();
    let bend = [neck + DVec3::Y * 0.1, neck + DVec3::Y * 0.78, from - way * 0.02];
    let bend = tube::rounded(&bend, 0.42, 9);
    out.object("still head", &tube::pipe(&bend, 0.105, 0.07, 18), stock.glass);
    let sleeve = |middle: DVec3| tube::rod(&[middle - way * 0.17, middle + way * 0.17], 0.17, 24);
    out.object("sleeves", &sleeve(from), stock.rubber);
    let length = (to - from).length();
    out.object("condenser", &along(ware::condenser(length - 0.04), from + way * 0.02, to), stock.glass);
    out.object("sleeves 2", &sleeve(to + way * 0.02), stock.rubber);
    let drop = [to + way * 0.04, to + way * 0.62, to + way * 0.62 + DVec3::new(0.15, -1.4, 0.0)];
    out.object("adapter", &tube::pipe(&tube::rounded(&drop, 0.5, 9), 0.105, 0.07, 18), stock.glass);
    hoses(out, stock, from, way, length);
    let middle = from + way * (length * 0.55);
    stand(out, stock, "condenser stand", DVec3::new(middle.x, at.y, at.z - 1.5), 4.9);
    clamp(out, stock, "condenser clamp", middle - DVec3::Z * 1.5, middle, way, 0.33);
    let receiver = ware::erlenmeyer(1.12);
    let foot = drop[2];
    let place = |p: Part| p.at(foot.x, GAP, foot.z);
    receiver.build(out, "receiver", stock.glass, Some((0.42, stock.liquids[YELLOW])), place);
}

/// Cooling water in and out: hoses from the jacket over the back edge of the bench.
fn hoses(out: &mut SceneBuilder, stock: &Stock, from: DVec3, way: DVec3, length: f64) {
    for (name, share, side) in [("water in", 0.80, -1.0), ("water out", 0.22, 1.0)] {
        let middle = from + way * (length * share);
        let down = DVec3::new(0.0, side, 0.0) + way * 0.3;
        let start = middle + down * 0.30;
        let path = [
            start,
            start + down * 0.5,
            start + DVec3::new(0.5, side * 0.5, -0.9),
            DVec3::new(start.x + 0.7, 0.08, -2.2),
            DVec3::new(start.x + 1.3, 0.08, -3.62),
            DVec3::new(start.x + 1.3, -1.6, -3.62),
        ];
        out.object(name, &tube::rod(&tube::rounded(&path, 0.5, 5), 0.085, 12), stock.rubber);
    }
}

/// A burette over a flask; the rod of the stand is at `at`.
pub fn titration(out: &mut SceneBuilder, stock: &Stock, at: DVec3) {
    stand(out, stock, "burette stand", at, 5.6);
    let axis = at + DVec3::new(0.0, 0.0, 1.1);
    let knots = [
        s(0.0, 0.0),
        s(0.045, 0.03),
        s(0.055, 0.35),
        s(0.07, 0.50),
        s(0.135, 0.78),
        c(0.14, 0.95),
        c(0.14, 3.4),
        s(0.165, 3.5),
    ];
    let burette = Vessel::new(&knots, 0.18, 0.022, 24);
    let base = axis + DVec3::Y * 1.95;
    let place = |p: Part| p.at(base.x, base.y, base.z);
    burette.build(out, "burette", stock.glass, Some((2.75, stock.liquids[VIOLET])), place);
    marks(out, stock, "burette marks", &burette, base, (1.1, 3.2, 22));
    let cock = [DVec3::new(-0.26, 0.46, 0.0), DVec3::new(0.22, 0.46, 0.0)].map(|p| base + p);
    out.object("stopcock", &tube::rod(&cock, 0.085, 16), stock.porcelain);
    let grip = block::bevelled(DVec3::new(-0.34, 0.34, -0.03), DVec3::new(-0.25, 0.58, 0.03), 0.02);
    out.extend(&place(grip), stock.porcelain);
    for (name, y) in [("burette clamp 1", 2.1), ("burette clamp 2", 2.9)] {
        let middle = base + DVec3::Y * y;
        clamp(out, stock, name, DVec3::new(at.x, middle.y, at.z), middle, DVec3::Y, 0.15);
    }
    let flask = ware::erlenmeyer(1.12);
    let place = |p: Part| p.at(axis.x, GAP, axis.z);
    flask.build(out, "titration flask", stock.glass, Some((0.5, stock.liquids[PINK])), place);
}

/// Enamel lines on the front of an upright vessel at `base`: from a height to a height, every fifth one longer.
pub fn marks(out: &mut SceneBuilder, stock: &Stock, name: &str, vessel: &Vessel, base: DVec3, range: (f64, f64, u32)) {
    let (low, high, count) = range;
    out.object(name, &Part::default(), stock.enamel);
    for i in 0..=count {
        let y = low + (high - low) * f64::from(i) / f64::from(count);
        let reach = if i % 5 == 0 { 0.55 } else { 0.32 };
        // Just outside the glass: further out than the corners of the vessel's polygon stand beyond its sides.
        let strip = Part::grid(2, 9, false, |row, column| {
            let height = y + 0.014 * row as f64;
            let (sin, cos) = sin_cos(0.35 + reach * (column as f64 / 8.0 - 0.5) * 2.0);
            let r = vessel.radius(height) + 0.006;
            base + DVec3::new(sin * r, height, cos * r)
        });
        out.extend(&strip, stock.enamel);
    }
}

/// The retort in a ring on a stand.
pub fn retort(out: &mut SceneBuilder, stock: &Stock, at: DVec3, turn: f64) {
    let (glass, liquid) = ware::retort(0.85);
    let height = 2.3;
    let place = |p: Part| p.turned(turn).at(at.x, at.y + height, at.z);
    out.object("retort", &place(glass), stock.glass);
    let [wet, surface] = liquid;
    out.object("retort: liquid", &place(wet), stock.liquids[GREEN]);
    out.extend(&place(surface), stock.liquids[GREEN]);
    let (name, rod) = ("retort stand", at + DVec3::new(0.0, 0.0, -1.7));
    stand(out, stock, name, rod, 5.2);
    let seat = ring(0.86, 0.06, 48).at(at.x, at.y + height + 0.32, at.z);
    out.object("retort ring", &seat, stock.iron);
    let arm = [rod + DVec3::Y * (height + 0.32), at + DVec3::new(0.0, height + 0.32, -0.9)];
    out.extend(&tube::rod(&arm, 0.06, 12), stock.iron);
    let boss = block::bevelled(DVec3::new(-0.16, -0.18, -0.16), DVec3::new(0.16, 0.18, 0.16), 0.04);
    out.extend(&boss.at(rod.x, height + 0.32, rod.z), stock.brass);
}

/// A wooden rack with test tubes; its middle is at `at`.
pub fn rack(out: &mut SceneBuilder, stock: &Stock, at: DVec3, turn: f64) {
    const PITCH: f64 = 0.56;
    let fills = [
        Some((VIOLET, 0.9)),
        Some((BLUE, 1.15)),
        Some((GREEN, 0.7)),
        None,
        Some((YELLOW, 1.2)),
        Some((ORANGE, 0.8)),
        Some((RED, 1.05)),
    ];
    let place = |p: Part| p.turned(turn).at(at.x, at.y, at.z);
    let half = PITCH * fills.len() as f64 / 2.0;
    let foot = block::bevelled(DVec3::new(-half - 0.3, 0.0, -0.5), DVec3::new(half + 0.3, 0.14, 0.5), 0.03);
    out.object("rack", &place(foot), stock.oak);
    for side in [-1.0, 1.0] {
        // A little over the ends of the boards.
        let middle = side * (half + 0.07);
        let post = block::block(DVec3::new(middle - 0.08, 0.13, -0.36), DVec3::new(middle + 0.08, 1.5, 0.36));
        out.extend(&place(post), stock.oak);
    }
    for (name, low) in [("rack shelf", 0.62), ("rack top", 1.36)] {
        out.object(name, &Part::default(), stock.oak);
        for cell in 0..fills.len() {
            let x = PITCH * (cell as f64 - (fills.len() as f64 - 1.0) / 2.0);
            out.extend(&place(drilled(PITCH, 0.7, 0.10, 0.225).at(x, low, 0.0)), stock.oak);
        }
    }
    for (cell, fill) in fills.iter().enumerate() {
        let x = PITCH * (cell as f64 - (fills.len() as f64 - 1.0) / 2.0);
        let tube = ware::test_tube(0.195, 1.9);
        let fill = fill.map(|(liquid, level)| (level, stock.liquids[liquid]));
        tube.build(out, &format!("test tube {}", cell + 1), stock.glass, fill, |p| place(p.at(x, 0.14 + GAP, 0.0)));
    }
}

/// A board of `width` x `depth` with a round hole in its middle, cut like a slice of a longer one: no faces at its
/// ends.
fn drilled(width: f64, depth: f64, thick: f64, hole: f64) -> Part {
    // A multiple of eight: then points stand in the corners of the board, and its edges are straight.
    const SIDES: usize = 24;
    let (w, d) = (width / 2.0, depth / 2.0);
    Part::grid(5, SIDES, true, |row, column| {
        let (sin, cos) = sin_cos(std::f64::consts::TAU * column as f64 / SIDES as f64);
        let scale = sin.abs().max(cos.abs());
        let (top, bottom) = (thick, 0.0);
        let edge = |y: f64| DVec3::new(sin / scale * w, y, cos / scale * d);
        let bore = |y: f64| DVec3::new(sin * hole, y, cos * hole);
        match row {
            0 | 4 => edge(bottom),
            1 => edge(top),
            2 => bore(top),
            _ => bore(bottom),
        }
    })
}

/// A hot plate with a beaker on it.
pub fn hot_plate(out: &mut SceneBuilder, stock: &Stock, at: DVec3, turn: f64) {
    let place = |p: Part| p.turned(turn).at(at.x, at.y, at.z);
    let body = block::bevelled(DVec3::new(-1.05, 0.08, -0.95), DVec3::new(1.05, 0.62, 1.15), 0.07);
    out.object("hot plate", &place(body), stock.enamel);
    for (x, z) in [(-0.85, -0.75), (0.85, -0.75), (-0.85, 0.95), (0.85, 0.95)] {
        let foot =
            lathe(&[DVec2::new(0.0, 0.0), DVec2::new(0.11, 0.0), DVec2::new(0.11, 0.09), DVec2::new(0.0, 0.09)], 12);
        out.extend(&place(foot.at(x, 0.0, z)), stock.iron);
    }
    let plate = sample(&[c(0.0, 0.60), c(0.84, 0.60), c(0.84, 0.72), s(0.80, 0.76), c(0.0, 0.76)], 0.3);
    out.object("plate", &place(lathe(&plate, 48).at(0.0, 0.0, -0.05)), stock.steel);
    for x in [-0.5, 0.5] {
        let knob = sample(&[c(0.0, 0.0), c(0.19, 0.0), s(0.18, 0.10), s(0.15, 0.15), c(0.0, 0.15)], 0.05);
        let (from, to) = (DVec3::new(x, 0.33, 1.14), DVec3::new(x, 0.33, 2.0));
        out.object("knob", &place(along(lathe(&knob, 24), from, to)), stock.iron);
    }
    let beaker = ware::beaker(0.66, 1.55);
    let place = |p: Part| p.turned(turn + 40.0).at(at.x, at.y + 0.76 + GAP, at.z - 0.05);
    beaker.build(out, "hot beaker", stock.glass, Some((0.85, stock.liquids[CLEAR])), place);
    let rod = crate::modelling::vessel::glass_rod(2.3, 0.045, 14);
    // It stands in the water and leans on the rim.
    let foot = DVec3::new(at.x + 0.38, at.y + 0.86, at.z - 0.05);
    out.object("thermometer", &along(rod, foot, foot + DVec3::new(-0.95, 1.45, 0.0)), stock.enamel);
}
