//! The fittings of `car`: lamps, bumpers, grille, mirrors, handles, shut lines.

use glam::{DVec2, DVec3, Vec3};

use crate::{
    builtin::car::{body, finishes::Finishes},
    modelling::{
        Part, SceneBuilder, block, builder,
        curve::lerp,
        lathe::{lathe, sphere},
        paint,
        part::sin_cos,
        profile::{c, s, sample},
        rounded::{axis_to_x, pitched, rounded},
        sweep,
    },
    scene::{Material, Texture},
};

/// Adds the fittings.
pub fn build(out: &mut SceneBuilder, finishes: &Finishes) {
    headlamps(out, finishes);
    tail_lamps(out, finishes);
    bumpers(out, finishes);
    grille(out, finishes);
    mirrors(out, finishes);
    lines(out, finishes);
    small_things(out, finishes);
}

fn both(right: Part) -> Part {
    right.clone().mirrored_z().with(right)
}

fn headlamps(out: &mut SceneBuilder, finishes: &Finishes) {
    let bulb = out.material(Material { emission: Vec3::new(1.0, 0.93, 0.78), ..builder::matte("bulb", [0.6; 3]) });
    let (y, z, radius) = (0.655, 0.575, 0.094);
    // The skin must lie behind all of the lens.
    let x = (0..12)
        .map(|i| sin_cos(std::f64::consts::TAU * f64::from(i) / 12.0))
        .map(|(sin, cos)| body::reach_of_end(true, y + radius * sin, z + radius * cos))
        .fold(f64::MIN, f64::max);
    let centre = DVec3::new(x + 0.012, y, z);
    let lay = |part: Part| pitched(axis_to_x(part), 8.0).at(centre.x, centre.y, centre.z);
    let pod = [s(0.098, -0.34), s(0.114, -0.2), s(0.117, -0.06), s(0.113, 0.012), c(0.104, 0.014)];
    out.object("lamp housings", &both(lay(lathe(&sample(&pod, 0.1), 26))), finishes.paint);
    let bezel = [s(0.104, 0.004), s(0.113, 0.010), s(0.112, 0.022), s(0.103, 0.027), s(0.096, 0.018), c(0.094, 0.0)];
    out.object("lamp bezels", &both(lay(lathe(&sample(&bezel, 0.03), 28))), finishes.chrome);
    // Seen from the front the bowl's inside is the front of the surface.
    let bowl = [c(0.0, -0.085), s(0.04, -0.072), s(0.075, -0.04), c(0.097, 0.006)];
    out.object("reflectors", &both(lay(lathe(&sample(&bowl, 0.04), 22).flipped())), finishes.chrome);
    out.object("bulbs", &both(lay(sphere(DVec3::new(0.0, -0.045, 0.0), 0.016, 10))), bulb);
    let lens = [
        c(0.0, 0.004),
        c(0.094, 0.004),
        c(0.094, 0.012),
        s(0.075, 0.024),
        s(0.045, 0.033),
        s(0.018, 0.037),
        c(0.0, 0.0375),
    ];
    let lens = lay(lathe(&sample(&lens, 0.03), 28));
    out.object("left lens", &lens.clone().mirrored_z(), finishes.glass);
    out.object("right lens", &lens, finishes.glass);
}

fn tail_lamps(out: &mut SceneBuilder, finishes: &Finishes) {
    let red = out.material(Material {
        emission: Vec3::new(0.20, 0.004, 0.004),
        ..builder::polished("tail lamp", [0.45, 0.01, 0.01], 0.06, 200)
    });
    let at = |z: f64| DVec3::new(body::reach_of_end(false, 0.60, z), 0.60, z);
    for (name, size, material, z) in [("tail lamps", 0.055, red, 0.50), ("tail lamps inside", 0.045, red, 0.375)] {
        let place = at(z);
        let lamp = rounded(DVec3::new(0.032, size, size), 1.0, 14).at(place.x - 0.004, place.y, place.z);
        out.object(name, &both(lamp), material);
        let ring = sweep::circle(place - DVec3::X * 0.004, DVec3::X, size + 0.006, 18);
        out.extend(&both(sweep::ring(&ring, DVec3::X, DVec2::new(0.008, 0.014), 5)), finishes.chrome);
    }
}

fn bumpers(out: &mut SceneBuilder, finishes: &Finishes) {
    for (front, name, y) in [(true, "front bumper", 0.37), (false, "rear bumper", 0.40)] {
        let (tip, from) = if front { (body::NOSE, 1.70) } else { (body::TAIL, -1.62) };
        let half: Vec<DVec3> = (0..=16)
            .map(|i| {
                // Closer together towards the corner, where the skin turns.
                let x = lerp(tip, from, libm::pow(f64::from(i) / 16.0, 2.4));
                let p = body::point(x, body::at_height(x, y));
                let q = body::point(x - tip.signum() * 1e-3, body::at_height(x - tip.signum() * 1e-3, y));
                // Outwards in plan, across the skin.
                let out = if i == 0 {
                    DVec3::X * tip.signum()
                } else {
                    DVec3::new((q.z - p.z).abs() * tip.signum(), 0.0, 1e-3)
                };
                let p = p + out.normalize_or_zero() * 0.038;
                DVec3::new(p.x, y, if i == 0 { 0.0 } else { p.z })
            })
            .collect();
        let mut path: Vec<DVec3> = half.iter().rev().map(|p| DVec3::new(p.x, p.y, -p.z)).collect();
        path.extend(half.iter().skip(1));
        out.object(name, &sweep::bar(&path, DVec3::Y, DVec2::new(0.022, 0.045), 10), finishes.chrome);
    }
}

fn grille(out: &mut SceneBuilder, finishes: &Finishes) {
    let (width, height, middle) = (0.36, 0.068, 0.492);
    let edge: Vec<DVec3> = (0..36)
        .map(|i| {
            let (sin, cos) = sin_cos(std::f64::consts::TAU * f64::from(i) / 36.0);
            let power = |v: f64| libm::copysign(libm::pow(v.abs(), 0.7), v);
            let (z, y) = (width * power(cos), middle + height * power(sin));
            DVec3::new(body::reach_of_end(true, y, z) + 0.010, y, z)
        })
        .collect();
    // Rings from the edge to the middle, just before the skin.
    let inside = Part::grid(4, edge.len(), true, |row, column| {
        let k = 1.0 - row as f64 / 3.0;
        let (y, z) = (lerp(middle, edge[column].y, k), edge[column].z * k);
        DVec3::new(body::reach_of_end(true, y, z) + 0.011, y, z)
    });
    out.object("grille", &inside, finishes.black);
    out.extend(&sweep::ring(&edge, DVec3::X, DVec2::new(0.010, 0.016), 6), finishes.chrome);
    for i in -1..=1 {
        let y = middle + 0.032 * f64::from(i);
        let path: Vec<DVec3> = (0..=12)
            .map(|k| {
                let z = lerp(-0.33, 0.33, f64::from(k) / 12.0);
                DVec3::new(body::reach_of_end(true, y, z) + 0.020, y, z)
            })
            .collect();
        out.extend(&sweep::bar(&path, DVec3::Y, DVec2::splat(0.006), 6), finishes.chrome);
    }
}

fn mirrors(out: &mut SceneBuilder, finishes: &Finishes) {
    let head = rounded(DVec3::new(0.055, 0.052, 0.085), 0.75, 16).at(0.50, 0.955, 0.80);
    out.object("door mirrors", &both(head), finishes.chrome);
    let foot = [DVec3::new(0.47, 0.79, 0.70), DVec3::new(0.48, 0.86, 0.735), DVec3::new(0.495, 0.93, 0.775)];
    out.extend(&both(sweep::bar(&foot, DVec3::X, DVec2::new(0.010, 0.016), 8)), finishes.chrome);
}

/// A thin bar on the skin through places given by `x` and the [`body::point`] parameter.
fn on_skin(places: &[(f64, f64)], lift: f64, radius: f64) -> Part {
    let path: Vec<DVec3> = places
        .iter()
        .map(|&(x, s)| {
            let p = body::point(x, s);
            let along = body::point(x + 1e-4, s) - p;
            let up = body::point(x, s + 1e-4) - p;
            p + along.cross(up).normalize_or_zero() * lift
        })
        .collect();
    sweep::bar(&path, DVec3::new(0.3, 0.5, 0.81), DVec2::splat(radius), 4)
}

fn lines(out: &mut SceneBuilder, finishes: &Finishes) {
    let along = |from: (f64, f64), to: (f64, f64), count: usize| -> Vec<(f64, f64)> {
        (0..=count).map(|i| i as f64 / count as f64).map(|t| (lerp(from.0, to.0, t), lerp(from.1, to.1, t))).collect()
    };
    let mut door = along((0.62, 0.62), (0.60, -0.80), 14);
    door.extend(along((0.60, -0.80), (-0.62, -0.80), 14).into_iter().skip(1));
    door.extend(along((-0.62, -0.80), (-0.66, 0.62), 14).into_iter().skip(1));
    out.object("door gaps", &both(on_skin(&door, 0.0, 0.0035)), finishes.black);
    let mut bonnet = along((0.86, 0.50), (1.62, 0.60), 14);
    bonnet.extend(along((1.62, 0.60), (1.86, 0.72), 6).into_iter().skip(1));
    bonnet.extend(along((1.86, 0.72), (1.93, 0.9999), 8).into_iter().skip(1));
    out.object("bonnet gap", &both(on_skin(&bonnet, 0.0, 0.0035)), finishes.black);
    out.object(
        "waist strips",
        &both(on_skin(&along((0.905, -0.02), (-0.805, -0.02), 20), 0.003, 0.007)),
        finishes.chrome,
    );
    let handle = along((-0.42, 0.30), (-0.58, 0.30), 6);
    out.object("door handles", &both(on_skin(&handle, 0.018, 0.010)), finishes.chrome);
}

/// Indicators, wipers, exhausts and number plates.
fn small_things(out: &mut SceneBuilder, finishes: &Finishes) {
    let amber = out.material(builder::polished("indicator", [0.75, 0.27, 0.02], 0.06, 200));
    let (y, z) = (0.495, 0.60);
    let lamp = rounded(DVec3::new(0.022, 0.026, 0.048), 0.8, 12).at(body::reach_of_end(true, y, z), y, z);
    out.object("indicators", &both(lamp), amber);
    let pipe = |z: f64| {
        let end = sweep::circle(DVec3::new(body::TAIL + 0.02, 0.225, z), DVec3::X, 0.022, 12);
        let rim = sweep::ring(&end, DVec3::X, DVec2::new(0.005, 0.005), 5);
        axis_to_x(
            lathe(
                &[DVec2::new(0.0, 0.06), DVec2::new(0.021, 0.06), DVec2::new(0.023, 0.0), DVec2::new(0.023, 0.5)],
                12,
            )
            .flipped(),
        )
        .at(body::TAIL + 0.02, 0.225, z)
        .with(rim)
    };
    out.object("exhausts", &pipe(0.42).with(pipe(0.35)), finishes.chrome);
    let wiper = |z: f64| {
        let at = |along: f64, up: f64| {
            DVec3::new(0.83 - 0.66 * up - 0.16 * (z + along) * (z + along), 0.838 + 0.46 * up, z + along)
        };
        sweep::bar(
            &[at(0.0, 0.0), at(0.14, 0.045), at(0.36, 0.10)],
            DVec3::new(0.5, 0.85, 0.0),
            DVec2::new(0.008, 0.005),
            4,
        )
    };
    out.object("wipers", &wiper(-0.42).with(wiper(0.05)), finishes.dark);
    let map = out.texture(plate());
    let mut white = builder::polished("number plate", [1.0; 3], 0.04, 60);
    white.diffuse_map = Some(map);
    let white = out.material(white);
    let (wide, high) = (DVec3::Z * 0.46, DVec3::Y * 0.11);
    let back = DVec3::new(body::reach_of_end(false, 0.50, 0.0) - 0.035, 0.475, -0.23);
    out.object("rear number plate", &block::rectangle(back, wide, high), white);
}

/// `RAY 1` in dark letters of five by seven cells on white.
fn plate() -> Texture {
    const GLYPHS: [[u8; 7]; 4] = [
        [0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001],
        [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        [0b10001, 0b10001, 0b01010, 0b00100, 0b00100, 0b00100, 0b00100],
        [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
    ];
    const PLACES: [f64; 4] = [4.0, 11.0, 18.0, 28.0];
    paint::paint("number plate", 256, |u, v| {
        let (x, y) = (u * 37.0, (1.0 - v) * 11.0 - 2.0);
        let ink = GLYPHS.iter().zip(PLACES).any(|(rows, place)| {
            let (column, row) = (libm::floor(x - place), libm::floor(y));
            (0.0..5.0).contains(&column)
                && (0.0..7.0).contains(&row)
                && rows[row as usize] >> (4 - column as u32) & 1 == 1
        });
        let rim = u.min(1.0 - u) < 0.012 || v.min(1.0 - v) < 0.05;
        if ink || rim { DVec3::splat(0.015) } else { DVec3::new(0.82, 0.81, 0.76) }
    })
}
