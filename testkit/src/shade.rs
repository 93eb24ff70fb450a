//! Shading from attributes, once more: written from POLICIES.md.

use rayreel_formats::scene::Light;
use rayreel_replay::policy::{Sampling, Shade};

use crate::recorded::Frame;
use crate::rules::{Hit, Surface, mix};

type Rgb = [f32; 3];

/// Gives the interpolated `hit` the colours that follow from its attributes, if the policy says so.
pub fn shade(rules: &Sampling, frame: &Frame, (near, far): (&Hit, &Hit), s: f32, hit: &mut Hit) {
    let (Some(a), Some(b), Some(c)) = (&near.surface, &far.surface, &hit.surface) else { return };
    if rules.shade == Shade::Colour {
        return;
    }
    let ambient = rules.shade_ambient as f32;
    let at_a = light(frame, ambient, a, unit(a.normal));
    let at_b = light(frame, ambient, b, unit(b.normal));
    let here = light(frame, ambient, c, c.normal);
    let ends = |i: usize| (near.local[i] * (here[i] / at_a[i]), far.local[i] * (here[i] / at_b[i]));
    let first = std::array::from_fn(|i| ends(i).0);
    let second = std::array::from_fn(|i| ends(i).1);
    let local = mix(first, second, s);
    hit.colour = std::array::from_fn(|i| hit.colour[i] + (local[i] - hit.local[i]));
    hit.local = local;
}

fn light(frame: &Frame, ambient: f32, hit: &Surface, mut normal: [f32; 3]) -> Rgb {
    let eye = frame.camera.eye.to_array();
    let towards: [f32; 3] = std::array::from_fn(|i| eye[i] - hit.position[i]);
    if dot(normal, towards) < 0.0 {
        normal = normal.map(|v| -v);
    }
    let mut sum = [ambient; 3];
    for (number, lamp) in frame.lights.iter().enumerate() {
        // 1 is lit, 3 is tinted.
        if hit.shadows >> (2 * number) & 1 == 0 {
            continue;
        }
        let (l, colour) = match lamp {
            Light::Point { position, colour } => {
                let p = position.to_array();
                (std::array::from_fn(|i| p[i] - hit.position[i]), colour.to_array())
            }
            Light::Directional { to_light, colour } => (to_light.to_array(), colour.to_array()),
        };
        let cosine = dot(normal, unit(l));
        if cosine > 0.0 {
            sum = std::array::from_fn(|i| sum[i] + colour[i] * cosine);
        }
    }
    sum
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}
