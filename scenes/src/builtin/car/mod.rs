//! `car`: a red grand tourer on the wet stone of a round court. 55,000 triangles.

mod body;
mod cabin;
mod details;
mod finishes;
mod interior;
mod plaza;
mod shell;
mod wheel;

use glam::Vec3;

use self::finishes::Finishes;
use crate::{
    camera,
    error::SceneError,
    modelling::{Part, SceneBuilder},
    scene::{Camera, Scene},
};

/// Frames of the turn round the car.
const FRAMES: u32 = 120;

/// The scene with its orbit; frame 0 is the hero view.
pub fn scene() -> Result<Scene, SceneError> {
    let mut out = SceneBuilder::new("car");
    let finishes = Finishes::new(&mut out);
    let shell = shell::Shell::new();
    body(&mut out, &shell, &finishes);
    wheels(&mut out, &finishes);
    interior::build(&mut out, &shell, &finishes);
    details::build(&mut out, &finishes);
    plaza::build(&mut out);
    out.point_light([26.0, 34.0, 22.0], [1.06, 0.92, 0.72]);
    out.point_light([-14.0, 16.0, 20.0], [0.16, 0.19, 0.25]);
    out.sky([0.07, 0.19, 0.52], [0.66, 0.70, 0.74], [0.20, 0.17, 0.14], 0.46);
    let hero =
        Camera { eye: Vec3::new(5.3, 1.22, 4.6), target: Vec3::new(0.16, 0.76, 0.0), up: Vec3::Y, vfov_deg: 23.6 };
    out.finish(camera::orbit(hero, FRAMES, 0.5))
}

fn body(out: &mut SceneBuilder, shell: &shell::Shell, finishes: &Finishes) {
    out.object("body", &body::skin(&shell::opening), finishes.paint);
    out.extend(&body::lips(), finishes.paint);
    out.object("roof", &cabin::outside(shell), finishes.paint);
    out.object("underside", &body::underside(), finishes.black);
    out.object("lining", &cabin::lining(shell), finishes.leather);
    for (name, pane) in cabin::windows(shell) {
        out.object(name, &pane, finishes.glass);
    }
    out.object("window trim", &cabin::trim(shell), finishes.chrome);
}

fn wheels(out: &mut SceneBuilder, finishes: &Finishes) {
    let names = [["rear left", "rear right"], ["front left", "front right"]];
    for (axle, names) in body::AXLES.into_iter().zip(names) {
        for (side, name) in [-1.0, 1.0].into_iter().zip(names) {
            let wheel = wheel::wheel(9.0 + 13.0 * side + 7.0 * axle);
            let place = |part: &Part| {
                let part = if side < 0.0 { part.clone().mirrored_z() } else { part.clone() };
                part.at(axle, body::AXLE_HEIGHT, side * 0.715)
            };
            out.object(&format!("{name} wheel"), &place(&wheel.tyre), finishes.rubber);
            out.extend(&place(&wheel.chrome), finishes.chrome);
            out.extend(&place(&wheel.alloy), finishes.alloy);
            out.extend(&place(&wheel.disc), finishes.steel);
        }
    }
}
