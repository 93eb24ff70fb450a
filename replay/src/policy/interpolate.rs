//! Samples between two similar ones.
//!
//! A value is measured from the nearer end, `near + (far - near) * (distance / gap)`; half way, the first end is the nearer.
//! So the ends are exact, equal ends give exactly that value, and both directions are treated alike.

use rayreel_formats::math::Vec3;

use super::tree::{Node, SurfacePoint, children};

/// The nearer of two ends for the sample `step` of `gap` samples after the first, and the share of the other one: whether the
/// ends change places, and `distance / gap`.
#[inline]
pub fn nearer(step: u32, gap: u32) -> (bool, f32) {
    let swap = 2 * step > gap;
    let distance = if swap { gap - step } else { step };
    (swap, distance as f32 / gap as f32)
}

/// The hit `s` of the way from `near` to `far`. Position and `t` are linear, the normal is linear and renormalised; object and
/// shadows are those of the nearer end (both ends agree where they are tested).
pub fn surface(near: &SurfacePoint, far: &SurfacePoint, s: f32) -> SurfacePoint {
    let normal = mix(near.normal, far.normal, s);
    let length = normal.length();
    SurfacePoint {
        object: near.object,
        shadows: near.shadows,
        // Opposite normals cancel half way: then the nearer end's stands for both.
        normal: if length > 0.0 { normal.normalized() } else { near.normal },
        position: mix(near.position, far.position, s),
        t: near.t + (far.t - near.t) * s,
    }
}

/// The value `s` of the way from `near` to `far`.
#[inline]
pub fn mix(near: Vec3, far: Vec3, s: f32) -> Vec3 {
    near + (far - near) * s
}

/// The tree between two trees, `share` of the way from `near` to `far` (at most a half).
pub fn between(near: &[Node], far: &[Node], share: f32) -> Vec<Node> {
    let mut tree = Vec::with_capacity(near.len());
    interpolate_tree(near, far, share, &mut tree);
    tree
}

/// Appends the tree between two trees of similar samples, `s` of the way from `near` to `far` (at most a half). Hits that
/// both have are interpolated one by one; where one has a child that the other lacks, the subtree becomes a single hit with
/// the interpolated colour. The local colour of every hit is interpolated for itself: texture tests look at it.
pub fn interpolate_tree(near: &[Node], far: &[Node], s: f32, out: &mut Vec<Node>) {
    let at = out.len();
    let (a, b) = (&near[0], &far[0]);
    let mut node = interpolate_node(a, b, s);
    node.colour = mix(a.colour, b.colour, s);
    if !a.branches_as(b) {
        (node.reflect, node.refract) = (None, None);
        out.push(node);
        return;
    }
    out.push(node);
    for ((_, near), (_, far)) in children(near).zip(children(far)) {
        interpolate_tree(near, far, s, out);
    }
    out[at].len = (out.len() - at) as u32;
}

/// The hit between two: local colour, weights and surface; its subtree is still to come.
pub fn interpolate_node(near: &Node, far: &Node, s: f32) -> Node {
    let weight = |a: Option<Vec3>, b: Option<Vec3>| a.zip(b).map(|(a, b)| mix(a, b, s));
    Node {
        surface: match (&near.surface, &far.surface) {
            (Some(near), Some(far)) => Some(surface(near, far, s)),
            (near, _) => *near,
        },
        local: mix(near.local, far.local, s),
        reflect: weight(near.reflect, far.reflect),
        refract: weight(near.refract, far.refract),
        len: 1,
        age: near.age.max(far.age),
        ..*near
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rayreel_formats::math::vec3;
    use rayreel_formats::tile::Shadows;

    fn point(colour: [f32; 3], normal: [f32; 3], t: f32, object: u32) -> Node {
        let normal = Vec3::from(normal).normalized();
        let position = vec3(t, -t, 2.0 * t);
        Node {
            surface: Some(SurfacePoint { object, shadows: Shadows(object), normal, position, t }),
            local: colour.into(),
            colour: colour.into(),
            reflect: None,
            refract: None,
            hit_rays: 1,
            rays: 1,
            len: 1,
            age: 0,
        }
    }

    /// The sample `step` of `gap` samples after `a`.
    fn interpolate(a: &Node, b: &Node, step: u32, gap: u32) -> Node {
        let (swap, s) = nearer(step, gap);
        let (near, far) = if swap { (b, a) } else { (a, b) };
        let mut tree = Vec::new();
        interpolate_tree(std::slice::from_ref(near), std::slice::from_ref(far), s, &mut tree);
        tree[0]
    }

    fn any_point() -> impl Strategy<Value = Node> {
        let colour = prop::array::uniform3(0.0f32..1000.0);
        let normal = prop::array::uniform3(0.1f32..1.0);
        (colour, normal, 0.01f32..1.0e4, 0u32..3).prop_map(|(c, n, t, object)| point(c, n, t, object))
    }

    proptest! {
        #[test]
        fn ends_are_exact_and_the_middle_stays_between(a in any_point(), b in any_point(), gap in 1u32..9, step in 0u32..9) {
            prop_assert_eq!(interpolate(&a, &b, 0, gap).colour, a.colour);
            prop_assert_eq!(interpolate(&a, &b, gap, gap).colour, b.colour);
            let step = step.min(gap);
            let c = interpolate(&a, &b, step, gap);
            for ((a, b), c) in a.colour.to_array().into_iter().zip(b.colour.to_array()).zip(c.colour.to_array()) {
                prop_assert!(c >= a.min(b) && c <= a.max(b));
            }
            let surface = c.surface.unwrap();
            prop_assert!((surface.normal.length() - 1.0).abs() < 1.0e-6);
            // Equal ends are kept to the last bit, at every step and gap.
            let flat = interpolate(&a, &a, step, gap);
            prop_assert_eq!(flat.colour, a.colour);
            prop_assert_eq!(flat.surface.unwrap().position, a.surface.unwrap().position);
            // Both directions agree, but for the tie half way.
            if 2 * step != gap {
                prop_assert_eq!(interpolate(&b, &a, gap - step, gap), c);
            }
        }
    }

    #[test]
    fn by_hand() {
        let (a, b) = (point([0.0, 1.0, 4.0], [1.0, 0.0, 0.0], 2.0, 1), point([4.0, 1.0, 0.0], [0.0, 1.0, 0.0], 6.0, 2));
        let c = interpolate(&a, &b, 1, 4);
        assert_eq!(c.colour, vec3(1.0, 1.0, 3.0));
        let surface = c.surface.unwrap();
        assert_eq!((surface.t, surface.object, surface.shadows), (3.0, 1, Shadows(1)));
        assert_eq!(surface.normal, vec3(0.75, 0.25, 0.0).normalized());
        assert_eq!(interpolate(&a, &b, 3, 4).surface.unwrap().object, 2);
        assert_eq!(interpolate(&a, &b, 2, 4).surface.unwrap().object, 1, "half way the first end is the nearer");
    }

    #[test]
    fn opposite_normals_keep_the_nearer() {
        let (a, b) = (point([0.0; 3], [0.0, 0.0, 1.0], 1.0, 1), point([0.0; 3], [0.0, 0.0, -1.0], 1.0, 1));
        assert_eq!(interpolate(&a, &b, 1, 2).surface.unwrap().normal, vec3(0.0, 0.0, 1.0));
    }
}
