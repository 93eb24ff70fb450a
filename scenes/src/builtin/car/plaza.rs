//! The place round `car`: a round court with wet stone, a colonnade, a wall and cypresses.

use glam::{DVec2, DVec3};

use crate::{
    modelling::{
        Part, SceneBuilder, backdrop, block, builder,
        lathe::{lathe, lathe_with},
        paint,
        part::sin_cos,
        profile::{Knot, c, s, sample},
    },
    scene::Texture,
};

/// Columns, and the radius they stand on.
const COLUMNS: usize = 16;
const RADIUS: f64 = 10.5;
/// Radius of the wall behind them.
const WALL: f64 = 13.6;
const CYPRESSES: usize = 17;

/// Adds everything that is not the car.
pub fn build(out: &mut SceneBuilder) {
    ground(out);
    colonnade(out);
    wall(out);
    cypresses(out);
    hills(out);
}

fn ground(out: &mut SceneBuilder) {
    let slabs = out.texture(slabs());
    let mut wet = builder::mirror("wet stone", [1.0; 3], [0.17, 0.17, 0.175], 220);
    wet.diffuse_map = Some(slabs);
    let wet = out.material(wet);
    let disc = lathe(&[DVec2::new(WALL + 0.2, 0.0), DVec2::new(0.0, 0.0)], 64).planar_uv(DVec2::ZERO, 4.8);
    out.object("court", &disc, wet);
}

/// Six by six slabs of stone of different shades with joints; repeats.
fn slabs() -> Texture {
    paint::paint("slabs", 1024, |u, v| {
        let (x, y) = (u * 6.0, v * 6.0);
        // Every second row is shifted by half a slab.
        let x = x + if libm::floor(y) % 2.0 == 0.0 { 0.0 } else { 0.5 };
        let (fx, fy) = (x - libm::floor(x), y - libm::floor(y));
        let shade = paint::noise(libm::floor(x).rem_euclid(6.0) * 7.3 + 0.5, libm::floor(y) * 5.1 + 0.5, 9);
        let grain = paint::cloud(u * 40.0, v * 40.0, 4, 21);
        let stain = paint::cloud(u * 7.0, v * 7.0, 3, 4);
        let stone = DVec3::new(0.34, 0.30, 0.255) * (0.62 + 0.5 * shade) * (0.72 + 0.34 * grain + 0.28 * stain);
        let joint = fx.min(1.0 - fx).min(fy).min(1.0 - fy);
        let depth = ((joint - 0.008) / 0.012).clamp(0.0, 1.0);
        stone * (0.38 + 0.62 * depth)
    })
}

fn colonnade(out: &mut SceneBuilder) {
    let stone = out.material(builder::matte("limestone", [0.66, 0.585, 0.475]));
    let knots = [
        c(0.44, 0.0),
        c(0.44, 0.14),
        s(0.41, 0.15),
        s(0.43, 0.22),
        s(0.36, 0.28),
        s(0.325, 0.36),
        s(0.325, 1.4),
        s(0.28, 3.35),
        c(0.28, 3.36),
        c(0.32, 3.40),
        c(0.29, 3.44),
        s(0.29, 3.52),
        s(0.42, 3.68),
        c(0.42, 3.70),
    ];
    let profile = sample(&knots, 1.3);
    let column = lathe(&profile, 15);
    let plinth = |y: f64| block::block(DVec3::new(-0.47, y, -0.47), DVec3::new(0.47, y + 0.16, 0.47));
    let whole = column.at(0.0, 0.14, 0.0).with(plinth(0.0)).with(plinth(3.82));
    for i in 0..COLUMNS {
        let degrees = 360.0 * (i as f64 + 0.5) / COLUMNS as f64;
        out.object(&format!("column {i}"), &whole.clone().at(0.0, 0.0, RADIUS).turned(degrees), stone);
    }
    let beam = [
        c(RADIUS - 0.42, 3.98),
        c(RADIUS - 0.42, 4.24),
        c(RADIUS - 0.46, 4.24),
        c(RADIUS - 0.46, 4.50),
        c(RADIUS - 0.50, 4.50),
        s(RADIUS - 0.54, 4.60),
        s(RADIUS - 0.72, 4.70),
        c(RADIUS - 0.74, 4.78),
        c(RADIUS + 0.5, 4.82),
        c(RADIUS + 0.5, 3.98),
        c(RADIUS - 0.42, 3.98),
    ];
    out.object("entablature", &ring(&beam), stone);
}

/// A ring with a profile that looks inwards.
fn ring(knots: &[Knot]) -> Part {
    lathe(&sample(knots, 0.2), 64).flipped()
}

fn wall(out: &mut SceneBuilder) {
    let map = out.texture(ashlar());
    let mut plaster = builder::matte("ashlar", [1.0; 3]);
    plaster.diffuse_map = Some(map);
    let plaster = out.material(plaster);
    let coping = out.material(builder::matte("coping", [0.58, 0.50, 0.40]));
    let height = 1.25;
    let face = backdrop::ring(WALL, [0.0, height], 72, DVec2::new(30.0, 1.0));
    out.object("wall", &face, plaster);
    let top =
        [c(WALL + 0.5, 1.1), c(WALL + 0.5, 1.42), c(WALL - 0.12, 1.42), c(WALL - 0.12, 1.25), c(WALL + 0.01, 1.25)];
    out.extend(&lathe(&sample(&top, 1.0), 72), coping);
}

/// Courses of dressed stone; one repeat is a pier's width and the whole height.
fn ashlar() -> Texture {
    paint::paint("ashlar", 512, |u, v| {
        let y = v * 3.0;
        let x = u * 3.0 + if libm::floor(y) % 2.0 == 0.0 { 0.0 } else { 0.5 };
        let (fx, fy) = (x - libm::floor(x), y - libm::floor(y));
        let shade = paint::noise(libm::floor(x).rem_euclid(3.0) * 3.7 + 0.5, libm::floor(y) * 4.9 + 0.5, 5);
        let grain = paint::cloud(u * 24.0, v * 24.0, 4, 33);
        let stone = DVec3::new(0.60, 0.47, 0.335) * (0.70 + 0.35 * shade) * (0.78 + 0.4 * grain);
        let joint = (fx.min(1.0 - fx) * 2.0).min(fy.min(1.0 - fy));
        stone * (0.55 + 0.45 * (joint / 0.05).clamp(0.0, 1.0))
    })
}

/// Wooded hills all round, far away.
fn hills(out: &mut SceneBuilder) {
    let map = out.texture(paint::paint("woods", 512, |u, v| {
        let wood = paint::cloud(u * 170.0, v * 10.0, 3, 61);
        let cleared = ((paint::cloud(u * 26.0, v * 3.0, 3, 62) - 0.52) * 14.0).clamp(0.0, 1.0);
        let trees = DVec3::new(0.075, 0.105, 0.055) * (0.45 + 1.1 * wood);
        let meadow = DVec3::new(0.27, 0.255, 0.13) * (0.8 + 0.3 * wood);
        // Higher is farther and bluer.
        trees.lerp(meadow, cleared).lerp(DVec3::new(0.20, 0.245, 0.285), 0.15 + 0.5 * v)
    }));
    let mut woods = builder::matte("woods", [1.0; 3]);
    woods.diffuse_map = Some(map);
    let woods = out.material(woods);
    let ring = lathe_with(3, 72, |row, _, column| {
        let angle = std::f64::consts::TAU * column as f64 / 72.0;
        let (sin, cos) = sin_cos(angle);
        let crest = 1.0 + 11.0 * paint::cloud(3.0 + 2.2 * sin, 7.0 + 2.2 * cos, 3, 15);
        DVec2::new(70.0 + 9.0 * row as f64, crest * [0.0, 0.62, 1.0][row])
    });
    out.object("hills", &there_and_back(ring.flipped()), woods);
}

fn cypresses(out: &mut SceneBuilder) {
    let map = out.texture(paint::paint("cypress", 256, |u, v| {
        let leaf = paint::cloud(u * 26.0, v * 40.0, 4, 8);
        DVec3::new(0.035, 0.085, 0.028) * (0.35 + 1.5 * leaf)
    }));
    let mut green = builder::matte("cypress", [1.0; 3]);
    green.diffuse_map = Some(map);
    let green = out.material(green);
    for i in 0..CYPRESSES {
        let random = |k: f64| paint::noise(i as f64 * 3.7 + 0.5, k * 5.3 + 0.5, 77);
        let height = 6.0 + 3.2 * random(1.0);
        let (sin, cos) = sin_cos(std::f64::consts::TAU * (i as f64 + 0.3 + 0.55 * random(2.0)) / CYPRESSES as f64);
        let radius = WALL + 2.4 + 2.2 * random(3.0);
        let rows = 11;
        let tree = lathe_with(rows, 10, |row, angle, column| {
            let h = row as f64 / (rows - 1) as f64;
            let ragged = 0.72 + 0.5 * paint::noise(column as f64 * 1.7 + 0.5, row as f64 * 1.3 + i as f64 * 9.1, 3);
            let width = 0.95 * libm::pow(h.max(0.0), 0.35) * libm::pow(1.0 - h, 0.62) * ragged;
            DVec2::new(if row == 0 || row + 1 == rows { 0.0 } else { width }, h * height + 0.02 * libm::sin(angle))
        });
        out.object(
            &format!("cypress {i}"),
            &there_and_back(tree).crease(70.0).at(radius * sin, 0.0, radius * cos),
            green,
        );
    }
}

/// Lets a texture run half way round a turned part and back, so that it has no seam.
fn there_and_back(mut part: Part) -> Part {
    part.uvs.iter_mut().for_each(|uv| uv.x = 1.0 - (1.0 - 2.0 * uv.x).abs());
    part
}
