//! Floor, walls, window and lamps of the laboratory, and the pictures painted on them.

use glam::{DVec2, DVec3};

use crate::{
    modelling::{Part, SceneBuilder, block, builder, paint},
    scene::{Material, Texture},
};

/// Height of the floor; bench tops are at y = 0.
pub const FLOOR: f64 = -9.0;
/// The plane of the back wall.
pub const BACK: f64 = -14.0;
const CEILING: f64 = 17.0;
const FRONT: f64 = 27.0;
const SIDE: f64 = 26.0;
/// The window's opening in the back wall: left, bottom, right, top.
pub const WINDOW: [f64; 4] = [-11.5, 2.4, -3.5, 13.0];
/// Height up to which the walls are tiled.
const TILED: f64 = 6.4;

/// Builds the room.
pub fn room(out: &mut SceneBuilder) {
    floor_and_ceiling(out);
    walls(out);
    window(out);
    outside(out);
    poster(out);
}

/// A rectangle whose texture repeats every `size` units.
fn papered(corner: DVec3, along: DVec3, up: DVec3, size: f64) -> Part {
    let mut part = block::rectangle(corner, along, up);
    let (w, h) = (along.length() / size, up.length() / size);
    part.uvs.iter_mut().for_each(|uv| *uv = DVec2::new(uv.x * w, uv.y * h));
    part
}

fn textured(out: &mut SceneBuilder, texture: Texture, material: Material) -> u32 {
    let map = out.texture(texture);
    out.material(Material { diffuse_map: Some(map), ..material })
}

fn floor_and_ceiling(out: &mut SceneBuilder) {
    let floor = textured(out, floor_tiles(), builder::polished("floor", [1.0; 3], 0.045, 120));
    let size = DVec3::new(2.0 * SIDE, FRONT - BACK, CEILING - FLOOR);
    let (x, z) = (DVec3::new(size.x, 0.0, 0.0), DVec3::new(0.0, 0.0, size.y));
    out.object("floor", &papered(DVec3::new(-SIDE, FLOOR, FRONT), x, -z, 12.0), floor);
    let white = out.material(builder::matte("ceiling", [0.72, 0.71, 0.68]));
    out.object("ceiling", &block::rectangle(DVec3::new(-SIDE, CEILING, BACK), x, z), white);
    let lamp = Material { emission: [1.0, 0.97, 0.9].into(), ..builder::matte("lamp", [0.0; 3]) };
    let lamp = out.material(lamp);
    for (i, at) in [-12.0, 0.0, 12.0].into_iter().enumerate() {
        let panel = block::block(DVec3::new(at - 3.5, CEILING - 0.3, 4.0), DVec3::new(at + 3.5, CEILING - 0.01, 6.0));
        out.object(&format!("lamp {}", i + 1), &panel, lamp);
    }
}

fn walls(out: &mut SceneBuilder) {
    let tiles = textured(out, wall_tiles(), builder::polished("wall tiles", [1.0; 3], 0.05, 160));
    let plaster = textured(out, plaster(), builder::matte("plaster", [1.0; 3]));
    let [left, bottom, right, top] = WINDOW;
    // The back wall in pieces round the window: from x to x, from y to y.
    let pieces = [
        (-SIDE, left, FLOOR, TILED, tiles),
        (left, right, FLOOR, bottom, tiles),
        (right, SIDE, FLOOR, TILED, tiles),
        (-SIDE, left, TILED, CEILING, plaster),
        (left, right, top, CEILING, plaster),
        (right, SIDE, TILED, CEILING, plaster),
    ];
    for (i, (x0, x1, y0, y1, material)) in pieces.into_iter().enumerate() {
        let corner = DVec3::new(x0, y0, BACK);
        let mut part = block::rectangle(corner, DVec3::new(x1 - x0, 0.0, 0.0), DVec3::new(0.0, y1 - y0, 0.0));
        // By position, so that the joints run on from piece to piece.
        part.uvs = part.positions.iter().map(|p| DVec2::new((p.x + SIDE) / 6.0, (p.y - TILED) / 6.0)).collect();
        if i == 0 { out.object("back wall", &part, material) } else { out.extend(&part, material) }
    }
    let depth = DVec3::new(0.0, 0.0, FRONT - BACK);
    for (name, corner, along) in
        [("left wall", DVec3::new(-SIDE, FLOOR, FRONT), -depth), ("right wall", DVec3::new(SIDE, FLOOR, BACK), depth)]
    {
        out.object(name, &papered(corner, along, DVec3::new(0.0, TILED - FLOOR, 0.0), 6.0), tiles);
        let corner = DVec3::new(corner.x, TILED, corner.z);
        out.extend(&papered(corner, along, DVec3::new(0.0, CEILING - TILED, 0.0), 6.0), plaster);
    }
    front_wall(out, plaster);
}

/// The wall behind the camera has three windows, which polished glass reflects.
fn front_wall(out: &mut SceneBuilder, plaster: u32) {
    let columns = [-SIDE, -21.0, -11.0, -5.0, 5.0, 11.0, 21.0, SIDE];
    let sheet = |x0: f64, x1: f64, y0: f64, y1: f64| {
        papered(DVec3::new(x1, y0, FRONT), DVec3::new(x0 - x1, 0.0, 0.0), DVec3::new(0.0, y1 - y0, 0.0), 6.0)
    };
    out.object("front wall", &sheet(-SIDE, SIDE, FLOOR, 1.0), plaster);
    out.extend(&sheet(-SIDE, SIDE, 14.0, CEILING), plaster);
    for pair in columns.chunks(2) {
        out.extend(&sheet(pair[0], pair[1], 1.0, 14.0), plaster);
    }
    let bar = out.material(builder::matte("window bars", [0.62, 0.61, 0.58]));
    out.object("front windows", &Part::default(), bar);
    for middle in [-16.0, 0.0, 16.0] {
        let (low, high) = (DVec3::new(middle - 0.2, 1.0, FRONT - 0.2), DVec3::new(middle + 0.2, 14.0, FRONT + 0.2));
        out.extend(&block::block(low, high), bar);
        let (low, high) = (DVec3::new(middle - 5.0, 7.8, FRONT - 0.1), DVec3::new(middle + 5.0, 8.2, FRONT + 0.1));
        out.extend(&block::block(low, high), bar);
    }
}

/// Reveal, frame, bars and sill of the window in the back wall.
fn window(out: &mut SceneBuilder) {
    let [left, bottom, right, top] = WINDOW;
    let white = out.material(builder::polished("window frame", [0.74, 0.73, 0.70], 0.04, 60));
    let beam = |x0: f64, x1: f64, y0: f64, y1: f64, z: f64| {
        block::bevelled(DVec3::new(x0, y0, BACK - 1.4), DVec3::new(x1, y1, BACK + z), 0.05)
    };
    out.object("window", &beam(left - 0.4, left + 0.12, bottom - 0.3, top + 0.3, 0.22), white);
    out.extend(&beam(right - 0.12, right + 0.4, bottom - 0.3, top + 0.3, 0.22), white);
    out.extend(&beam(left + 0.13, right - 0.13, top - 0.12, top + 0.3, 0.20), white);
    let middle = (left + right) / 2.0;
    out.extend(&beam(middle - 0.14, middle + 0.14, bottom + 0.13, top - 0.13, -0.9), white);
    let height = bottom + (top - bottom) * 0.62;
    out.extend(&beam(left + 0.13, middle - 0.15, height - 0.1, height + 0.1, -0.95), white);
    out.extend(&beam(middle + 0.15, right - 0.13, height - 0.1, height + 0.1, -0.95), white);
    let sill = DVec3::new(left - 0.7, bottom - 0.31, BACK - 1.4);
    out.extend(&block::bevelled(sill, DVec3::new(right + 0.7, bottom + 0.12, BACK + 0.8), 0.06), white);
}

/// Hills and trees in the haze, as far as the window shows them: silhouettes that shine by themselves, because the
/// lamps of the room do not reach them.
fn outside(out: &mut SceneBuilder) {
    let layers = [
        ("far hills", -70.0, 4.2, 4.0, 0.05, [0.34, 0.48, 0.56]),
        ("hills", -56.0, 2.9, 2.6, 0.11, [0.20, 0.33, 0.27]),
        ("trees", -44.0, 1.3, 2.4, 0.55, [0.09, 0.17, 0.07]),
    ];
    for (i, (name, z, height, swing, pitch, colour)) in layers.into_iter().enumerate() {
        let shine = out.material(Material { emission: colour.into(), ..builder::matte(name, [0.0; 3]) });
        let ridge = Part::grid(2, 121, false, |row, column| {
            let x = -75.0 + column as f64;
            let crest = height + swing * (paint::cloud(x * pitch + 40.0, 0.5, 3, 61 + i as u32 * 7) - 0.5) * 2.0;
            DVec3::new(x, if row == 0 { FLOOR } else { crest }, z)
        });
        out.object(name, &ridge, shine);
    }
}

/// A chart of the elements, as colours.
fn poster(out: &mut SceneBuilder) {
    let chart = textured(out, elements(), builder::matte("chart", [1.0; 3]));
    let frame = out.material(builder::polished("chart frame", [0.10, 0.06, 0.04], 0.04, 60));
    let (low, high) = (DVec3::new(6.2, 8.4, BACK + 0.01), DVec3::new(15.4, 13.6, BACK + 0.14));
    out.object("chart frame", &block::bevelled(low, high, 0.05), frame);
    let sheet =
        block::rectangle(DVec3::new(6.4, 8.6, BACK + 0.146), DVec3::new(8.8, 0.0, 0.0), DVec3::new(0.0, 4.8, 0.0));
    out.object("chart", &sheet, chart);
}

/// Floor: four by four tiles, sage and cream.
fn floor_tiles() -> Texture {
    paint::paint("floor tiles", 256, |u, v| {
        let (x, y) = (u * 4.0, v * 4.0);
        let (fx, fy) = (x - libm::floor(x), y - libm::floor(y));
        let sage = (libm::floor(x) + libm::floor(y)) % 2.0 != 0.0;
        let cloud = paint::cloud(u * 24.0, v * 24.0, 4, 21);
        let base = if sage { DVec3::new(0.16, 0.24, 0.20) } else { DVec3::new(0.52, 0.47, 0.37) };
        let joint = fx.min(1.0 - fx).min(fy).min(1.0 - fy);
        if joint < 0.015 { DVec3::new(0.2, 0.19, 0.17) } else { base * (0.75 + 0.5 * cloud) }
    })
}

/// Walls: glazed tiles in running bond, no two of one shade.
fn wall_tiles() -> Texture {
    paint::paint("wall tiles", 512, |u, v| {
        let row = libm::floor(v * 8.0);
        let x = u * 4.0 + if row % 2.0 == 0.0 { 0.0 } else { 0.5 };
        let (fx, fy) = (x - libm::floor(x), v * 8.0 - row);
        let shade = paint::noise(libm::floor(x) % 4.0 * 7.3 + 0.5, row * 5.1 + 0.5, 31);
        let glaze = paint::cloud(u * 12.0, v * 12.0, 3, 33);
        let joint = (fx.min(1.0 - fx) * 2.0).min(fy.min(1.0 - fy));
        let base = DVec3::new(0.25, 0.42, 0.40) * (0.80 + 0.25 * shade + 0.15 * glaze);
        if joint < 0.03 { DVec3::new(0.58, 0.57, 0.53) } else { base }
    })
}

/// Painted plaster.
fn plaster() -> Texture {
    paint::paint("plaster", 256, |u, v| {
        let cloud = paint::cloud(u * 6.0, v * 6.0, 5, 41);
        DVec3::new(0.62, 0.58, 0.50) * (0.92 + 0.16 * cloud)
    })
}

/// The long form of the periodic table: which of its 18 columns and 7 rows are filled, by family.
fn elements() -> Texture {
    const FAMILIES: [DVec3; 6] = [
        DVec3::new(0.75, 0.20, 0.16),
        DVec3::new(0.80, 0.46, 0.12),
        DVec3::new(0.20, 0.38, 0.62),
        DVec3::new(0.22, 0.50, 0.28),
        DVec3::new(0.78, 0.66, 0.22),
        DVec3::new(0.42, 0.28, 0.58),
    ];
    paint::paint("elements", 256, |u, v| {
        let paper = DVec3::new(0.80, 0.78, 0.71);
        let (x, y) = ((u - 0.05) / 0.9 * 18.0, (0.82 - v) / 0.66 * 7.0);
        let heading = v > 0.87 && v < 0.93 && u > 0.3 && u < 0.7;
        if heading {
            return DVec3::new(0.15, 0.18, 0.24);
        }
        if !(0.0..18.0).contains(&x) || !(0.0..7.0).contains(&y) {
            return paper;
        }
        let (column, row) = (libm::floor(x), libm::floor(y));
        let filled = match row as i32 {
            0 => column == 0.0 || column == 17.0,
            1 | 2 => !(2.0..=11.0).contains(&column),
            _ => true,
        };
        let (fx, fy) = (x - column, y - row);
        if !filled || fx.min(1.0 - fx).min(fy.min(1.0 - fy)) < 0.07 {
            return paper;
        }
        let family = match column as i32 {
            0 => 0,
            1 => 1,
            2..=11 => 2,
            12..=14 => 3,
            15 | 16 => 4,
            _ => 5,
        };
        let sign = fx > 0.3 && fx < 0.7 && fy > 0.35 && fy < 0.68;
        FAMILIES[family] * if sign { 0.35 } else { 1.0 }
    })
}
