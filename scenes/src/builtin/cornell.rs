//! `cornell`: a tiny Cornell box, as wide as the picture, with a mirror box and a glass sphere.
//! Golden traces are made from it.

use glam::{DVec3, Vec3};

use crate::{
    error::SceneError,
    modelling::{SceneBuilder, block, builder, lathe},
    scene::{Camera, Material, Scene},
};

/// Half the room's width; the room is two and a half metres deep and open towards the camera.
const HALF_WIDTH: f64 = 1.9;
const HEIGHT: f64 = 1.9;
const HALF_DEPTH: f64 = 1.2;

/// The scene, with one camera.
pub fn scene() -> Result<Scene, SceneError> {
    let mut out = SceneBuilder::new("cornell");
    let white = out.material(builder::matte("white", [0.74, 0.72, 0.68]));
    let red = out.material(builder::matte("red", [0.62, 0.07, 0.05]));
    let green = out.material(builder::matte("green", [0.14, 0.46, 0.10]));
    let steel = out.material(builder::mirror("mirror", [0.03, 0.03, 0.035], [0.86, 0.87, 0.9], 600));
    let glass = out.material(builder::glass("glass", [0.97, 0.985, 0.98], 1.5));
    let blue = out.material(builder::polished("blue", [0.10, 0.20, 0.48], 0.05, 120));
    let lamp = out.material(Material { emission: Vec3::new(1.0, 0.95, 0.82), ..builder::matte("lamp", [0.0; 3]) });
    room(&mut out, white, red, green);
    // Just under the ceiling, facing down.
    let panel = block::rectangle(
        DVec3::new(-0.45, HEIGHT - 0.004, -0.5),
        DVec3::new(0.9, 0.0, 0.0),
        DVec3::new(0.0, 0.0, 0.75),
    );
    out.object("lamp", &panel, lamp);
    let tall = block::block(DVec3::new(-0.34, 0.0, -0.34), DVec3::new(0.34, 1.16, 0.34)).turned(41.0);
    out.object("mirror box", &tall.at(-0.72, 0.0, -0.35), steel);
    let short = block::block(DVec3::new(-0.27, 0.0, -0.27), DVec3::new(0.27, 0.46, 0.27)).turned(-18.0);
    out.object("short box", &short.at(1.18, 0.0, -0.45), blue);
    let ball = lathe::sphere(DVec3::new(0.42, 0.421, 0.3), 0.42, 24);
    out.object("glass sphere", &ball.crease(60.0), glass);
    out.point_light([0.0, HEIGHT as f32 - 0.12, -0.05], [0.88, 0.84, 0.74]);
    out.sky([0.30, 0.38, 0.52], [0.62, 0.66, 0.70], [0.30, 0.28, 0.26], 0.52);
    let camera =
        Camera { eye: Vec3::new(0.0, 0.95, 4.35), target: Vec3::new(0.0, 0.95, 0.0), up: Vec3::Y, vfov_deg: 33.2 };
    out.finish(vec![camera])
}

fn room(out: &mut SceneBuilder, white: u32, red: u32, green: u32) {
    let (w, h, d) = (HALF_WIDTH, HEIGHT, HALF_DEPTH);
    let (x, y, z) = (DVec3::new(2.0 * w, 0.0, 0.0), DVec3::new(0.0, h, 0.0), DVec3::new(0.0, 0.0, 2.0 * d));
    let corner = |sx: f64, y: f64, sz: f64| DVec3::new(sx * w, y, sz * d);
    out.object("floor", &block::rectangle(corner(-1.0, 0.0, 1.0), x, -z), white);
    out.object("ceiling", &block::rectangle(corner(-1.0, h, -1.0), x, z), white);
    out.object("back wall", &block::rectangle(corner(-1.0, 0.0, -1.0), x, y), white);
    out.object("left wall", &block::rectangle(corner(-1.0, 0.0, 1.0), -z, y), red);
    out.object("right wall", &block::rectangle(corner(1.0, 0.0, -1.0), z, y), green);
}
