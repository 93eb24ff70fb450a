//! What the farm is made of, and the textures of it.

use glam::{DVec2, DVec3};

use crate::{
    builtin::provence::land::smooth,
    modelling::{SceneBuilder, builder, paint},
    scene::{Material, Texture},
};

/// Indices of the materials.
#[derive(Clone, Copy, Debug)]
pub struct Materials {
    /// Rubble walls.
    pub stone: u32,
    /// Dressed stone.
    pub dressed: u32,
    /// Field stones.
    pub rock: u32,
    /// Roof deck between the tiles.
    pub mortar: u32,
    /// Roof tiles.
    pub tile: u32,
    /// Window panes.
    pub pane: u32,
    /// Window bars.
    pub sash: u32,
    /// Shutters.
    pub shutter: u32,
    /// Doors.
    pub door: u32,
    /// Curtains.
    pub curtain: u32,
    /// The room behind a window.
    pub room: u32,
    /// Water.
    pub water: u32,
    /// Bottom of the pool.
    pub pebbles: u32,
    /// Lavender; `v` from stalk to flower.
    pub lavender: u32,
    /// Cypress.
    pub cypress: u32,
    /// Olive leaves.
    pub olive: u32,
    /// Bark.
    pub bark: u32,
    /// Broad-leaved trees and bushes.
    pub leaf: u32,
    /// Grass; `v` from root to tip.
    pub grass: u32,
    /// Gravel of the court.
    pub court: u32,
    /// Flagstones.
    pub paving: u32,
    /// Glazed pots.
    pub pot: u32,
    /// Poppies.
    pub poppy: u32,
}

/// Makes all materials.
pub fn add(out: &mut SceneBuilder) -> Materials {
    Materials {
        stone: textured(out, "rubble", rubble()),
        dressed: textured(out, "dressed stone", speckled("dressed stone", [0.62, 0.53, 0.39], 0.35, 11)),
        rock: textured(out, "field stone", palette("field stone", [0.50, 0.44, 0.35], [0.62, 0.57, 0.47], 0.35)),
        mortar: textured(out, "mortar", speckled("mortar", [0.36, 0.20, 0.12], 0.4, 12)),
        tile: textured(out, "tile", palette("tile", [0.52, 0.22, 0.11], [0.66, 0.38, 0.21], 0.55)),
        lavender: textured(out, "lavender", lavender()),
        cypress: textured(out, "cypress", palette("cypress", [0.030, 0.060, 0.022], [0.075, 0.115, 0.035], 0.4)),
        olive: textured(out, "olive", palette("olive", [0.13, 0.17, 0.085], [0.33, 0.37, 0.24], 0.5)),
        leaf: textured(out, "leaf", palette("leaf", [0.07, 0.11, 0.025], [0.19, 0.22, 0.06], 0.5)),
        grass: textured(out, "grass", palette("grass", [0.17, 0.18, 0.05], [0.50, 0.42, 0.17], 0.5)),
        bark: textured(out, "bark", speckled("bark", [0.20, 0.155, 0.115], 0.9, 13)),
        pebbles: textured(out, "pebbles", speckled("pebbles", [0.42, 0.46, 0.40], 0.8, 14)),
        court: textured(out, "court", court()),
        paving: textured(out, "paving", paving()),
        pot: glazed(out),
        pane: out.material(builder::glass("pane", [0.97, 0.985, 0.98], 1.5)),
        water: out.material(builder::glass("water", [0.86, 0.95, 0.94], 1.33)),
        sash: out.material(builder::matte("sash", [0.62, 0.60, 0.55])),
        shutter: out.material(builder::matte("shutter", [0.22, 0.33, 0.46])),
        door: out.material(builder::matte("door", [0.16, 0.26, 0.36])),
        curtain: out.material(builder::matte("curtain", [0.72, 0.66, 0.55])),
        room: out.material(builder::matte("room", [0.11, 0.085, 0.06])),
        poppy: out.material(builder::matte("poppy", [0.72, 0.05, 0.02])),
    }
}

/// A dull material with a texture.
pub fn textured(out: &mut SceneBuilder, name: &str, texture: Texture) -> u32 {
    let map = out.texture(texture);
    out.material(Material { diffuse_map: Some(map), ..builder::matte(name, [1.0; 3]) })
}

fn mix(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a + (b - a) * t.clamp(0.0, 1.0)
}

/// Pottery under a honey glaze that runs in green streaks, as in Anduze.
fn glazed(out: &mut SceneBuilder) -> u32 {
    let map = out.texture(paint::paint("glaze", 256, |u, v| {
        let streak = paint::noise(u * 24.0, v * 2.0, 22);
        let honey = DVec3::new(0.52, 0.24, 0.06) * (0.75 + 0.5 * paint::wrapped(u, v, 20, 23));
        mix(honey, DVec3::new(0.16, 0.22, 0.06), 0.8 * smooth(0.55, 0.85, streak))
    }));
    out.material(Material { diffuse_map: Some(map), ..builder::polished("glaze", [1.0; 3], 0.06, 180) })
}

/// Colours to pick from: `u` picks a shade at random, `v` runs from `low` to `high`.
fn palette(name: &str, low: [f64; 3], high: [f64; 3], spread: f64) -> Texture {
    paint::paint(name, 64, |u, v| {
        let shade = 1.0 + spread * (paint::noise(u * 16.0, 0.5, 71) - 0.5);
        let warm = 0.12 * (paint::noise(u * 16.0, 4.5, 72) - 0.5);
        // The ends repeat, so that a shift in `v` does not wrap from top to bottom.
        let colour = mix(DVec3::from(low), DVec3::from(high), smooth(0.1, 0.9, v));
        colour * shade * DVec3::new(1.0 + warm, 1.0, 1.0 - warm)
    })
}

/// Lavender from green stalk to violet flower; `u` picks the shade of the bush.
fn lavender() -> Texture {
    paint::paint("lavender", 64, |u, v| {
        let shade = 0.78 + 0.44 * paint::noise(u * 16.0, 0.5, 73);
        let red = 1.0 + 0.35 * (paint::noise(u * 16.0, 7.5, 74) - 0.5);
        let stalk = DVec3::new(0.13, 0.165, 0.075);
        let deep = DVec3::new(0.20, 0.10, 0.42);
        let pale = DVec3::new(0.47, 0.31, 0.75);
        let flower = mix(deep, pale, smooth(0.55, 0.95, v));
        mix(stalk, flower * DVec3::new(red, 1.0, 1.0), smooth(0.3, 0.5, v)) * shade
    })
}

/// A stone surface of one colour with fine and broad spots.
fn speckled(name: &str, colour: [f64; 3], contrast: f64, seed: u32) -> Texture {
    paint::paint(name, 256, |u, v| {
        let spot = paint::cloud(u * 40.0, v * 40.0, 3, seed);
        let broad = paint::cloud(u * 5.0, v * 5.0, 2, seed + 50);
        DVec3::from(colour) * (1.0 + contrast * (0.6 * spot + 0.4 * broad - 0.5))
    })
}

/// Fine pale gravel; repeats.
fn court() -> Texture {
    paint::paint("court", 512, |u, v| {
        let (fine, broad) = (paint::wrapped(u, v, 110, 16), paint::wrapped(u, v, 6, 17));
        DVec3::new(0.60, 0.51, 0.38) * (0.55 + 0.62 * fine + 0.28 * broad)
    })
}

/// Flagstones of uneven shape with earth between; repeats.
fn paving() -> Texture {
    const CELLS: f64 = 7.0;
    paint::paint("paving", 512, |u, v| {
        let p = DVec2::new(u, v) * CELLS;
        let cell = DVec2::new(libm::floor(p.x), libm::floor(p.y));
        // The nearest and the second nearest stone: the joint runs where they are equally far.
        let (mut near, mut next, mut tone) = (f64::MAX, f64::MAX, 0.0);
        for k in 0..25 {
            let c = cell + DVec2::new(f64::from(k % 5) - 2.0, f64::from(k / 5) - 2.0);
            let chance = |seed: u32| paint::noise((c.x + CELLS) % CELLS * 3.0, (c.y + CELLS) % CELLS * 3.0, seed);
            let away = (c + DVec2::new(chance(18), chance(19)) * 0.8 + 0.1 - p).length();
            if away < near {
                (next, near, tone) = (near, away, chance(20));
            } else {
                next = next.min(away);
            }
        }
        let grain = 0.75 + 0.5 * paint::wrapped(u, v, 70, 21);
        let stone = mix(DVec3::new(0.46, 0.40, 0.31), DVec3::new(0.64, 0.57, 0.45), tone) * grain;
        mix(DVec3::new(0.25, 0.21, 0.12), stone, smooth(0.04, 0.11, next - near))
    })
}

/// Rubble masonry: rows of stones of uneven size in pale mortar; repeats.
fn rubble() -> Texture {
    const ROWS: f64 = 14.0;
    paint::paint("rubble", 1024, |u, v| {
        let bent = |s: f64, t: f64, seed: u32| 0.016 * (paint::cloud(s * 22.0, t * 22.0, 2, seed) - 0.5);
        let (x, y) = (u + bent(u, v, 81), (v + bent(u, v, 82)) * ROWS);
        let row = libm::floor(y);
        let chance = |k: f64, seed: u32| paint::noise(k * 3.0, (row + ROWS) % ROWS * 5.0, seed);
        // Stones of a row are cut at uneven places.
        let count = 6.0 + libm::floor(chance(0.0, 83) * 4.0);
        let s = x * count + chance(1.0, 84) * 3.0;
        let cut = |k: f64| k + 0.55 * (chance((k + count) % count + 7.0, 85) - 0.5);
        let mut k = libm::floor(s);
        if s < cut(k) {
            k -= 1.0;
        } else if s >= cut(k + 1.0) {
            k += 1.0;
        }
        let (left, right) = (cut(k), cut(k + 1.0));
        let gap = DVec2::new((s - left).min(right - s) / count * ROWS, (y - row).min(1.0 - (y - row)));
        let joint = smooth(0.03, 0.13, gap.min_element());
        let tone = chance((k + count) % count + 3.0, 86);
        let warm = chance((k + count) % count + 19.0, 87);
        let stone = mix(DVec3::new(0.46, 0.36, 0.24), DVec3::new(0.70, 0.60, 0.45), tone);
        let stone = mix(stone, DVec3::new(0.60, 0.42, 0.25), 0.6 * smooth(0.55, 0.9, warm));
        let grain = 0.78 + 0.44 * paint::cloud(u * 90.0, v * 90.0, 3, 88);
        mix(DVec3::new(0.50, 0.43, 0.33) * 0.82, stone * grain, joint)
    })
}
