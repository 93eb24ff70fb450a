//! Roofs of canal tiles: every tile is modelled, a half cone that overlaps the next.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::{
    builtin::provence::{materials::Materials, plan::House},
    modelling::{
        Part, SceneBuilder,
        block::block,
        part::sin_cos,
        scatter::{Cluster, Rng},
    },
};

/// Distance of tile columns.
const ACROSS: f64 = 0.235;
/// Length of a tile that shows.
const COURSE: f64 = 0.37;
/// How far the roof stands over the walls.
const EAVES: f64 = 0.42;

/// Adds both slopes and the ridge.
pub fn add(out: &mut SceneBuilder, m: &Materials, house: &House, frame: &DAffine3, rng: &mut Rng) {
    let size = house.size;
    let width = size.x + 0.5;
    let (run, rise) = (size.z / 2.0, house.rise);
    let slope = DVec2::new(run, rise);
    let long = slope.length() * (1.0 + EAVES / run);
    let mut deck = Part::default();
    let mut tiles = Cluster::default();
    let tile = tile();
    for way in [1.0, -1.0] {
        let up = DVec3::new(0.0, rise, -run * way).normalize_or(DVec3::Y);
        let along = DVec3::X * way;
        let eave = DVec3::new(-width / 2.0 * way, size.y + rise + 0.06, 0.0) - up * long;
        let board = block(DVec3::new(0.0, -0.12, -long), DVec3::new(width, 0.0, 0.0));
        let lay = on_slope(eave, along, up, 1.0);
        deck = deck.with(board.map(|p| lay.transform_point3(p)));
        let (columns, rows) = (libm::floor(width / ACROSS) as usize, libm::floor(long / COURSE) as usize);
        for row in 0..rows {
            for column in 0..columns {
                let x = (column as f64 + 0.5) * width / columns as f64 + rng.between(-0.008, 0.008);
                let y = row as f64 * long / rows as f64 - 0.05 + rng.between(-0.015, 0.015);
                let out_of = along.cross(up);
                let (sin, cos) = sin_cos(rng.between(-0.025, 0.025));
                let at = eave + along * x + up * y + out_of * rng.between(0.0, 0.012);
                let place = on_slope(at, along * cos + up * sin, up * cos - along * sin, 1.0);
                tiles.stamp(&tile, &(*frame * place), DVec2::new(rng.unit(), 0.0));
            }
        }
    }
    let count = libm::floor(width / 0.36) as usize;
    let ridge = DVec3::new(0.0, size.y + rise + 0.045, 0.0);
    for i in 0..count {
        let at = ridge + DVec3::X * (width * (i as f64 / count as f64 - 0.5));
        let place = on_slope(at, DVec3::Z, DVec3::X, 1.35);
        tiles.stamp(&tile, &(*frame * place), DVec2::new(rng.unit(), 0.0));
    }
    out.cluster(&format!("{} roof", house.name), &framed(&deck, frame), m.mortar);
    out.cluster(&format!("{} tiles", house.name), &tiles, m.tile);
}

/// A tile from its wide lower end at z = 0 to its narrow upper end, arched over x, `y` out of the roof.
fn tile() -> Cluster {
    const SEGMENTS: usize = 6;
    let part = Part::grid(2, SEGMENTS + 1, false, |row, column| {
        let (radius, z, lift) = if row == 0 { (0.115, 0.0, 0.035) } else { (0.088, -0.47, -0.005) };
        let angle = std::f64::consts::PI * (1.0 - column as f64 / SEGMENTS as f64);
        let (sin, cos) = sin_cos(angle);
        DVec3::new(radius * cos, lift + radius * 0.85 * sin, z)
    });
    // One colour per tile, a little darker where the next one lies on it.
    Cluster::of(&part.crease(80.0)).with_uv(|p, _| DVec2::new(0.0, 0.15 - p.z))
}

/// A frame on a slope: `along` the eave, `up` the slope, `out` of it.
fn on_slope(at: DVec3, along: DVec3, up: DVec3, scale: f64) -> DAffine3 {
    let out = along.cross(up);
    DAffine3::from_mat3_translation(DMat3::from_cols(along * scale, out * scale, -up * scale), at)
}

/// A cluster of one part, in the house's frame.
fn framed(part: &Part, frame: &DAffine3) -> Cluster {
    let mut out = Cluster::default();
    out.stamp(&Cluster::of(part), frame, DVec2::ZERO);
    out
}
