//! When two samples are similar enough to interpolate between them.
//!
//! Tests run in f64 on the stored f32 values, with `+ - * / sqrt` only; the one cosine is computed once, by the libm crate, so
//! it is the same on every machine.

use rayreel_formats::math::Vec3;

use super::view::{Point, SurfacePoint};
use super::{Limit, Similarity};

/// The tests of a policy, ready to run.
#[derive(Clone, Copy, Debug)]
pub struct Tests {
    object_id: bool,
    shadow: bool,
    /// Smallest cosine between the normals.
    normal_cos: Option<f64>,
    position: Option<f64>,
    plane: Option<f64>,
}

impl Tests {
    /// Prepares the tests of `similarity`.
    pub fn new(similarity: &Similarity) -> Self {
        let cosine = |limit: Limit| limit.value().map(|degrees| libm::cos(degrees.to_radians()));
        Self {
            object_id: similarity.object_id,
            shadow: similarity.shadow,
            normal_cos: cosine(similarity.normal_deg),
            position: similarity.position.value(),
            plane: similarity.plane.value(),
        }
    }

    /// True when all tests that are on pass. `a` is the sample with the lower coordinate. Two misses are similar, a hit and a
    /// miss never are.
    pub fn similar(&self, a: &Point, b: &Point) -> bool {
        match (&a.surface, &b.surface) {
            (None, None) => true,
            (Some(a), Some(b)) => self.similar_surfaces(a, b),
            _ => false,
        }
    }

    fn similar_surfaces(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        if self.object_id && a.object != b.object || self.shadow && a.shadows != b.shadows {
            return false;
        }
        let between = difference(b.position, a.position);
        let reach = f64::from(if b.t < a.t { b.t } else { a.t });
        self.normal_cos.is_none_or(|cosine| within_angle(a.normal, b.normal, cosine))
            && self.position.is_none_or(|limit| dot(between, between).sqrt() <= limit * reach)
            && self.plane.is_none_or(|limit| dot(between, wide(a.normal)).abs() <= limit * reach)
    }
}

/// True when the angle between `a` and `b` has at least this cosine. Lengths are divided out, since a unit vector of f32 is
/// not quite one: equal normals pass at any limit.
fn within_angle(a: Vec3, b: Vec3, cosine: f64) -> bool {
    let (a, b) = (wide(a), wide(b));
    dot(a, b) >= cosine * (dot(a, a) * dot(b, b)).sqrt()
}

fn wide(v: Vec3) -> [f64; 3] {
    v.to_array().map(f64::from)
}

fn difference(a: Vec3, b: Vec3) -> [f64; 3] {
    let (a, b) = (wide(a), wide(b));
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayreel_formats::math::vec3;
    use rayreel_formats::tile::Shadows;

    fn surface() -> SurfacePoint {
        let (normal, position) = (vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, -10.0));
        SurfacePoint { object: 1, shadows: Shadows(5), normal, position, t: 10.0 }
    }

    fn off() -> Similarity {
        let off = Limit::Off;
        Similarity { object_id: false, normal_deg: off, shadow: false, position: off, plane: off }
    }

    fn similar(rules: &Similarity, a: SurfacePoint, b: SurfacePoint) -> bool {
        let point = |s| Point { colour: Vec3::ZERO, surface: Some(s) };
        Tests::new(rules).similar(&point(a), &point(b))
    }

    #[test]
    fn each_test_can_be_switched() {
        let a = surface();
        let object = SurfacePoint { object: 2, ..a };
        assert!(similar(&off(), a, object));
        assert!(!similar(&Similarity { object_id: true, ..off() }, a, object));
        let shadow = SurfacePoint { shadows: Shadows(6), ..a };
        assert!(similar(&off(), a, shadow));
        assert!(!similar(&Similarity { shadow: true, ..off() }, a, shadow));
    }

    #[test]
    fn angles_are_inclusive_and_equal_normals_pass_at_zero() {
        let a = surface();
        let limit = |deg| Similarity { normal_deg: Limit::At(deg), ..off() };
        let tilted = |deg: f64| {
            let r = deg.to_radians();
            SurfacePoint { normal: vec3(libm::sin(r) as f32, 0.0, libm::cos(r) as f32), ..a }
        };
        assert!(similar(&limit(12.0), a, tilted(11.999)));
        assert!(!similar(&limit(12.0), a, tilted(12.001)));
        let odd = SurfacePoint { normal: vec3(0.3, 0.7, -0.2).normalized(), ..a };
        assert!(similar(&limit(0.0), odd, odd));
        assert!(similar(&limit(180.0), a, SurfacePoint { normal: -a.normal, ..a }));
    }

    #[test]
    fn distances_are_relative_to_the_shorter_ray() {
        let a = surface();
        let beside = SurfacePoint { position: vec3(1.0, 0.0, -10.0), t: 20.0, ..a };
        let behind = SurfacePoint { position: vec3(0.0, 0.0, -11.0), t: 11.0, ..a };
        let position = |v| Similarity { position: Limit::At(v), ..off() };
        assert!(similar(&position(0.1), a, beside) && !similar(&position(0.09), a, beside));
        let plane = |v| Similarity { plane: Limit::At(v), ..off() };
        assert!(similar(&plane(0.0), a, beside));
        assert!(similar(&plane(0.1), a, behind) && !similar(&plane(0.09), a, behind));
    }

    #[test]
    fn sky_is_like_sky_only() {
        let sky = Point { colour: Vec3::ZERO, surface: None };
        let hit = Point { colour: Vec3::ZERO, surface: Some(surface()) };
        let tests = Tests::new(&off());
        assert!(tests.similar(&sky, &sky) && !tests.similar(&sky, &hit) && !tests.similar(&hit, &sky));
    }
}
