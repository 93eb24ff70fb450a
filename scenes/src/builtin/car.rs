//! `car`: a red grand tourer on the wet stone of a round court. 55,000 triangles.

use glam::Vec3;

use crate::{
    builtin::{car_body, car_cabin, car_details, car_interior, car_plaza, car_shell, car_wheel},
    camera,
    error::SceneError,
    modelling::{Part, SceneBuilder, builder},
    scene::{Camera, Material, Scene},
};

/// Frames of the turn round the car.
const FRAMES: u32 = 120;

/// Material numbers that several parts of the car share.
pub struct Finishes {
    /// Red under a clear coat.
    pub paint: u32,
    /// Bumpers, strips, lips.
    pub chrome: u32,
    /// Gaps, arches and floor.
    pub black: u32,
    /// Tyres.
    pub rubber: u32,
    /// Windows and lenses.
    pub glass: u32,
    /// Seats and lining.
    pub leather: u32,
    /// Rims and spokes.
    pub alloy: u32,
    /// Brake discs.
    pub steel: u32,
    /// Tub, dashboard and steering wheel.
    pub dark: u32,
}

/// The scene with its orbit; frame 0 is the hero view.
pub fn scene() -> Result<Scene, SceneError> {
    let mut out = SceneBuilder::new("car");
    let finishes = Finishes::new(&mut out);
    let shell = car_shell::Shell::new();
    body(&mut out, &shell, &finishes);
    wheels(&mut out, &finishes);
    car_interior::build(&mut out, &shell, &finishes);
    car_details::build(&mut out, &finishes);
    car_plaza::build(&mut out);
    out.point_light([26.0, 34.0, 22.0], [1.06, 0.92, 0.72]);
    out.point_light([-14.0, 16.0, 20.0], [0.16, 0.19, 0.25]);
    out.sky([0.07, 0.19, 0.52], [0.66, 0.70, 0.74], [0.20, 0.17, 0.14], 0.46);
    let hero =
        Camera { eye: Vec3::new(5.3, 1.22, 4.6), target: Vec3::new(0.16, 0.76, 0.0), up: Vec3::Y, vfov_deg: 23.6 };
    out.finish(camera::orbit(hero, FRAMES, 0.5))
}

impl Finishes {
    fn new(out: &mut SceneBuilder) -> Self {
        let mut add = |material: Material| out.material(material);
        Self {
            paint: add(builder::polished("paint", [0.34, 0.006, 0.010], 0.055, 400)),
            chrome: add(builder::mirror("chrome", [0.03; 3], [0.80, 0.82, 0.84], 500)),
            black: add(builder::matte("black", [0.012; 3])),
            rubber: add(builder::matte("rubber", [0.022, 0.022, 0.024])),
            glass: add(builder::glass("glass", [0.955, 0.972, 0.965], 1.5)),
            leather: add(builder::polished("leather", [0.40, 0.215, 0.105], 0.025, 30)),
            alloy: add(builder::mirror("alloy", [0.26, 0.26, 0.27], [0.36, 0.36, 0.37], 90)),
            steel: add(builder::mirror("steel", [0.14; 3], [0.22; 3], 60)),
            dark: add(builder::polished("trim", [0.025, 0.022, 0.02], 0.03, 60)),
        }
    }
}

fn body(out: &mut SceneBuilder, shell: &car_shell::Shell, finishes: &Finishes) {
    out.object("body", &car_body::skin(&car_shell::opening), finishes.paint);
    out.extend(&car_body::lips(), finishes.paint);
    out.object("roof", &car_cabin::outside(shell), finishes.paint);
    out.object("underside", &car_body::underside(), finishes.black);
    out.object("lining", &car_cabin::lining(shell), finishes.leather);
    for (name, pane) in car_cabin::windows(shell) {
        out.object(name, &pane, finishes.glass);
    }
    out.object("window trim", &car_cabin::trim(shell), finishes.chrome);
}

fn wheels(out: &mut SceneBuilder, finishes: &Finishes) {
    let names = [["rear left", "rear right"], ["front left", "front right"]];
    for (axle, names) in car_body::AXLES.into_iter().zip(names) {
        for (side, name) in [-1.0, 1.0].into_iter().zip(names) {
            let wheel = car_wheel::wheel(9.0 + 13.0 * side + 7.0 * axle);
            let place = |part: &Part| {
                let part = if side < 0.0 { part.clone().mirrored_z() } else { part.clone() };
                part.at(axle, car_body::AXLE_HEIGHT, side * 0.715)
            };
            out.object(&format!("{name} wheel"), &place(&wheel.tyre), finishes.rubber);
            out.extend(&place(&wheel.chrome), finishes.chrome);
            out.extend(&place(&wheel.alloy), finishes.alloy);
            out.extend(&place(&wheel.disc), finishes.steel);
        }
    }
}
