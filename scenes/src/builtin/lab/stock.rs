//! The materials of the laboratory.

use glam::DVec3;

use crate::{
    modelling::{
        SceneBuilder,
        builder::{glass, matte, mirror, polished},
        paint,
    },
    scene::{Material, Texture},
};

/// Material indices.
#[derive(Clone, Copy, Debug)]
pub struct Stock {
    pub glass: u32,
    pub amber_glass: u32,
    /// Liquids from clear to violet, named in [`LIQUIDS`].
    pub liquids: [u32; 8],
    pub chrome: u32,
    pub steel: u32,
    pub iron: u32,
    pub brass: u32,
    pub cork: u32,
    pub rubber: u32,
    pub enamel: u32,
    pub porcelain: u32,
    pub paper: u32,
    /// The notebook's cover.
    pub cloth: u32,
    /// The pencil's paint.
    pub paint: u32,
    pub gauze: u32,
    pub oak: u32,
    pub dark_oak: u32,
    pub teak: u32,
    pub bench_tiles: u32,
}

/// Indices of [`Stock::liquids`].
pub const CLEAR: usize = 0;
pub const BLUE: usize = 1;
pub const GREEN: usize = 2;
pub const YELLOW: usize = 3;
pub const ORANGE: usize = 4;
pub const RED: usize = 5;
pub const PINK: usize = 6;
pub const VIOLET: usize = 7;

/// Name and tint per surface of each liquid. A ray that crosses a vessel is tinted twice.
const LIQUIDS: [(&str, [f32; 3]); 8] = [
    ("water", [0.95, 0.975, 0.98]),
    ("blue", [0.30, 0.60, 0.96]),
    ("green", [0.36, 0.86, 0.50]),
    ("yellow", [0.97, 0.86, 0.30]),
    ("orange", [0.97, 0.58, 0.20]),
    ("red", [0.92, 0.24, 0.22]),
    ("pink", [0.97, 0.60, 0.78]),
    ("violet", [0.62, 0.30, 0.86]),
];

/// Makes all materials.
pub fn stock(out: &mut SceneBuilder) -> Stock {
    let chrome = mirror("chrome", [0.04, 0.04, 0.045], [0.80, 0.81, 0.83], 600);
    let oak = wood(out, "oak", 512, 2.0, [0.20, 0.10, 0.04], [0.46, 0.27, 0.13], 0.03);
    let dark_oak = wood(out, "dark oak", 256, 2.0, [0.10, 0.05, 0.02], [0.24, 0.13, 0.06], 0.03);
    let teak = wood(out, "teak", 512, 5.0, [0.10, 0.045, 0.018], [0.30, 0.155, 0.07], 0.045);
    let tiles = textured(out, bench_tiles(), polished("bench tiles", [1.0; 3], 0.055, 240));
    let gauze = textured(out, gauze(), matte("gauze", [1.0; 3]));
    Stock {
        glass: out.material(glass("glass", [0.975, 0.985, 0.98], 1.5)),
        amber_glass: out.material(glass("amber glass", [0.80, 0.42, 0.13], 1.5)),
        liquids: LIQUIDS.map(|(name, tint)| out.material(glass(name, tint, 1.36))),
        chrome: out.material(chrome),
        steel: out.material(mirror("steel", [0.16, 0.16, 0.17], [0.42, 0.43, 0.44], 120)),
        iron: out.material(polished("iron", [0.035, 0.04, 0.045], 0.05, 60)),
        brass: out.material(mirror("brass", [0.16, 0.10, 0.03], [0.52, 0.38, 0.16], 160)),
        cork: out.material(matte("cork", [0.42, 0.26, 0.13])),
        rubber: out.material(polished("rubber", [0.46, 0.11, 0.05], 0.03, 40)),
        enamel: out.material(matte("enamel", [0.85, 0.85, 0.83])),
        porcelain: out.material(polished("porcelain", [0.70, 0.69, 0.66], 0.05, 240)),
        paper: out.material(matte("paper", [0.74, 0.72, 0.64])),
        cloth: out.material(polished("cloth", [0.035, 0.075, 0.16], 0.03, 30)),
        paint: out.material(polished("paint", [0.72, 0.42, 0.04], 0.05, 120)),
        gauze,
        oak,
        dark_oak,
        teak,
        bench_tiles: tiles,
    }
}

fn textured(out: &mut SceneBuilder, texture: Texture, material: Material) -> u32 {
    let map = out.texture(texture);
    out.material(Material { diffuse_map: Some(map), ..material })
}

fn wood(out: &mut SceneBuilder, name: &str, side: u32, planks: f64, dark: [f64; 3], pale: [f64; 3], f0: f32) -> u32 {
    let texture = paint::paint(name, side, |u, v| paint::wood(u, v, planks, dark.into(), pale.into()));
    textured(out, texture, polished(name, [1.0; 3], f0, 80))
}

/// The island's top: four by four pale tiles with grey joints, no two quite alike.
fn bench_tiles() -> Texture {
    paint::paint("bench tiles", 512, |u, v| {
        let (x, y) = (u * 4.0, v * 4.0);
        let (fx, fy) = (x - libm::floor(x), y - libm::floor(y));
        let shade = paint::noise(libm::floor(x) * 3.7 + 0.5, libm::floor(y) * 5.3 + 0.5, 51);
        let cloud = paint::cloud(u * 20.0, v * 20.0, 4, 53);
        let joint = fx.min(1.0 - fx).min(fy).min(1.0 - fy);
        if joint < 0.014 {
            return DVec3::new(0.17, 0.165, 0.155);
        }
        DVec3::new(0.50, 0.495, 0.46) * (0.84 + 0.12 * shade + 0.10 * cloud)
    })
}

/// Woven wire round a pale disc of ceramic; the texture covers one eighth of the disc's width.
fn gauze() -> Texture {
    paint::paint("gauze", 64, |u, v| {
        let wave = |t: f64| 0.5 + 0.5 * libm::cos(std::f64::consts::TAU * t * 4.0);
        let wire = wave(u).max(wave(v));
        DVec3::new(0.30, 0.30, 0.29) * (0.35 + 0.65 * wire)
    })
}
