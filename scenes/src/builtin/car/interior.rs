//! What one sees of `car` through its windows: tub, seats, dashboard, steering wheel.

use glam::{DVec2, DVec3};

use crate::{
    builtin::car::{finishes::Finishes, shell::Shell},
    modelling::{
        Part, SceneBuilder,
        rounded::{pitched, rounded},
        sweep,
    },
};

/// Distance of the seats from the middle.
const SEAT: f64 = 0.31;

/// Adds the interior.
pub fn build(out: &mut SceneBuilder, shell: &Shell, finishes: &Finishes) {
    out.object("tub", &tub(shell), finishes.dark);
    for (name, z) in [("left seat", -SEAT), ("right seat", SEAT)] {
        out.object(name, &seat().at(-0.28, 0.0, z), finishes.leather);
    }
    let bench = rounded(DVec3::new(0.10, 0.20, 0.46), 0.4, 14);
    out.object("rear bench", &pitched(bench, 24.0).at(-1.0, 0.60, 0.0), finishes.leather);
    out.object("dashboard", &rounded(DVec3::new(0.20, 0.11, 0.575), 0.4, 20).at(0.47, 0.70, 0.0), finishes.dark);
    let binnacle = rounded(DVec3::new(0.11, 0.06, 0.17), 0.5, 14).at(0.38, 0.80, -SEAT);
    out.extend(&binnacle, finishes.dark);
    steering_wheel(out, finishes);
    out.object("mirror", &rounded(DVec3::new(0.012, 0.028, 0.10), 0.5, 12).at(0.20, 1.13, 0.0), finishes.dark);
}

/// Walls and floor inside the body.
fn tub(shell: &Shell) -> Part {
    let columns = 40;
    let rim = shell.belt(columns, 0.065, 0.03);
    let wide = shell.belt(columns, 0.10, 0.0);
    Part::grid(4, columns, true, |row, column| match row {
        0 => DVec3::new(-0.4, 0.27, 0.0),
        1 => DVec3::new(wide[column].x * 0.96, 0.27, wide[column].z),
        2 => DVec3::new(wide[column].x, 0.5, wide[column].z),
        _ => rim[column],
    })
    .flipped()
}

fn seat() -> Part {
    let base = rounded(DVec3::new(0.25, 0.085, 0.235), 0.45, 18).at(0.06, 0.42, 0.0);
    let back = pitched(rounded(DVec3::new(0.075, 0.315, 0.225), 0.5, 18), 16.0).at(-0.27, 0.71, 0.0);
    let head = pitched(rounded(DVec3::new(0.05, 0.075, 0.12), 0.6, 14), 14.0).at(-0.385, 1.03, 0.0);
    let bolster = |z: f64| pitched(rounded(DVec3::new(0.06, 0.24, 0.045), 0.7, 10), 16.0).at(-0.20, 0.69, z);
    base.with(back).with(head).with(bolster(-0.19)).with(bolster(0.19))
}

fn steering_wheel(out: &mut SceneBuilder, finishes: &Finishes) {
    let axis = DVec3::new(-0.90, 0.436, 0.0).normalize();
    let centre = DVec3::new(0.20, 0.775, -SEAT);
    let rim = sweep::ring(&sweep::circle(centre, axis, 0.175, 30), axis, DVec2::splat(0.014), 8);
    out.object("steering wheel", &rim, finishes.dark);
    let across = axis.cross(DVec3::Z).normalize();
    for direction in [DVec3::Z, -DVec3::Z, across] {
        let path = [centre, centre + direction * 0.09, centre + direction * 0.172];
        out.extend(&sweep::bar(&path, axis, DVec2::new(0.013, 0.004), 6), finishes.chrome);
    }
    let column = [centre + axis * 0.025, centre, centre - axis * 0.26];
    out.extend(&sweep::bar(&column, DVec3::Y, DVec2::splat(0.032), 12), finishes.dark);
}
