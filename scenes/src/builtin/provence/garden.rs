//! Where things grow and lie: the field, the grove, cypresses, grass, far trees, the wall, the pool.

use glam::{DVec2, DVec3};

use crate::{
    builtin::provence::{
        land::{self, FIELD, ground},
        materials::Materials,
        path, plants,
    },
    modelling::{
        Part, SceneBuilder, block,
        lathe::lathe,
        part::sin_cos,
        profile::{c, s, sample},
        scatter::{Cluster, Rng, upright},
    },
};

/// Distance of lavender rows.
const ROW: f64 = 1.75;
/// Distance of bushes in a row.
const BUSH: f64 = 0.72;

/// Lavender in rows that run south; near the path every spike is there.
pub fn lavender(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(101);
    let near: Vec<Cluster> = (0..4).map(|i| plants::lavender(34, 110 + i)).collect();
    let middle: Vec<Cluster> = (0..4).map(|i| plants::lavender_far(28, 120 + i)).collect();
    let far: Vec<Cluster> = (0..3).map(|i| plants::lavender_far(19, 130 + i)).collect();
    let eyes = path::eyes();
    let [west, north, east, south] = FIELD;
    let rows = libm::floor((east - west - 1.6) / ROW) as usize;
    for row in 0..=rows {
        let x = west + 0.9 + row as f64 * ROW;
        let mut cluster = Cluster::default();
        let count = libm::floor((south - north - 1.4) / BUSH) as usize;
        for i in 0..count {
            let z = north + 0.9 + i as f64 * BUSH + rng.between(-0.08, 0.08);
            let bx = x + rng.between(-0.07, 0.07);
            let (size, turn, shade) = (rng.between(0.85, 1.18), rng.between(0.0, 360.0), rng.unit());
            let pick = |set: &[Cluster]| (row * 7 + i * 3) % set.len();
            let plant = match path::distance(&eyes, bx, z) {
                d if d < 4.5 => &near[pick(&near)],
                d if d < 10.0 => &middle[pick(&middle)],
                _ => &far[pick(&far)],
            };
            let scale = DVec3::new(size * 1.12, size * rng.between(0.92, 1.1), size * 1.12);
            cluster.stamp(plant, &upright(ground(bx, z), turn, scale), DVec2::new(shade, 0.0));
        }
        out.cluster(&format!("lavender row {row}"), &cluster, m.lavender);
    }
}

/// Cypresses by the house and along the road.
pub fn cypresses(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(201);
    let kinds: Vec<Cluster> = (0..3).map(|i| plants::cypress(500, 210 + i)).collect();
    let places = [
        (-14.5, 6.5, 10.5),
        (-17.2, 3.0, 12.0),
        (-19.0, 8.8, 9.0),
        (12.2, -5.5, 11.5),
        (10.6, -9.5, 9.5),
        (24.8, 22.0, 9.0),
        (24.9, 33.0, 10.0),
        (22.2, 44.0, 9.4),
        (18.2, 56.0, 10.4),
        (19.2, -20.0, 10.0),
        (-24.0, -14.0, 11.0),
    ];
    for (i, (x, z, tall)) in places.into_iter().enumerate() {
        let wide = tall * rng.between(0.85, 1.05);
        let place = upright(ground(x, z) - DVec3::Y * 0.3, rng.between(0.0, 360.0), DVec3::new(wide, tall, wide));
        let mut tree = Cluster::default();
        tree.stamp(&kinds[i % kinds.len()], &place, DVec2::new(rng.unit(), 0.0));
        out.cluster(&format!("cypress {i}"), &tree, m.cypress);
    }
}

/// The olive grove east of the road, and single trees by the house.
pub fn olives(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(301);
    let kinds: Vec<(Cluster, Cluster)> = (0..3).map(|i| plants::olive(1600, 310 + i * 5)).collect();
    let mut places = vec![(-12.5, 14.8), (15.2, 8.2), (4.5, -14.0)];
    for row in 0..5 {
        for column in 0..4 {
            let (x, z) = (27.5 + 6.2 * f64::from(column), 8.0 + 8.5 * f64::from(row));
            places.push((x + rng.between(-0.9, 0.9), z + rng.between(-0.9, 0.9)));
        }
    }
    for (i, (x, z)) in places.into_iter().enumerate() {
        let size = rng.between(0.85, 1.15);
        let place = upright(ground(x, z), rng.between(0.0, 360.0), DVec3::splat(size));
        let (wood, leaves) = &kinds[i % kinds.len()];
        let (mut trunk, mut crown) = (Cluster::default(), Cluster::default());
        trunk.stamp(wood, &place, DVec2::ZERO);
        crown.stamp(leaves, &place, DVec2::new(rng.unit(), 0.0));
        out.cluster(&format!("olive trunk {i}"), &trunk, m.bark);
        out.cluster(&format!("olive {i}"), &crown, m.olive);
    }
}

/// Woods and hedges on the hills around.
pub fn far_trees(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(401);
    let trees: Vec<Cluster> = (0..3).map(|i| plants::bush(130, 0.17, 410 + i)).collect();
    let slim = plants::cypress(18, 420);
    let (mut woods, mut flames) = (Cluster::default(), Cluster::default());
    let mut placed = 0;
    while placed < 290 {
        let (sin, cos) = sin_cos(rng.between(0.0, std::f64::consts::TAU));
        let far = 62.0 + 300.0 * rng.unit() * rng.unit();
        let (x, z) = (sin * far, 10.0 + cos * far);
        let open = land::in_field(x, z, -4.0) || (x > 9.0 && x < 52.0 && z > 0.0 && z < 60.0);
        if open || land::road_distance(x, z) < 6.0 || (z > 60.0 && x.abs() < 30.0) {
            continue;
        }
        placed += 1;
        let tall = rng.between(2.6, 5.2) * (1.0 + far / 250.0);
        let at = ground(x, z) - DVec3::Y * 0.4;
        let (turn, shade) = (rng.between(0.0, 360.0), DVec2::new(rng.unit(), 0.0));
        if placed % 6 == 0 {
            flames.stamp(&slim, &upright(at, turn, DVec3::new(tall * 2.0, tall * 2.4, tall * 2.0)), shade);
        } else {
            let kind = &trees[rng.pick(trees.len())];
            woods.stamp(kind, &upright(at, turn, DVec3::new(tall, tall * 0.85, tall)), shade);
        }
    }
    out.cluster("woods", &woods, m.leaf);
    out.cluster("far cypresses", &flames, m.cypress);
}

/// Grass by the road and round the yard, with poppies.
pub fn meadow(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(501);
    let tufts: Vec<Cluster> = (0..4).map(|i| plants::grass(9, 510 + i)).collect();
    let poppies: Vec<(Cluster, Cluster)> = (0..3).map(|i| plants::poppy(520 + i)).collect();
    let (mut grass, mut stalks, mut cups) = (Cluster::default(), Cluster::default(), Cluster::default());
    let mut placed = 0;
    while placed < 2300 {
        let (p, d) = land::road(rng.between(0.12, 0.80));
        let side = if rng.unit() < 0.5 { -1.0 } else { 1.0 };
        let away = land::ROAD_HALF - 0.15 + 5.0 * rng.unit() * rng.unit();
        let p = p + DVec2::new(-d.y, d.x) * (side * away);
        if land::in_field(p.x, p.y, 0.4) || land::is_built(p.x, p.y) {
            continue;
        }
        placed += 1;
        let at = ground(p.x, p.y);
        let (turn, size, shade) = (rng.between(0.0, 360.0), rng.between(0.7, 1.4), DVec2::new(rng.unit(), 0.0));
        grass.stamp(&tufts[rng.pick(tufts.len())], &upright(at, turn, DVec3::splat(size)), shade);
        if placed % 6 == 0 {
            let place = upright(at + DVec3::new(0.15, 0.0, 0.1), turn, DVec3::splat(rng.between(0.9, 1.3)));
            let (stalk, cup) = &poppies[rng.pick(poppies.len())];
            stalks.stamp(stalk, &place, shade);
            cups.stamp(cup, &place, DVec2::ZERO);
        }
    }
    out.cluster("grass", &grass, m.grass);
    out.cluster("poppies", &cups, m.poppy);
    out.scatter(&stalks, m.leaf);
}

/// A rounded stone of size 1, rough by `seed`.
fn stone(seed: u32) -> Cluster {
    let mut rng = Rng::new(seed);
    let half = DVec3::new(0.5, 0.5, 0.5);
    let part = block::bevelled(-half, half, 0.13);
    let bumps: Vec<DVec3> = part.positions.iter().map(|_| rng.direction() * 0.055).collect();
    let mut part = part;
    // The rows that fall together in a point must stay together.
    for (i, p) in part.positions.iter_mut().enumerate() {
        if i >= 8 && i < 32 {
            *p += bumps[i];
        }
    }
    Cluster::of(&part.crease(28.0)).with_uv(|p, _| DVec2::new(0.0, 0.5 + 0.3 * p.y))
}

/// The dry-stone wall between road and grove.
pub fn wall(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(601);
    let stones: Vec<Cluster> = (0..5).map(|i| stone(610 + i)).collect();
    let mut wall = Cluster::default();
    for course in 0..5 {
        let mut t = 0.34;
        while t < 0.605 {
            let (p, d) = land::road(t);
            let side = DVec2::new(-d.y, d.x);
            let width = rng.between(0.34, 0.62);
            let step = width / 135.0;
            let off = land::ROAD_HALF + 1.25 + rng.between(-0.04, 0.04);
            let at = p + side * off;
            let tall = if course == 4 { 0.15 } else { 0.215 };
            let y = 0.04 + f64::from(course) * 0.19 + rng.between(-0.012, 0.012);
            let degrees = libm::atan2(d.x, d.y).to_degrees() + 90.0 + rng.between(-3.0, 3.0);
            let depth = (0.62 - 0.05 * f64::from(course)) * rng.between(0.92, 1.08);
            let scale = DVec3::new(width * 1.03, tall * rng.between(1.0, 1.1), depth);
            wall.stamp(
                &stones[rng.pick(stones.len())],
                &upright(ground(at.x, at.y) + DVec3::Y * y, degrees, scale),
                DVec2::new(rng.unit(), 0.0),
            );
            t += step;
        }
    }
    out.cluster("wall", &wall, m.rock);
}

/// The pool: rim of stones, lined walls, pebbles, water, and a column in the middle.
pub fn pool(out: &mut SceneBuilder, m: &Materials) {
    let level = land::height(land::POOL.x, land::POOL.y);
    let at = |turn: f64, offset: f64, y: f64| {
        let p = land::pool_rim(turn, offset);
        DVec3::new(p.x, level + y, p.y)
    };
    let rings = [(0.12, 0.10), (0.12, 0.17), (-0.14, 0.17), (-0.14, -0.9)];
    let lining = Part::grid(rings.len(), 96, true, |row, column| {
        let (offset, y) = rings[row];
        at(column as f64 / 96.0, offset, y)
    });
    out.object("pool lining", &lining.crease(30.0).planar_uv(land::POOL, 5.0), m.dressed);
    let floor = disc(
        |turn, r| {
            let p = land::POOL + (land::pool_rim(turn, -0.1) - land::POOL) * r;
            DVec3::new(p.x, level - 0.85 + 0.12 * r * r, p.y)
        },
        8,
        64,
    );
    out.object("pool floor", &floor.crease(80.0).planar_uv(land::POOL, 4.0), m.pebbles);
    let mut rng = Rng::new(701);
    let stones: Vec<Cluster> = (0..5).map(|i| stone(710 + i)).collect();
    let mut rim = Cluster::default();
    let count = 58;
    for i in 0..count {
        let turn = (f64::from(i) + 0.5) / f64::from(count);
        let (here, next) = (at(turn - 0.5 / f64::from(count), 0.0, 0.0), at(turn + 0.5 / f64::from(count), 0.0, 0.0));
        let along = next - here;
        let degrees = libm::atan2(-along.z, along.x).to_degrees() + rng.between(-1.5, 1.5);
        let scale = DVec3::new(along.length() * 0.99, 0.34 * rng.between(0.96, 1.04), 0.56 * rng.between(0.95, 1.05));
        let place = upright((here + next) / 2.0 + DVec3::Y * 0.13, degrees, scale);
        rim.stamp(&stones[rng.pick(stones.len())], &place, DVec2::new(rng.unit(), 0.0));
    }
    out.cluster("pool rim", &rim, m.rock);
    out.object("water", &water(level + 0.07), m.water);
    let knots = [
        c(0.0, -0.95),
        c(0.85, -0.95),
        c(0.85, 0.22),
        c(0.55, 0.30),
        s(0.30, 0.45),
        s(0.24, 1.0),
        s(0.30, 1.30),
        s(0.85, 1.55),
        s(0.98, 1.66),
        s(0.95, 1.72),
        s(0.80, 1.66),
        c(0.16, 1.56),
        s(0.20, 1.75),
        s(0.10, 2.05),
        s(0.19, 2.22),
        s(0.12, 2.36),
        c(0.0, 2.42),
    ];
    let column = lathe(&sample(&knots, 0.12), 32).at(land::POOL.x, level, land::POOL.y);
    out.object("fountain", &column.crease(35.0).planar_uv(land::POOL, 3.0), m.dressed);
}

/// A disc of rings, front up: `surface(turn, r)` with `r` from 0 to 1.
fn disc(surface: impl Fn(f64, f64) -> DVec3, rings: usize, segments: usize) -> Part {
    Part::grid(rings + 1, segments, true, |row, column| {
        let r = 1.0 - row as f64 / rings as f64;
        surface(if row == rings { 0.0 } else { column as f64 / segments as f64 }, r)
    })
}

/// A closed body of water: slight waves above, its sides in the rim's stones, its bottom below the
/// pool's floor.
fn water(level: f64) -> Part {
    const RINGS: usize = 22;
    const SEGMENTS: usize = 88;
    let wave = |p: DVec2| {
        let away = (p - land::POOL).length();
        0.006 * libm::sin(away * 5.2)
            + 0.004 * libm::sin(p.x * 3.1 + p.y * 1.7)
            + 0.003 * libm::sin(p.x * 1.3 - p.y * 4.3 + 0.8)
    };
    Part::grid(RINGS + 4, SEGMENTS, true, |row, column| {
        let turn = column as f64 / SEGMENTS as f64;
        let edge = land::pool_rim(turn, -0.02);
        let flat = |p: DVec2, y: f64| DVec3::new(p.x, y, p.y);
        match row {
            0 => flat(land::POOL, level - 1.6),
            1 => flat(edge, level - 1.6),
            _ => {
                let r = 1.0 - (row - 2) as f64 / (RINGS + 1) as f64;
                let p = if row == RINGS + 3 { land::POOL } else { land::POOL + (edge - land::POOL) * r };
                flat(p, level + wave(p))
            }
        }
    })
    .crease(40.0)
}
