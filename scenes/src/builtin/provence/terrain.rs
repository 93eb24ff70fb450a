//! Ground: one grid, fine near the farm and coarse towards the mountains, and the road on it.

use glam::{DVec2, DVec3};

use crate::{
    builtin::provence::{
        land::{self, FIELD},
        materials::textured,
    },
    modelling::{Part, SceneBuilder, paint},
    scene::Texture,
};

/// Half the side of the world.
const WORLD: f64 = 900.0;
/// Distance over which the world's texture is fine.
const FINE: f64 = 90.0;
/// How far from the farm the near ground reaches.
const NEAR: f64 = 62.0;
/// Middle of the fine part.
const MIDDLE: DVec2 = DVec2::new(0.0, 25.0);

/// Adds ground and road.
pub fn add(out: &mut SceneBuilder) {
    let land = textured(out, "land", world());
    let near = textured(out, "meadow", meadow());
    let soil = textured(out, "earth", earth());
    let track = textured(out, "road", gravel());
    let (far, meadow, field) = grid();
    out.object("land", &far, land);
    out.extend(&meadow, near);
    out.object("field", &field, soil);
    out.object("road", &ribbon(), track);
}

/// Grid lines: `step` apart from `low` to `high`, `fine` apart in `dense`, growing outside.
fn lines(low: f64, high: f64, step: f64, dense: (f64, f64), fine: f64) -> Vec<f64> {
    let mut inner = vec![low];
    while let Some(&last) = inner.last().filter(|l| **l < high - 1e-6) {
        let next = last + if last >= dense.0 && last < dense.1 { fine } else { step };
        inner.push(if next > high - 0.3 * step { high } else { next });
    }
    let outward = |from: f64| {
        let mut steps = Vec::new();
        let (mut at, mut stride) = (from, step);
        while at < WORLD {
            stride *= 1.088;
            at += stride;
            steps.push(at);
        }
        steps
    };
    let mut all: Vec<f64> = outward(-low).into_iter().rev().map(|v| -v).collect();
    all.extend(inner);
    all.extend(outward(high));
    all
}

/// The far ground, the near ground and the field. The pool is cut out along the middle of its rim.
fn grid() -> (Part, Part, Part) {
    let [west, north, east, south] = FIELD;
    let mut xs = lines(west - 14.0, 48.5, 1.4, (1.0, 16.0), 0.625);
    let mut zs = lines(-36.0, south + 10.0, 1.4, (11.5, 21.5), 0.625);
    // The field's borders lie on grid lines.
    for (values, borders) in [(&mut xs, [west, east]), (&mut zs, [north, south])] {
        for border in borders {
            if let Some(nearest) =
                values.iter_mut().min_by(|a, b| (**a - border).abs().total_cmp(&(**b - border).abs()))
            {
                *nearest = border;
            }
        }
    }
    let columns = xs.len();
    let mut land = Part::grid(zs.len(), columns, false, |row, column| {
        // Rows run up the page, that is to the north, so that the front is above.
        let (x, z) = (xs[column], zs[zs.len() - 1 - row]);
        let p = DVec2::new(x, z);
        let r = land::pool_radius(x, z);
        let p = if r < 1.0 && r > 0.5 { land::POOL + (p - land::POOL) / r } else { p };
        land::ground(p.x, p.y)
    });
    let cut = |part: &Part, t: &[u32; 3]| {
        t.iter().all(|v| {
            let p = part.positions[*v as usize];
            land::pool_radius(p.x, p.z) < 1.0 + 1e-9
        })
    };
    let in_field = |part: &Part, t: &[u32; 3]| {
        let middle = t.iter().map(|v| part.positions[*v as usize]).sum::<DVec3>() / 3.0;
        land::in_field(middle.x, middle.z, 0.0)
    };
    let (field_triangles, rest): (Vec<_>, Vec<_>) = land.triangles.iter().partition(|t| in_field(&land, t));
    let mut field = land.clone();
    field.triangles = field_triangles;
    let is_near = |t: &[u32; 3]| t.iter().all(|v| from_farm(land.positions[*v as usize]) < NEAR);
    let (near, far): (Vec<_>, Vec<_>) = rest.into_iter().filter(|t| !cut(&land, t)).partition(is_near);
    let mut meadow = land.clone();
    meadow.triangles = near;
    meadow.uvs = meadow.positions.iter().map(|p| meadow_uv(p.x, p.z)).collect();
    land.triangles = far;
    land.uvs = land.positions.iter().map(|p| world_uv(p.x, p.z)).collect();
    let field = Part { uvs: field.positions.iter().map(|p| DVec2::new(p.x / 6.4, -p.z / 6.4)).collect(), ..field };
    (land.crease(80.0), meadow.crease(80.0), field.crease(80.0))
}

/// Distance from the middle of the farm, seen from above.
fn from_farm(p: DVec3) -> f64 {
    DVec2::new(p.x - 4.0, p.z - 26.0).length()
}

/// Texture coordinates of the meadow, bent so that its repetition makes no rows.
fn meadow_uv(x: f64, z: f64) -> DVec2 {
    let bend = |seed: u32| 5.0 * paint::noise(x / 13.0, z / 13.0, seed);
    DVec2::new(x + bend(35), -z + bend(36)) / 11.0
}

/// Dry grass from near: tufts, bare patches, a little green; repeats.
fn meadow() -> Texture {
    paint::paint("meadow", 1024, |u, v| {
        let (fine, patches) = (paint::wrapped(u, v, 150, 37), paint::wrapped(u, v, 9, 38));
        let blend = paint::wrapped(u, v, 40, 39);
        let green = DVec3::new(0.17, 0.20, 0.065);
        let dry = DVec3::new(0.40, 0.32, 0.15);
        let bare = DVec3::new(0.42, 0.31, 0.20);
        let grass = green + (dry - green) * land::smooth(0.30, 0.68, 0.5 * blend + 0.5 * patches);
        let colour = grass + (bare - grass) * (0.8 * land::smooth(0.62, 0.74, 0.3 * blend + 0.7 * patches));
        colour * (0.45 + 1.05 * fine)
    })
}

/// Texture coordinates of the world's map: fine in the middle, coarse outside.
fn world_uv(x: f64, z: f64) -> DVec2 {
    let spread = |v: f64| 0.5 + 0.5 * libm::asinh(v / FINE) / libm::asinh(WORLD * 1.1 / FINE);
    DVec2::new(spread(x - MIDDLE.x), 1.0 - spread(z - MIDDLE.y))
}

/// The place of a texture coordinate.
fn place(u: f64, v: f64) -> DVec2 {
    let back = |t: f64| FINE * libm::sinh((2.0 * t - 1.0) * libm::asinh(WORLD * 1.1 / FINE));
    DVec2::new(back(u), back(1.0 - v)) + MIDDLE
}

/// Colours of the land: dry grass and earth near the farm, a patchwork of fields, wooded hills,
/// mountains pale with distance.
fn world() -> Texture {
    paint::paint("land", 1024, |u, v| {
        let p = place(u, v);
        let far = (p - DVec2::new(0.0, 10.0)).length();
        let fine = paint::cloud(p.x * 1.7, p.y * 1.7, 4, 31);
        let broad = paint::cloud(p.x / 9.0, p.y / 9.0, 3, 32);
        let dry = DVec3::new(0.36, 0.29, 0.13);
        let green = DVec3::new(0.15, 0.19, 0.06);
        let mix = |a: DVec3, b: DVec3, t: f64| a + (b - a) * t.clamp(0.0, 1.0);
        let mut colour = mix(green, dry, 1.6 * broad - 0.35 + 0.5 * (fine - 0.5)) * (0.65 + 0.7 * fine);
        if far > 60.0 {
            colour = mix(colour, patchwork(p) * (0.8 + 0.4 * fine), land::smooth(70.0, 100.0, far));
            let woods = paint::cloud(p.x / 70.0, p.y / 70.0, 4, 33);
            let wooded = land::smooth(0.48, 0.56, woods) * land::smooth(110.0, 190.0, far);
            colour = mix(colour, DVec3::new(0.05, 0.085, 0.035) * (0.7 + 0.6 * fine), wooded);
            let haze = 0.78 * land::smooth(130.0, 900.0, far);
            colour = mix(colour, DVec3::new(0.36, 0.40, 0.50), haze);
        }
        colour
    })
}

/// Fields far away: each with its crop, in strips.
fn patchwork(p: DVec2) -> DVec3 {
    let bend = paint::cloud(p.x / 50.0, p.y / 50.0, 2, 41) * 26.0;
    let (a, b) = ((p.x + 0.4 * p.y + bend) / 46.0, (p.y - 0.3 * p.x + bend) / 38.0);
    let (ia, ib) = (libm::floor(a), libm::floor(b));
    let crop = paint::noise(ia * 7.0, ib * 5.0, 42);
    let edge = (a - ia).min(1.0 - (a - ia)).min((b - ib).min(1.0 - (b - ib)));
    let strips = 0.85 + 0.3 * libm::sin(a * 46.0 * 2.2).max(-0.6);
    if edge < 0.03 {
        return DVec3::new(0.10, 0.13, 0.05);
    }
    match (crop * 5.0) as u32 {
        0 => DVec3::new(0.20, 0.12, 0.36) * strips,
        1 => DVec3::new(0.50, 0.38, 0.13),
        2 => DVec3::new(0.17, 0.22, 0.06) * strips,
        3 => DVec3::new(0.42, 0.33, 0.17),
        _ => DVec3::new(0.24, 0.24, 0.09),
    }
}

/// Stony brown earth; repeats.
fn earth() -> Texture {
    paint::paint("earth", 512, |u, v| {
        let base = DVec3::new(0.30, 0.19, 0.11) * (0.55 + 0.8 * paint::wrapped(u, v, 24, 51));
        let stone = paint::wrapped(u, v, 70, 52);
        let pale = land::smooth(0.68, 0.80, stone) * 0.6;
        base + (DVec3::new(0.48, 0.40, 0.30) - base) * pale
    })
}

/// Pale gravel with two ruts and a grassy middle; `u` across, `v` along; repeats along.
fn gravel() -> Texture {
    paint::paint("gravel", 512, |u, v| {
        let grain = paint::wrapped(u, v, 60, 61);
        let patches = paint::wrapped(u, v, 7, 62);
        let stone = DVec3::new(0.58, 0.48, 0.35) * (0.6 + 0.55 * grain + 0.25 * patches);
        let off = (u - 0.5).abs();
        let middle = 1.0 - land::smooth(0.02, 0.11, off + 0.10 * (patches - 0.5));
        let edge = land::smooth(0.40, 0.5, off + 0.14 * (patches - 0.5));
        let grass = DVec3::new(0.24, 0.23, 0.09) * (0.5 + grain);
        let rut = 1.0 - 0.16 * (1.0 - land::smooth(0.03, 0.09, (off - 0.25).abs()));
        stone * rut + (grass - stone * rut) * (0.7 * middle + 0.85 * edge).min(1.0)
    })
}

/// The road's surface, a hand above the ground, its edges let into it.
fn ribbon() -> Part {
    const PIECES: usize = 300;
    const ACROSS: usize = 7;
    let mut along = 0.0;
    let mut lengths = vec![0.0];
    for i in 1..=PIECES {
        let at = |k: usize| land::road(k as f64 / PIECES as f64).0;
        along += (at(i) - at(i - 1)).length();
        lengths.push(along);
    }
    let mut part = Part::grid(PIECES + 1, ACROSS, false, |row, column| {
        let (p, d) = land::road(row as f64 / PIECES as f64);
        let t = 2.0 * column as f64 / (ACROSS - 1) as f64 - 1.0;
        let side = DVec2::new(-d.y, d.x) * (t * land::ROAD_HALF);
        let lift = if t.abs() > 0.99 { -0.08 } else { 0.055 + 0.03 * (1.0 - t * t) };
        land::ground(p.x + side.x, p.y + side.y) + DVec3::Y * lift
    });
    for (i, uv) in part.uvs.iter_mut().enumerate() {
        let (row, column) = (i / ACROSS, i % ACROSS);
        *uv = DVec2::new(column as f64 / (ACROSS - 1) as f64, lengths[row] / (2.0 * land::ROAD_HALF));
    }
    part.crease(80.0)
}
