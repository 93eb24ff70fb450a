//! Stone houses: walls with openings, quoins and dressed surrounds.

use glam::{DVec2, DVec3};

use crate::{
    builtin::provence::{
        joinery,
        materials::Materials,
        plan::{Closing, House, Opening, REVEAL},
        roof,
    },
    modelling::{
        Part, SceneBuilder,
        block::{bevelled, block, rectangle},
        scatter::{Rng, upright},
    },
};

/// Adds a house.
pub fn add(out: &mut SceneBuilder, m: &Materials, house: &House, rng: &mut Rng) {
    let place = |part: Part| part.turned(house.degrees).at(house.at.x, house.at.y, house.at.z);
    let size = house.size;
    out.object(&format!("{} walls", house.name), &place(walls(house)), m.stone);
    let mut trim = Part::default();
    for side in [0, 2] {
        for end in [-1.0, 1.0] {
            trim = trim.with(turned(side, quoins(end * size.x / 2.0, size.y), size));
        }
    }
    out.object(&format!("{} quoins", house.name), &place(trim), m.dressed);
    for (side, openings) in house.openings.iter().enumerate() {
        for (index, opening) in openings.iter().enumerate() {
            let put = |part: Part| place(turned(side, part, size));
            let name = format!("{} {side}.{index}", house.name);
            out.object(&format!("{name} frame"), &put(surround(opening)), m.dressed);
            match opening.closing {
                Closing::Window => joinery::glaze(out, m, &name, opening, &put),
                Closing::Door => out.object(&format!("{name} door"), &put(joinery::planks(opening)), m.door),
            }
        }
    }
    let frame = upright(house.at, house.degrees, DVec3::ONE);
    roof::add(out, m, house, &frame, rng);
}

/// Moves a part from the front wall (x along the wall, the face of the wall at z = 0) to wall number `side`.
fn turned(side: usize, part: Part, size: DVec3) -> Part {
    let depth = if side.is_multiple_of(2) { size.z } else { size.x };
    part.at(0.0, 0.0, depth / 2.0).turned(90.0 * side as f64)
}

/// Four walls with holes and reveals, and the gables.
fn walls(house: &House) -> Part {
    let size = house.size;
    let mut part = Part::default();
    for (side, openings) in house.openings.iter().enumerate() {
        let width = if side.is_multiple_of(2) { size.x } else { size.z };
        let mut wall = wall(width, size.y, openings);
        if !side.is_multiple_of(2) {
            let gable = Part {
                positions: [(-width / 2.0, 0.0), (width / 2.0, 0.0), (0.0, house.rise)]
                    .map(|(x, y)| DVec3::new(x, size.y + y, 0.0))
                    .to_vec(),
                uvs: vec![DVec2::ZERO; 3],
                triangles: vec![[0, 1, 2]],
                ..Part::default()
            };
            wall = wall.with(gable);
        }
        let shift = 0.37 * side as f64;
        wall.uvs = wall.positions.iter().map(|p| DVec2::new((p.x + p.z) / 3.2 + shift, p.y / 3.2)).collect();
        part = part.with(turned(side, wall, size));
    }
    part.crease(30.0)
}

/// A wall from rectangles round its openings, and their reveals.
fn wall(width: f64, height: f64, openings: &[Opening]) -> Part {
    let sorted = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        values
    };
    let xs = openings.iter().flat_map(|o| [o.x - o.width / 2.0, o.x + o.width / 2.0]);
    let ys = openings.iter().flat_map(|o| [o.y, o.y + o.height]);
    let xs = sorted(xs.chain([-width / 2.0, width / 2.0]).collect());
    let ys = sorted(ys.chain([-0.6, height]).collect());
    let is_open =
        |x: f64, y: f64| openings.iter().any(|o| (x - o.x).abs() < o.width / 2.0 && y > o.y && y < o.y + o.height);
    let mut part = Part::default();
    for x in xs.windows(2) {
        for y in ys.windows(2) {
            if !is_open((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0) {
                part = part.with(rectangle(
                    DVec3::new(x[0], y[0], 0.0),
                    DVec3::X * (x[1] - x[0]),
                    DVec3::Y * (y[1] - y[0]),
                ));
            }
        }
    }
    for o in openings {
        part = part.with(reveal(o));
    }
    part
}

/// The four sides of a hole, facing into it.
fn reveal(o: &Opening) -> Part {
    let (l, r, b, t) = (o.x - o.width / 2.0, o.x + o.width / 2.0, o.y, o.y + o.height);
    let back = DVec3::NEG_Z * (REVEAL + 0.3);
    let (w, h) = (DVec3::X * o.width, DVec3::Y * o.height);
    rectangle(DVec3::new(l, b, 0.0), back, h)
        .with(rectangle(DVec3::new(r, b, 0.0) + back, -back, h))
        .with(rectangle(DVec3::new(l, b, 0.0), w, back))
        .with(rectangle(DVec3::new(l, t, 0.0) + back, w, -back))
}

/// Long and short stones in turns up a corner.
fn quoins(x: f64, height: f64) -> Part {
    let mut part = Part::default();
    let courses = libm::floor(height / 0.36) as usize;
    let rise = height / courses as f64;
    for i in 0..courses {
        let (along, depth) = if i.is_multiple_of(2) { (0.52, 0.30) } else { (0.30, 0.52) };
        let inward = -x.signum();
        let (a, b) = (x - inward * 0.035, x + inward * along);
        let low = DVec3::new(a.min(b), i as f64 * rise + 0.012, -depth);
        let high = DVec3::new(a.max(b), (i + 1) as f64 * rise - 0.012, 0.035);
        part = part.with(block(low, high));
    }
    part
}

/// Lintel, sill and jambs of dressed stone, proud of the wall.
fn surround(o: &Opening) -> Part {
    let (l, r, b, t) = (o.x - o.width / 2.0, o.x + o.width / 2.0, o.y, o.y + o.height);
    let bar = |x0: f64, y0: f64, x1: f64, y1: f64, out: f64| {
        bevelled(DVec3::new(x0, y0, -0.1), DVec3::new(x1, y1, out), 0.015)
    };
    let mut part =
        bar(l - 0.2, t, r + 0.2, t + 0.24, 0.045).with(bar(l - 0.13, b, l, t, 0.03)).with(bar(r, b, r + 0.13, t, 0.03));
    if o.closing == Closing::Window {
        part = part.with(bar(l - 0.22, b - 0.12, r + 0.22, b, 0.11));
    } else {
        part = part.with(block(DVec3::new(l - 0.3, b - 0.3, -0.2), DVec3::new(r + 0.3, b + 0.06, 0.55)));
    }
    part
}

/// A chimney of stone with a cap, standing on a roof.
pub fn chimney(at: DVec3, height: f64) -> Part {
    let tall = bevelled(at - DVec3::new(0.42, 1.4, 0.32), at + DVec3::new(0.42, height, 0.32), 0.03);
    let cap = bevelled(at + DVec3::new(-0.52, height, -0.42), at + DVec3::new(0.52, height + 0.1, 0.42), 0.03);
    tall.with(cap)
}
