//! `teapot`: Newell's teapot, glazed, beside a glass of tea on a polished tile table. 15,000 triangles.

mod newell;

use glam::{DVec2, DVec3, Vec3};

use crate::{
    camera,
    error::SceneError,
    modelling::{
        Part, SceneBuilder, backdrop, block, builder,
        lathe::{lathe, sphere},
        paint, patch,
        profile::{c, s, sample},
    },
    scene::{Camera, Scene, Texture},
};

/// Cells along each side of a patch.
const PATCH_CELLS: usize = 13;
/// How deep the tumbler stands in the table: on the very plane of the table top rounding would choose which of
/// the two a ray meets first.
const SUNK: f64 = 0.01;
/// Frames of the turn round the table.
const FRAMES: u32 = 120;

/// The scene with its orbit; frame 0 is the hero view.
pub fn scene() -> Result<Scene, SceneError> {
    let mut out = SceneBuilder::new("teapot");
    garden(&mut out);
    table(&mut out);
    pot(&mut out);
    glass_of_tea(&mut out);
    sugar(&mut out);
    out.point_light([7.5, 10.0, 4.0], [0.92, 0.86, 0.76]);
    out.point_light([-8.0, 6.0, 7.5], [0.22, 0.26, 0.32]);
    out.sky([0.22, 0.36, 0.60], [0.70, 0.68, 0.62], [0.24, 0.18, 0.14], 0.42);
    let hero =
        Camera { eye: Vec3::new(1.4, 5.0, 11.2), target: Vec3::new(0.75, 0.84, 0.0), up: Vec3::Y, vfov_deg: 27.0 };
    out.finish(camera::orbit(hero, FRAMES, 0.6))
}

fn pot(out: &mut SceneBuilder) {
    let glaze = out.material(builder::polished("glaze", [0.035, 0.235, 0.27], 0.055, 260));
    let join = |patches: &[patch::Patch]| {
        patches.iter().map(|p| patch::tessellate(p, PATCH_CELLS, PATCH_CELLS)).fold(Part::default(), Part::with)
    };
    let place = |part: Part| part.turned(24.0).at(-0.85, 0.0, -0.55);
    let [body, handle, spout] = newell::patches();
    out.object("teapot", &place(join(&body)), glaze);
    // The original is open between lid and rim; this ring keeps rays out of the empty inside.
    let groove: Vec<DVec2> = vec![DVec2::new(1.42, 2.4), DVec2::new(1.28, 2.4)];
    out.extend(&place(lathe(&groove, 4 * PATCH_CELLS)), glaze);
    out.extend(&place(join(&handle)), glaze);
    out.extend(&place(join(&spout)), glaze);
}

fn glass_of_tea(out: &mut SceneBuilder) {
    let glass = out.material(builder::glass("glass", [0.975, 0.985, 0.98], 1.5));
    let tea = out.material(builder::glass("tea", [0.93, 0.62, 0.24], 1.33));
    out.object("tumbler", &tumbler().at(3.15, -SUNK, 1.55), glass);
    out.object("tea", &liquid().at(3.15, -SUNK, 1.55), tea);
    out.object("marble", &sphere(DVec3::new(1.28, 0.36, 2.9), 0.36, 24).crease(60.0), glass);
}

/// A tumbler: outside up, over the rim, inside down; a closed solid.
fn tumbler() -> Part {
    let knots = [
        c(0.0, 0.0),
        c(0.64, 0.0),
        s(0.70, 0.05),
        s(0.78, 0.8),
        s(0.90, 1.98),
        s(0.875, 2.03),
        s(0.845, 1.98),
        s(0.72, 0.8),
        s(0.64, 0.26),
        s(0.56, 0.20),
        c(0.0, 0.20),
    ];
    lathe(&sample(&knots, 0.22), 42)
}

/// Tea, a hair's breadth inside the glass.
fn liquid() -> Part {
    let knots = [c(0.0, 0.215), s(0.55, 0.215), s(0.62, 0.27), s(0.70, 0.8), c(0.765, 1.35), c(0.0, 1.35)];
    lathe(&sample(&knots, 0.5), 36)
}

fn sugar(out: &mut SceneBuilder) {
    let sugar = out.material(builder::matte("sugar", [0.82, 0.80, 0.75]));
    for (name, x, y, z, turn) in
        [("sugar 1", 2.35, 0.0, 3.2, 14.0), ("sugar 2", 2.95, 0.0, 3.42, -22.0), ("sugar 3", 2.62, 0.42, 3.3, 38.0)]
    {
        let cube = block::bevelled(DVec3::new(-0.21, 0.0, -0.21), DVec3::new(0.21, 0.42, 0.21), 0.03);
        out.object(name, &cube.turned(turn).at(x, y, z), sugar);
    }
}

fn table(out: &mut SceneBuilder) {
    let tiles = out.texture(tiles());
    let mut top = builder::mirror("tiles", [1.0; 3], [0.16; 3], 300);
    top.diffuse_map = Some(tiles);
    let top = out.material(top);
    let edge = out.material(builder::polished("edge", [0.20, 0.09, 0.04], 0.05, 80));
    let disc = lathe(&[DVec2::new(8.2, 0.0), DVec2::new(0.0, 0.0)], 64).planar_uv(DVec2::ZERO, 4.0);
    out.object("table", &disc, top);
    let rim = [c(0.0, -0.6), c(7.6, -0.6), s(8.3, -0.42), s(8.42, -0.15), s(8.34, 0.02), c(8.2, 0.0)];
    out.extend(&lathe(&sample(&rim, 0.3), 64), edge);
}

/// A garden far out of focus, all round the table.
fn garden(out: &mut SceneBuilder) {
    let map = out.texture(paint::paint("garden", 512, bokeh()));
    let mut green = builder::matte("garden", [1.0; 3]);
    green.diffuse_map = Some(map);
    let green = out.material(green);
    out.object("garden", &backdrop::ring(42.0, [-16.0, 30.0], 48, DVec2::new(4.0, 1.0)), green);
}

/// A disc of light on the garden's texture: place and radius in scene units, colour, strength.
struct Disc {
    place: DVec2,
    radius: f64,
    colour: DVec3,
    strength: f64,
}

/// Soft leaves with discs of light, repeating along `u`.
fn bokeh() -> impl Fn(f64, f64) -> DVec3 {
    // One repeat of the texture on the wall; discs must come out round.
    let size = DVec2::new(66.0, 46.0);
    let disc = |i: u32| {
        let random = |k: u32| paint::noise(f64::from(i) * 5.0 + 0.5, f64::from(k) * 3.0 + 0.5, 27);
        Disc {
            place: DVec2::new(random(1), random(2)) * size,
            radius: 0.45 + 1.4 * random(3) * random(3),
            colour: DVec3::new(0.75, 0.72, 0.30).lerp(DVec3::new(0.42, 0.58, 0.22), random(4)),
            strength: 0.10 + 0.35 * random(5),
        }
    };
    let discs: Vec<Disc> = (0..230).map(disc).collect();
    let (dark, pale) = (DVec3::new(0.030, 0.065, 0.028), DVec3::new(0.26, 0.34, 0.11));
    move |u, v| {
        // The last fifth passes over into what lies left of the beginning, so that the ends meet.
        let leaves_at = |u: f64| paint::cloud(u * 14.0 + 40.0, v * 9.7, 3, 44);
        let over = ((u - 0.8) / 0.2).clamp(0.0, 1.0);
        let leaves = leaves_at(u) * (1.0 - over) + leaves_at(u - 1.0) * over;
        let mut colour = dark.lerp(pale, ((leaves - 0.32) * 2.1 + 0.2 * (0.4 - v)).clamp(0.0, 1.0));
        for disc in &discs {
            let across = (u * size.x - disc.place.x).abs();
            let away = DVec2::new(across.min(size.x - across), v * size.y - disc.place.y).length();
            let inside = ((disc.radius - away) / 0.22).clamp(0.0, 1.0);
            colour = colour.lerp(disc.colour, inside * disc.strength);
        }
        colour
    }
}

/// Two by two tiles of pale and dark stone with joints; repeats.
fn tiles() -> Texture {
    paint::paint("tiles", 512, |u, v| {
        let (x, y) = (u * 2.0, v * 2.0);
        let (fx, fy) = (x - libm::floor(x), y - libm::floor(y));
        let dark = (libm::floor(x) + libm::floor(y)) % 2.0 != 0.0;
        let vein = paint::cloud(u * 9.0 + 3.0 * paint::cloud(u * 4.0, v * 4.0, 3, 1), v * 9.0, 4, 2);
        let stone = if dark {
            DVec3::new(0.10, 0.062, 0.045) * (0.6 + 0.8 * vein)
        } else {
            DVec3::new(0.66, 0.58, 0.47) * (0.78 + 0.4 * vein)
        };
        let joint = fx.min(1.0 - fx).min(fy).min(1.0 - fy);
        if joint < 0.012 { DVec3::new(0.30, 0.27, 0.23) } else { stone }
    })
}
