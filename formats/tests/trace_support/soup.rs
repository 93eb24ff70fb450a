//! Random trees over random triangles, and what else a trace says of its scene.

use rayreel_formats::bvh::{Bvh, Shape, Triangle, Vertex};
use rayreel_formats::math::{Vec3, vec3};
use rayreel_formats::oct::Oct;
use rayreel_formats::scene::{Camera, Light, Material, Meta, Optics};

use super::Random;

fn point(random: &mut Random) -> Vec3 {
    vec3(random.signed(), random.signed(), random.signed())
}

pub fn oct(random: &mut Random) -> Oct {
    Oct::from_bits(random.next())
}

/// One material of each kind, the second half of them cut out.
pub fn materials() -> Vec<Material> {
    let optics = [Optics::Opaque, Optics::Mirror, Optics::FresnelMirror, Optics::Dielectric];
    let material = |i: usize| Material {
        name: format!("material {i}"),
        optics: optics[i % 4],
        ior: 1.5,
        specular: vec3(0.9, 0.5, 0.1),
        transmission: vec3(0.8, 1.0, 0.3),
        cutout: i >= 4,
    };
    (0..8).map(material).collect()
}

/// A random tree over `count` triangles, with empty leaves here and there.
pub fn bvh(random: &mut Random, count: u32) -> Bvh {
    let vertices: Vec<Vertex> =
        (0..count * 2 + 3).map(|_| Vertex { position: point(random), normal: oct(random) }).collect();
    let triangle = |random: &mut Random| Triangle {
        vertices: [(); 3].map(|()| random.below(vertices.len() as u32)),
        object: random.below(3),
        material: random.below(8),
    };
    let triangles: Vec<Triangle> = (0..count).map(|_| triangle(random)).collect();
    let mut shape = Vec::new();
    split(random, &mut shape, count);
    let objects = ["a", "b", "an object"].map(String::from).to_vec();
    Bvh::new(&shape, triangles, vertices, objects, materials()).expect("the shape is a tree over its triangles")
}

/// Appends an inner node over `count` triangles.
fn split(random: &mut Random, shape: &mut Vec<[Shape; 2]>, count: u32) {
    let node = shape.len();
    shape.push([Shape::Leaf(0); 2]);
    let left = if random.once_in(20) { 0 } else { (count / 2 + random.below(3)).min(count) };
    for (side, part) in [left, count - left].into_iter().enumerate() {
        if part > 4 || part > 1 && random.once_in(2) {
            shape[node][side] = Shape::Inner;
            split(random, shape, part);
        } else {
            shape[node][side] = Shape::Leaf(part as u8);
        }
    }
}

pub fn camera(random: &mut Random) -> Camera {
    Camera { eye: point(random) * 3.0, corner: point(random), right: point(random) * 0.1, down: point(random) * 0.1 }
}

/// Metadata of two frames of `tile` x `tile` tiles over a picture of `width` x `height` at one sample a pixel.
pub fn meta(random: &mut Random, (width, height): (u32, u32), tile: u32, max_depth: u32, lights: u32) -> Meta {
    let light = |i: u32| match i % 2 {
        0 => Light::Point { position: vec3(i as f32, 5.0, 1.0), colour: Vec3::ONE },
        _ => Light::Directional { to_light: vec3(0.6, 0.8, 0.0), colour: vec3(0.1, 0.2, i as f32) },
    };
    Meta {
        tool: "test".into(),
        scene: "soup".into(),
        scene_hash: [random.next() as u8; 32],
        width,
        height,
        samples: 1,
        tile,
        first_frame: 3,
        frames: 2,
        max_depth,
        min_weight: 0.01,
        lights: (0..lights).map(light).collect(),
    }
}
