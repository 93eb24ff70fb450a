//! Interpolated samples shaded from their interpolated attributes (after Kim et al. 2016).
//!
//! There, a shader runs on every pixel, and only what rays found is interpolated. A replay has no materials. So the diffuse light
//! that falls on a hit is computed here, and what its local colour has beside it is taken as reflectance: ends are divided by
//! their light, the sample between is multiplied by its own. What comes from further rays is interpolated as ever.

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::Light;
use rayreel_formats::tile::ShadowState;

use super::interpolate::mix;
use super::tree::{Node, SurfacePoint};

/// The lights of a scene, and a guess at its ambient light.
#[derive(Clone, Debug)]
pub struct Shading {
    /// In every channel, linear.
    pub ambient: f32,
    /// In the order of the shadow words.
    pub lights: Vec<Light>,
}

impl Shading {
    /// Shades the hit `node`, interpolated `s` of the way from `near` to `far`, as it is seen from `eye`: its local colour and its
    /// colour. A miss stays as it is; false says so.
    pub fn shade(&self, near: &Node, far: &Node, s: f32, eye: Vec3, node: &mut Node) -> bool {
        let (Some(a), Some(b), Some(c)) = (&near.surface, &far.surface, &node.surface) else { return false };
        // An interpolated normal has been divided by its length; so are those of the ends, or equal ends would have another light.
        let (at_near, at_far) = (self.light(a, a.normal.normalized(), eye), self.light(b, b.normal.normalized(), eye));
        let here = self.light(c, c.normal, eye);
        // The shares of light first: where they are 1, the colours are as interpolated, to the last bit.
        let local = mix(near.local.times(ratio(here, at_near)), far.local.times(ratio(here, at_far)), s);
        node.colour = node.colour + (local - node.local);
        node.local = local;
        true
    }

    /// The light that a diffuse surface of reflectance 1 sends to `eye`, per channel.
    fn light(&self, hit: &SurfacePoint, normal: Vec3, eye: Vec3) -> Vec3 {
        let normal = if normal.dot(eye - hit.position) < 0.0 { -normal } else { normal };
        let mut sum = Vec3::splat(self.ambient);
        for (i, light) in self.lights.iter().enumerate() {
            if !matches!(hit.shadows.get(i), ShadowState::Lit | ShadowState::Tinted) {
                continue;
            }
            let (to_light, colour) = match *light {
                Light::Point { position, colour } => (position - hit.position, colour),
                Light::Directional { to_light, colour } => (to_light, colour),
            };
            let cosine = normal.dot(to_light.normalized());
            // Not so for a NaN: a light in the very point.
            if cosine > 0.0 {
                sum = sum + colour * cosine;
            }
        }
        sum
    }
}

fn ratio(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.x / b.x, a.y / b.y, a.z / b.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::interpolate::interpolate_tree;
    use rayreel_formats::math::vec3;
    use rayreel_formats::tile::Shadows;

    fn hit(normal: Vec3, x: f32, local: f32) -> Node {
        let position = vec3(x, 0.0, 0.0);
        let surface = Some(SurfacePoint { object: 1, shadows: Shadows(1), normal, position, t: 5.0 });
        let (local, colour) = (Vec3::splat(local), Vec3::splat(local + 0.125));
        Node { surface, local, colour, reflect: None, refract: None, hit_rays: 2, rays: 2, len: 1, age: 0 }
    }

    fn shaded(a: &Node, b: &Node) -> (Node, Node) {
        let lights = vec![Light::Point { position: vec3(0.0, 0.0, 1.0), colour: Vec3::ONE }];
        let mut tree = Vec::new();
        interpolate_tree(&[*a], &[*b], 0.5, &mut tree);
        let mut node = tree[0];
        Shading { ambient: 0.25, lights }.shade(a, b, 0.5, vec3(0.0, 0.0, 5.0), &mut node);
        (tree[0], node)
    }

    #[test]
    fn equal_ends_give_their_colour_to_the_bit() {
        let mut random = rayreel_testkit::Random(7);
        let a = hit(vec3(0.3, 0.2, 0.9).normalized(), 0.7, 0.3);
        for _ in 0..1000 {
            let mut number = || random.signed();
            let a = hit(vec3(number(), number(), number()).normalized(), number(), number().abs());
            let (before, after) = shaded(&a, &a);
            assert_eq!((before.colour, before.local), (after.colour, after.local));
            assert_eq!(after.colour, a.colour);
        }
        let miss = Node { surface: None, ..a };
        assert_eq!(shaded(&miss, &miss).1, miss);
    }

    /// A white plane below a light: at x = -1 and 1 its light is 1/4 + sqrt(1/2), half way it is 5/4.
    #[test]
    fn light_between_two_points_is_computed() {
        let side = 0.25 + 0.5f32.sqrt();
        let up = vec3(0.0, 0.0, 1.0);
        for normal in [up, -up] {
            let (before, after) = shaded(&hit(normal, -1.0, side), &hit(normal, 1.0, side));
            assert_eq!(before.local, Vec3::splat(side));
            assert!((after.local.x - 1.25).abs() < 1.0e-6 && (after.colour.x - 1.375).abs() < 1.0e-6, "{after:?}");
        }
    }
}
