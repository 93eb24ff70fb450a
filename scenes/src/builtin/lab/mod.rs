//! `lab`: a chemistry laboratory. Coloured liquids in flasks, beakers, tubes and bottles, a distillation, a burette and
//! a retort on a tiled island; benches, a shelf and a sink behind. 98,000 triangles.

mod apparatus;
mod furniture;
mod glassware;
mod metal;
mod room;
mod stock;
mod things;

use glam::{DVec3, Vec3};

use self::{
    apparatus::GAP,
    glassware as ware,
    stock::{BLUE, CLEAR, GREEN, PINK, RED, Stock, VIOLET},
};
use crate::{
    camera::{self, Interpolation, Keyframe},
    error::SceneError,
    modelling::{Part, SceneBuilder, vessel::Vessel},
    scene::{Camera, Scene},
};

/// The scene with its path along the benches; frame 0 is the hero view.
pub fn scene() -> Result<Scene, SceneError> {
    let mut out = SceneBuilder::new("lab");
    let stock = stock::stock(&mut out);
    room::room(&mut out);
    furniture::furniture(&mut out, &stock);
    apparatus::distillation(&mut out, &stock, DVec3::new(-4.2, 0.0, -0.7));
    apparatus::titration(&mut out, &stock, DVec3::new(3.6, 0.0, -1.6));
    apparatus::retort(&mut out, &stock, DVec3::new(7.2, 0.0, -0.9), -12.0);
    apparatus::rack(&mut out, &stock, DVec3::new(-2.0, 0.0, 1.9), 12.0);
    apparatus::hot_plate(&mut out, &stock, DVec3::new(-8.2, 0.0, 0.2), 18.0);
    things::microscope(&mut out, &stock, DVec3::new(7.2, 0.0, -11.6), 200.0);
    things::mortar(&mut out, &stock, DVec3::new(6.4, 0.0, 1.7));
    things::notebook(&mut out, &stock, DVec3::new(3.9, 0.0, 2.2), 24.0);
    things::bottles(&mut out, &stock);
    glassware(&mut out, &stock);
    out.point_light([9.0, 13.5, 13.0], [0.74, 0.66, 0.52]);
    out.point_light([-10.5, 12.5, 8.0], [0.20, 0.24, 0.30]);
    out.point_light([-6.0, 11.0, -9.0], [0.36, 0.36, 0.36]);
    // The horizon has the brightness of the walls: where the depth limit cuts a ray off behind several vessels, it
    // shows the sky in that direction.
    out.sky([0.20, 0.38, 0.72], [0.50, 0.65, 0.70], [0.36, 0.34, 0.30], 0.42);
    out.finish(path())
}

/// Vessels that stand by themselves on the island.
fn glassware(out: &mut SceneBuilder, stock: &Stock) {
    let liquid = |kind: usize, level: f64| Some((level, stock.liquids[kind]));
    let mut place = |name: &str, vessel: &Vessel, x: f64, z: f64, turn: f64, fill: Option<(f64, u32)>| {
        vessel.build(out, name, stock.glass, fill, |p: Part| p.turned(turn).at(x, GAP, z));
    };
    place("blue flask", &ware::erlenmeyer(1.55), 1.5, 1.3, 0.0, liquid(BLUE, 0.95));
    place("violet flask", &ware::erlenmeyer(1.15), 5.2, 0.3, 0.0, liquid(VIOLET, 0.62));
    // Under the end of the retort's neck.
    place("empty flask", &ware::erlenmeyer(1.75), 11.82, 0.1, 0.0, None);
    place("red beaker", &ware::beaker(0.62, 1.5), 0.1, 2.4, 60.0, liquid(RED, 0.8));
    place("green beaker", &ware::beaker(0.82, 2.0), -5.9, 1.6, 110.0, liquid(GREEN, 1.15));
    place("clear beaker", &ware::beaker(0.5, 1.2), 2.6, 2.6, -40.0, liquid(CLEAR, 0.6));
    place("dish", &ware::dish(0.62), -4.2, 2.5, 0.0, liquid(PINK, 0.14));
    place("dish 2", &ware::dish(0.5), 5.4, 2.7, 0.0, liquid(BLUE, 0.12));
    for (name, x, z, height, kind, level) in
        [("cylinder 1", -7.2, -1.6, 3.2, BLUE, 1.9), ("cylinder 2", 5.5, -1.5, 2.6, RED, 1.2)]
    {
        let vessel = ware::cylinder(0.32, height);
        vessel.build(out, name, stock.glass, liquid(kind, level), |p| p.at(x, GAP, z));
        out.object(&format!("{name} foot"), &ware::cylinder_foot(0.32).at(x, 0.0, z), stock.porcelain);
        apparatus::marks(out, stock, &format!("{name} marks"), &vessel, DVec3::new(x, GAP, z), (0.5, height - 0.5, 20));
    }
}

/// From the hero view to the left end of the island, past its front to the retort, and back for a look at the room.
fn path() -> Vec<Camera> {
    let key = |frame, eye: [f32; 3], target: [f32; 3], vfov_deg| Keyframe {
        frame,
        camera: Camera { eye: eye.into(), target: target.into(), up: Vec3::Y, vfov_deg },
    };
    let keys = [
        key(0, [5.5, 3.8, 13.6], [0.85, 1.95, 0.0], 31.5),
        key(40, [-4.5, 3.2, 10.5], [-2.2, 1.6, 0.0], 27.0),
        key(80, [-9.0, 3.8, 9.0], [-3.0, 1.5, -1.0], 29.0),
        key(120, [1.0, 2.8, 9.0], [1.8, 1.5, -1.0], 29.0),
        key(160, [9.6, 4.0, 10.8], [6.2, 2.1, -1.0], 29.0),
        key(220, [14.5, 6.4, 19.5], [0.6, -0.6, -2.5], 33.0),
    ];
    camera::interpolate(&keys, Interpolation::CatmullRom)
}
