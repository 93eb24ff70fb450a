//! Ray and triangle: the one intersection test of the tracer, the verifier and the hit column's predictor.

use crate::math::Vec3;
use crate::rays::Ray;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance in units of the ray direction's length.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
}

/// Intersects a ray with the triangle `corners`; a hit has `0 < t < t_max`. Both faces count.
///
/// Plücker edge tests on corners relative to the ray origin, as in Embree's robust mode: the test of an edge depends on
/// its two corners only and changes sign exactly when they swap, so no ray slips between two triangles that share an
/// edge.
#[inline(always)]
pub fn intersect(ray: &Ray, corners: [Vec3; 3], t_max: f32) -> Option<TriangleHit> {
    let [a, b, c] = corners.map(|corner| corner - ray.origin);
    let (e0, e1, e2) = (c - a, a - b, b - c);
    let u = e0.cross(c + a).dot(ray.direction);
    let v = e1.cross(a + b).dot(ray.direction);
    let w = e2.cross(b + c).dot(ray.direction);
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    if !inside {
        return None;
    }
    let normal = e1.cross(e0);
    let t = a.dot(normal) / ray.direction.dot(normal);
    // A ray in the plane of the triangle gives NaN or infinity here, which no comparison lets through.
    if t > 0.0 && t < t_max {
        let sum = (u + v) + w;
        Some(TriangleHit { t, u: u / sum, v: v / sum })
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    #[test]
    fn weights_belong_to_the_second_and_third_corner() {
        let (a, b, c) = (vec3(0.0, 0.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0));
        let target = a * 0.5 + b * 0.2 + c * 0.3;
        let ray = Ray { origin: target + vec3(0.0, 0.0, 4.0), direction: vec3(0.0, 0.0, -1.0), t_max: f32::MAX };
        let hit = intersect(&ray, [a, b, c], ray.t_max).expect("the ray goes through the triangle");
        assert!((hit.t - 4.0).abs() < 1e-6 && (hit.u - 0.2).abs() < 1e-6 && (hit.v - 0.3).abs() < 1e-6, "{hit:?}");
        assert!(intersect(&ray, [a, b, c], 4.0).is_none(), "t must stay below t_max");
        assert!(intersect(&ray, [a, c, b], ray.t_max).is_some(), "the back face counts");
        assert!(intersect(&Ray { direction: vec3(0.0, 0.0, 1.0), ..ray }, [a, b, c], ray.t_max).is_none(), "behind");
        assert!(intersect(&Ray { direction: vec3(1.0, 0.0, 0.0), ..ray }, [a, b, c], ray.t_max).is_none(), "parallel");
    }

    #[test]
    fn no_ray_slips_through_a_shared_edge() {
        // Points exactly on the edge, and a hair beside it, seen from afar: one of the two triangles must take the ray.
        let (a, b) = (vec3(-1.3, 0.7, 0.1), vec3(2.1, -0.4, 0.9));
        let (c, d) = (vec3(0.2, 3.0, -0.5), vec3(0.9, -3.0, 0.4));
        let origin = vec3(13.0, 7.0, 90.0);
        for i in 0..20_000u16 {
            let s = f32::from(i) / 20_000.0;
            let on_edge = a * (1.0 - s) + b * s;
            let ray = Ray { origin, direction: (on_edge - origin).normalized(), t_max: f32::MAX };
            let hit = |corners| intersect(&ray, corners, ray.t_max).is_some();
            assert!(hit([a, b, c]) || hit([b, a, d]), "slipped through at {s}");
        }
    }
}
