//! A small scene with everything that a path can hold: cut-out leaves, a cut-out glass ball, mirrors, many lights.

use glam::{DVec3, Vec3};
use rayreel_scenes::modelling::{SceneBuilder, block, builder, lathe};
use rayreel_scenes::{Camera, Light, Material, Scene, Texture};

/// Every other square of an 8 x 8 board is a hole.
fn board() -> Texture {
    let texel = |i: u32| [200, 40, 90, if (i % 8 + i / 8).is_multiple_of(2) { 255 } else { 0 }];
    Texture {
        name: "board".into(),
        width: 8,
        height: 8,
        texels: (0..64).map(texel).collect(),
        wrap: [rayreel_scenes::Wrap::Repeat; 2],
    }
}

/// The scene with `lights` lights, points and directions in turn.
pub fn scene(lights: usize) -> Scene {
    let mut out = SceneBuilder::new("cutout");
    let map = out.texture(board());
    let leaf = out.material(Material { alpha_map: Some(map), ..builder::matte("leaf", [0.3, 0.6, 0.2]) });
    let glass = out.material(builder::glass("glass", [0.95, 0.9, 0.8], 1.5));
    let holed = out.material(Material { alpha_map: Some(map), ..builder::glass("holed", [0.8, 0.9, 0.95], 1.4) });
    let mirror = out.material(builder::mirror("mirror", [0.1; 3], [0.9, 0.8, 0.7], 50));
    let floor = out.material(builder::polished("floor", [0.4, 0.3, 0.2], 0.05, 40));
    let rectangle = |z: f64, size: f64| {
        let corner = DVec3::new(-size / 2.0, 0.0, z);
        block::rectangle(corner, DVec3::new(size, 0.0, 0.0), DVec3::new(0.0, size, 0.1))
    };
    for (i, z) in [0.6, 0.9, 1.2].into_iter().enumerate() {
        out.object(&format!("leaf {i}"), &rectangle(z, 1.6).planar_uv(Default::default(), 0.7), leaf);
    }
    out.object("mirror", &rectangle(-2.0, 3.0), mirror);
    let ground = DVec3::new(-4.0, 0.0, 4.0);
    out.object("floor", &block::rectangle(ground, DVec3::new(8.0, 0.0, 0.0), DVec3::new(0.0, 0.0, -8.0)), floor);
    out.object("ball", &lathe::sphere(DVec3::new(-0.7, 0.5, 0.0), 0.5, 16), glass);
    let holes = lathe::sphere(DVec3::new(0.7, 0.5, 0.0), 0.5, 16).planar_uv(Default::default(), 0.5);
    out.object("holed ball", &holes, holed);
    let camera =
        Camera { eye: Vec3::new(0.4, 1.1, 4.0), target: Vec3::new(0.0, 0.5, 0.0), up: Vec3::Y, vfov_deg: 40.0 };
    let mut scene = out.finish(vec![camera, Camera { eye: Vec3::new(-2.0, 1.5, 3.0), ..camera }]).expect("a scene");
    let light = |i: usize| {
        let at = Vec3::new((i as f32 * 2.4).sin() * 3.0, 1.0 + i as f32 * 0.4, (i as f32 * 2.4).cos() * 3.0);
        let colour = Vec3::splat(0.2);
        if i.is_multiple_of(2) {
            Light::Point { position: at, colour }
        } else {
            Light::Directional { to_light: at, colour }
        }
    };
    scene.lights = (0..lights).map(light).collect();
    scene.validate().expect("a valid scene");
    scene
}
