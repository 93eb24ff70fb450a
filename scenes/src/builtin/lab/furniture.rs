//! Benches, drawers, sink, shelf and stool.

use glam::{DVec2, DVec3};

use crate::{
    builtin::lab::{
        metal::{chrome_tap, handle},
        room::{BACK, FLOOR},
        stock::Stock,
    },
    modelling::{
        Part, SceneBuilder, block,
        lathe::lathe,
        profile::{c, s, sample},
        tube,
    },
};

/// Half the island's length and depth.
pub const ISLAND: DVec2 = DVec2::new(13.0, 3.3);
/// The front edge of the bench along the back wall.
pub const WALL_BENCH: f64 = BACK + 5.2;
/// The sink's opening: left, back, right, front.
const SINK: [f64; 4] = [-9.6, -12.9, -5.4, -10.2];
/// Half the length of the wall bench.
const HALF: f64 = 25.9;
/// The top of the shelf.
pub const SHELF: f64 = 4.0;

/// Builds all furniture.
pub fn furniture(out: &mut SceneBuilder, stock: &Stock) {
    island(out, stock);
    wall_bench(out, stock);
    shelf(out, stock);
    stool(out, stock, DVec3::new(-5.2, FLOOR, 5.6));
    stool(out, stock, DVec3::new(6.4, FLOOR, 5.2));
}

/// Texture coordinates for boards with the grain along x: `u` along x, `v` along y and z.
fn grain(mut part: Part, size: f64, shift: f64) -> Part {
    part.uvs =
        part.positions.iter().map(|p| DVec2::new(p.x / size + shift, (p.y + p.z) / size + shift * 1.7)).collect();
    part
}

fn board(low: [f64; 3], high: [f64; 3], shift: f64) -> Part {
    grain(block::bevelled(low.into(), high.into(), 0.035), 6.0, shift)
}

fn island(out: &mut SceneBuilder, stock: &Stock) {
    let (x, z) = (ISLAND.x, ISLAND.y);
    let top = block::block(DVec3::new(-x, -0.1, -z), DVec3::new(x, 0.0, z)).planar_uv(DVec2::ZERO, 6.0);
    out.object("island top", &top, stock.bench_tiles);
    out.object("island edge", &board([-x - 0.16, -0.52, -z - 0.16], [x + 0.16, -0.03, z + 0.16], 0.3), stock.oak);
    let body = grain(block::block(DVec3::new(-x + 0.5, -8.4, -z + 0.5), DVec3::new(x - 0.5, -0.5, z - 0.5)), 6.0, 0.1);
    out.object("island body", &body, stock.dark_oak);
    let plinth = block::block(DVec3::new(-x + 0.8, FLOOR, -z + 0.8), DVec3::new(x - 0.8, -8.38, z - 0.8));
    out.object("island plinth", &plinth, stock.iron);
    fronts(out, stock, "island", z - 0.5, (-x + 0.6, x - 0.6, 8), &[(-2.7, -0.75), (-5.3, -2.85), (-8.2, -5.45)]);
}

/// Fronts with handles on a face at `z`: columns between two x, each with drawers from low to high.
fn fronts(
    out: &mut SceneBuilder,
    stock: &Stock,
    name: &str,
    z: f64,
    columns: (f64, f64, usize),
    drawers: &[(f64, f64)],
) {
    let (left, right, count) = columns;
    let width = (right - left) / count as f64;
    for column in 0..count {
        let x = left + width * column as f64;
        for (row, (low, high)) in drawers.iter().enumerate() {
            let shift = 0.37 * column as f64 + 0.61 * row as f64;
            let front = board([x + 0.06, *low, z + 0.01], [x + width - 0.06, *high, z + 0.22], shift);
            out.object(&format!("{name} drawer {}.{}", column + 1, row + 1), &front, stock.oak);
            let middle = DVec3::new(x + width / 2.0, high - 0.55, z + 0.21);
            out.object(&format!("{name} handle {}.{}", column + 1, row + 1), &handle(middle), stock.chrome);
        }
    }
}

fn wall_bench(out: &mut SceneBuilder, stock: &Stock) {
    let [left, back, right, front] = SINK;
    let sheet = |x0: f64, x1: f64, z0: f64, z1: f64| {
        let part =
            block::rectangle(DVec3::new(x0, 0.0, z1), DVec3::new(x1 - x0, 0.0, 0.0), DVec3::new(0.0, 0.0, z0 - z1));
        grain(part, 9.0, 0.0)
    };
    out.object("wall bench", &sheet(-HALF, left, BACK, WALL_BENCH), stock.teak);
    out.extend(&sheet(right, HALF, BACK, WALL_BENCH), stock.teak);
    out.extend(&sheet(left, right, BACK, back), stock.teak);
    out.extend(&sheet(left, right, front, WALL_BENCH), stock.teak);
    let edge = block::rectangle(
        DVec3::new(-HALF, -0.5, WALL_BENCH),
        DVec3::new(2.0 * HALF, 0.0, 0.0),
        DVec3::new(0.0, 0.5, 0.0),
    );
    out.extend(&grain(edge, 9.0, 0.4), stock.teak);
    let under = block::rectangle(
        DVec3::new(-HALF, -0.5, WALL_BENCH - 0.5),
        DVec3::new(2.0 * HALF, 0.0, 0.0),
        DVec3::new(0.0, 0.0, 0.5),
    );
    out.extend(&grain(under, 9.0, 0.4), stock.teak);
    let body = block::rectangle(
        DVec3::new(-HALF, FLOOR, WALL_BENCH - 0.4),
        DVec3::new(2.0 * HALF, 0.0, 0.0),
        DVec3::new(0.0, 8.5, 0.0),
    );
    out.object("wall bench body", &grain(body, 6.0, 0.2), stock.dark_oak);
    let rows = [(-2.5, -0.7), (-8.3, -2.65)];
    fronts(out, stock, "wall bench", WALL_BENCH - 0.4, (-24.0, 24.0, 12), &rows);
    sink(out, stock);
}

/// A steel basin: four walls, floor, a rolled rim; the tap stands behind it.
fn sink(out: &mut SceneBuilder, stock: &Stock) {
    let [left, back, right, front] = SINK;
    // A ring with four corners each: rim outside, rim top, rim inside, floor's edge, floor's middle.
    let rings = [(-0.28, 0.012), (-0.25, 0.06), (-0.04, 0.06), (0.0, 0.0), (0.10, -1.9), (0.3, -2.1)];
    let basin = Part::grid(rings.len() + 1, 4, true, |row, column| {
        let Some(&(inset, y)) = rings.get(row) else {
            return DVec3::new((left + right) / 2.0, -2.15, (back + front) / 2.0);
        };
        let (x0, x1, z0, z1) = (left + inset, right - inset, back + inset, front - inset);
        let (x, z) = [(x0, z1), (x1, z1), (x1, z0), (x0, z0)][column];
        DVec3::new(x, y, z)
    });
    out.object("sink", &basin, stock.steel);
    chrome_tap(out, stock, DVec3::new((left + right) / 2.0, 0.0, back - 0.55));
}

fn shelf(out: &mut SceneBuilder, stock: &Stock) {
    out.object("shelf", &board([-2.6, SHELF - 0.26, BACK + 0.02], [19.0, SHELF, BACK + 1.75], 0.8), stock.oak);
    for (i, x) in [-1.6, 5.2, 11.8, 18.2].into_iter().enumerate() {
        let path = [
            DVec3::new(x, SHELF - 1.7, BACK + 0.06),
            DVec3::new(x, SHELF - 0.34, BACK + 0.06),
            DVec3::new(x, SHELF - 0.34, BACK + 1.5),
        ];
        let mut part = tube::rod(&tube::rounded(&path, 0.15, 4), 0.07, 10);
        let brace = [DVec3::new(x, SHELF - 1.6, BACK + 0.1), DVec3::new(x, SHELF - 0.36, BACK + 1.3)];
        part = part.with(tube::rod(&brace, 0.05, 10));
        out.object(&format!("bracket {}", i + 1), &part, stock.iron);
    }
}

/// A round seat on four legs with a ring.
fn stool(out: &mut SceneBuilder, stock: &Stock, foot: DVec3) {
    let knots = [c(0.0, 5.5), c(1.2, 5.5), s(1.45, 5.6), s(1.5, 5.75), s(1.4, 5.9), s(0.7, 5.86), s(0.0, 5.84)];
    let seat = lathe(&sample(&knots, 0.2), 40).planar_uv(DVec2::ZERO, 6.0);
    out.object("stool", &seat.at(foot.x, foot.y, foot.z), stock.oak);
    for i in 0..4 {
        let (sin, cos) = crate::modelling::part::sin_cos(0.785 + 1.571 * f64::from(i));
        let leg = [foot + DVec3::new(cos * 0.8, 5.52, sin * 0.8), foot + DVec3::new(cos * 1.5, 0.0, sin * 1.5)];
        out.extend(&tube::rod(&leg, 0.1, 10), stock.iron);
    }
    let circle: Vec<DVec2> = (0..=8)
        .map(|i| {
            let (sin, cos) = crate::modelling::part::sin_cos(std::f64::consts::TAU * f64::from(i % 8) / 8.0);
            DVec2::new(1.24 + cos * 0.07, 2.0 + sin * 0.07)
        })
        .collect();
    out.extend(&lathe(&circle, 32).at(foot.x, foot.y, foot.z), stock.iron);
}
