//! In front of the house: a gravel court, paving round the pool, pots, box bushes, a wisteria.

use glam::{DAffine3, DVec2, DVec3};

use crate::{
    builtin::provence::{
        land::{self, ground},
        materials::Materials,
        plants,
    },
    modelling::{
        Part, SceneBuilder,
        lathe::lathe,
        profile::{c, s, sample},
        scatter::{Cluster, Rng, upright},
    },
};

/// Adds everything in the yard.
pub fn add(out: &mut SceneBuilder, m: &Materials) {
    out.object("court", &court(), m.court);
    out.object("paving", &paving(), m.paving);
    pots(out, m);
    wisteria(out, m);
}

/// A sheet of gravel from the house's front to a winding edge; its borders are let into the ground.
fn court() -> Part {
    const ACROSS: usize = 36;
    const DEEP: usize = 9;
    let [west, east] = land::COURT;
    let mut part = Part::grid(DEEP + 1, ACROSS + 1, false, |row, column| {
        let x = west + (east - west) * column as f64 / ACROSS as f64;
        let south = land::court_edge(x);
        let z = south + (1.0 - south) * row as f64 / DEEP as f64;
        let border = row == 0 || column == 0 || column == ACROSS;
        ground(x, z) + DVec3::Y * if border { -0.05 } else { 0.045 }
    });
    part.uvs = part.positions.iter().map(|p| DVec2::new(p.x, -p.z) / 4.5).collect();
    part.crease(80.0)
}

/// Flagstones round the pool's rim.
fn paving() -> Part {
    let mut part = Part::grid(4, 72, true, |row, column| {
        let turn = column as f64 / 72.0;
        let wind = 0.16 * libm::sin(turn * 75.0) + 0.11 * libm::sin(turn * 132.0 + 1.0);
        let (offset, lift) = [(1.75 + wind, -0.05), (1.62 + wind, 0.07), (0.9, 0.08), (0.1, 0.085)][row];
        let p = land::pool_rim(turn, offset);
        ground(p.x, p.y) + DVec3::Y * lift
    });
    part.uvs = part.positions.iter().map(|p| DVec2::new(p.x, -p.z) / 3.6).collect();
    part.crease(80.0)
}

/// Glazed pots with lavender by the doors and round the pool, box bushes along the walls.
fn pots(out: &mut SceneBuilder, m: &Materials) {
    let knots = [
        c(0.0, 0.0),
        c(0.20, 0.0),
        s(0.27, 0.20),
        s(0.30, 0.40),
        c(0.31, 0.44),
        s(0.35, 0.45),
        s(0.355, 0.52),
        c(0.34, 0.54),
        c(0.29, 0.54),
        c(0.27, 0.46),
        c(0.0, 0.46),
    ];
    let pot = lathe(&sample(&knots, 0.14), 18).crease(40.0);
    let (flowers, box_bush) = (plants::lavender(34, 801), plants::bush(420, 0.085, 802));
    let mut rng = Rng::new(803);
    let doors = [(-4.35, 4.35), (-2.0, 4.4), (7.45, 2.45), (9.35, 2.45)];
    let pool = [0.13, 0.39, 0.63, 0.88].map(|turn| land::pool_rim(turn, 1.05)).map(|p| (p.x, p.y));
    for (i, (x, z)) in doors.into_iter().chain(pool).enumerate() {
        let at = ground(x, z) + DVec3::Y * 0.04;
        out.object(&format!("pot {i}"), &pot.clone().at(at.x, at.y, at.z), m.pot);
        let mut bush = Cluster::default();
        let place = upright(at + DVec3::Y * 0.40, rng.between(0.0, 360.0), DVec3::splat(0.92));
        bush.stamp(&flowers, &place, DVec2::new(rng.unit(), 0.0));
        out.cluster(&format!("pot {i} lavender"), &bush, m.lavender);
    }
    for (i, (x, z, size)) in
        [(-7.4, 4.5, 0.62), (-0.5, 4.45, 0.55), (2.4, 4.45, 0.6), (5.4, 2.5, 0.5), (-9.0, 4.2, 0.7)]
            .into_iter()
            .enumerate()
    {
        let mut bush = Cluster::default();
        bush.stamp(&box_bush, &upright(ground(x, z), rng.between(0.0, 360.0), DVec3::splat(size)), DVec2::ZERO);
        out.cluster(&format!("box {i}"), &bush, m.leaf);
    }
}

/// Where the wisteria runs over the front wall: x and y; the first line is its trunk.
const VINE: [&[(f64, f64)]; 3] = [
    &[(-2.15, 0.0), (-2.25, 1.4), (-2.1, 2.75), (-2.4, 3.2)],
    &[(-2.4, 3.2), (-4.0, 3.35), (-6.0, 3.2), (-7.9, 3.45)],
    &[(-2.4, 3.2), (-1.0, 3.4), (0.8, 3.2), (3.4, 3.35)],
];

/// A wisteria along the front of the house: trunk, leaves, hanging blossoms.
fn wisteria(out: &mut SceneBuilder, m: &Materials) {
    const WALL: f64 = 3.64;
    let mut rng = Rng::new(811);
    let (mut wood, mut leaves, mut blossoms) = (Cluster::default(), Cluster::default(), Cluster::default());
    for (branch, line) in VINE.into_iter().enumerate() {
        for (k, pair) in line.windows(2).enumerate() {
            let ends = [pair[0], pair[1]].map(|(x, y)| DVec3::new(x, y, WALL + 0.09));
            let thick = [0.085, 0.05, 0.05][branch] * (1.0 - 0.22 * k as f64);
            plants::limb(&mut wood, ends[0], ends[1], thick, thick * 0.85, 812 + k as u32);
            let dense = if branch == 0 { 22 + 40 * k } else { 190 };
            for _ in 0..dense {
                let t = rng.unit();
                let spread = rng.direction() * DVec3::new(0.32, 0.34, 0.16) * if branch == 0 { 0.7 } else { 1.0 };
                let at = ends[0] + (ends[1] - ends[0]) * t + spread + DVec3::Z * 0.13;
                let way = (DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.2, 0.3), rng.between(0.0, 0.6)))
                    .normalize_or(DVec3::Y);
                let face = (DVec3::Z + DVec3::Y * 0.5 + rng.direction() * 0.7).normalize_or(DVec3::Z);
                let across = face.cross(way).normalize_or(DVec3::X) * 0.035;
                plants::leaf(&mut leaves, at, way * rng.between(0.12, 0.2), across, face, rng.between(0.2, 0.95));
            }
            for _ in 0..if branch == 0 { 0 } else { 9 } {
                let at = ends[0] + (ends[1] - ends[0]) * rng.unit() + DVec3::new(0.0, rng.between(-0.25, 0.05), 0.28);
                let mut blossom = Cluster::default();
                blossom.spindle(at - DVec3::Y * rng.between(0.25, 0.42), at, 0.06, 0.7, 5);
                let tone = rng.between(0.0, 0.15);
                let blossom = blossom.with_uv(|_, uv| DVec2::new(0.0, 0.62 + 0.2 * uv.y + tone));
                blossoms.stamp(&blossom, &DAffine3::IDENTITY, DVec2::new(rng.unit(), 0.0));
            }
        }
    }
    out.cluster("wisteria trunk", &wood, m.bark);
    out.cluster("wisteria", &leaves, m.leaf);
    out.cluster("wisteria blossoms", &blossoms, m.lavender);
}
