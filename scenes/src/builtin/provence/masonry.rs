//! Loose stones: the dry-stone wall, and the pool with its rim, water and fountain.

use glam::{DVec2, DVec3};

use crate::{
    builtin::provence::{
        land::{self, ground},
        materials::Materials,
    },
    modelling::{
        Part, SceneBuilder, block,
        lathe::lathe,
        profile::{c, s, sample},
        scatter::{Cluster, Rng, upright},
    },
};

/// A rounded stone of size 1, rough by `seed`.
fn stone(seed: u32) -> Cluster {
    let mut rng = Rng::new(seed);
    let half = DVec3::new(0.5, 0.5, 0.5);
    let mut part = block::bevelled(-half, half, 0.13);
    // The first and the last row fall together in a point, and must stay together.
    for p in &mut part.positions[8..32] {
        *p += rng.direction() * 0.055;
    }
    Cluster::of(&part.crease(28.0)).with_uv(|p, _| DVec2::new(0.0, 0.5 + 0.3 * p.y))
}

/// Where the wall begins and ends along the road.
const WALL: (f64, f64) = (0.34, 0.605);
/// Distance of the wall's middle from the middle of the road.
const WALL_OFF: f64 = land::ROAD_HALF + 1.25;

/// The dry-stone wall between road and grove: five courses of stones on an earthen core.
pub fn wall(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(601);
    let stones: Vec<Cluster> = (0..5).map(|i| stone(610 + i)).collect();
    let mut wall = wall_core();
    for course in 0..5 {
        let mut t = WALL.0;
        while t < WALL.1 {
            let (p, d) = land::road(t);
            let at = p + DVec2::new(-d.y, d.x) * (WALL_OFF + rng.between(-0.04, 0.04));
            let width = rng.between(0.34, 0.62);
            let tall = if course == 4 { 0.15 } else { 0.225 };
            let y = 0.04 + f64::from(course) * 0.19 + rng.between(-0.012, 0.012);
            let degrees = libm::atan2(d.x, d.y).to_degrees() + 90.0 + rng.between(-3.0, 3.0);
            let depth = (0.62 - 0.05 * f64::from(course)) * rng.between(0.92, 1.08);
            let scale = DVec3::new(width * 1.05, tall * rng.between(1.0, 1.1), depth);
            let place = upright(ground(at.x, at.y) + DVec3::Y * y, degrees, scale);
            wall.stamp(&stones[rng.pick(stones.len())], &place, DVec2::new(rng.unit(), 0.0));
            // The parameter of the road is no length. A small step along it tells how many metres one unit is here.
            let speed = (land::road(t + 1e-3).0 - p).length() / 1e-3;
            t += width / speed;
        }
    }
    out.cluster("wall", &wall, m.rock);
}

/// What fills the wall between its stones, so that no light shows through.
fn wall_core() -> Cluster {
    const PIECES: usize = 70;
    let section = [(0.17, -0.2), (0.17, 0.74), (-0.17, 0.74), (-0.17, -0.2)];
    let part = Part::grid(PIECES + 1, section.len(), false, |row, column| {
        let (p, d) = land::road(WALL.0 + (WALL.1 - WALL.0) * row as f64 / PIECES as f64);
        let (off, y) = section[column];
        let at = p + DVec2::new(-d.y, d.x) * (WALL_OFF - off);
        ground(at.x, at.y) + DVec3::Y * y
    });
    Cluster::of(&part.crease(40.0)).with_uv(|_, _| DVec2::new(0.3, 0.02))
}

/// The pool: lined walls, pebbles, rim of stones, water, and a fountain in the middle.
pub fn pool(out: &mut SceneBuilder, m: &Materials) {
    let level = land::height(land::POOL.x, land::POOL.y);
    let rings = [(0.12, 0.10), (0.12, 0.17), (-0.14, 0.17), (-0.14, -0.9)];
    let lining = Part::grid(rings.len(), 96, true, |row, column| {
        let (offset, y) = rings[row];
        rim_point(column as f64 / 96.0, offset, level + y)
    });
    out.object("pool lining", &lining.crease(30.0).planar_uv(land::POOL, 5.0), m.dressed);
    let floor = Part::grid(9, 64, true, |row, column| {
        let r = 1.0 - row as f64 / 8.0;
        let p = land::POOL + (land::pool_rim(column as f64 / 64.0, -0.1) - land::POOL) * r;
        DVec3::new(p.x, level - 0.85 + 0.12 * r * r, p.y)
    });
    out.object("pool floor", &floor.crease(80.0).planar_uv(land::POOL, 4.0), m.pebbles);
    out.cluster("pool rim", &rim(level), m.rock);
    out.object("water", &water(level + 0.07), m.water);
    let fountain = fountain().at(land::POOL.x, level, land::POOL.y);
    out.object("fountain", &fountain.crease(35.0).planar_uv(land::POOL, 3.0), m.dressed);
}

/// A point `offset` metres outside the middle of the rim, at a height.
fn rim_point(turn: f64, offset: f64, y: f64) -> DVec3 {
    let p = land::pool_rim(turn, offset);
    DVec3::new(p.x, y, p.y)
}

/// Coping stones, side by side round the pool.
fn rim(level: f64) -> Cluster {
    const COUNT: u32 = 58;
    let mut rng = Rng::new(701);
    let stones: Vec<Cluster> = (0..5).map(|i| stone(710 + i)).collect();
    let mut rim = Cluster::default();
    for i in 0..COUNT {
        let end = |k: u32| rim_point(f64::from(k) / f64::from(COUNT), 0.0, level + 0.13);
        let (here, next) = (end(i), end(i + 1));
        let along = next - here;
        let degrees = libm::atan2(-along.z, along.x).to_degrees() + rng.between(-1.5, 1.5);
        let scale = DVec3::new(along.length() * 0.99, 0.34 * rng.between(0.96, 1.04), 0.56 * rng.between(0.95, 1.05));
        let place = upright((here + next) / 2.0, degrees, scale);
        rim.stamp(&stones[rng.pick(stones.len())], &place, DVec2::new(rng.unit(), 0.0));
    }
    rim
}

/// A turned column with a basin, standing on the pool's floor.
fn fountain() -> Part {
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
    lathe(&sample(&knots, 0.12), 32)
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
