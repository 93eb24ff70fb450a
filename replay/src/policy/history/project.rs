//! Where a point was in the picture of another camera.

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::Camera;

/// Finds the place of points in the sample grid of a camera, with `+ - * /` in f64 only.
#[derive(Clone, Debug)]
pub struct Projection {
    eye: [f64; 3],
    /// By these a point's offset from the eye gives its depth, and that times its column and row.
    depth: [f64; 3],
    column: [f64; 3],
    row: [f64; 3],
}

/// A place in the sample grid: the centre of sample (x, y) is at (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPlace {
    /// From the left, samples.
    pub x: f64,
    /// From the top, samples.
    pub y: f64,
    /// From the eye, scene units.
    pub distance: f64,
}

impl Projection {
    /// For the picture of `camera`.
    pub fn new(camera: &Camera) -> Self {
        let [corner, right, down] = [camera.corner, camera.right, camera.down].map(wide);
        let volume = dot(corner, cross(right, down));
        let scaled = |v: [f64; 3]| v.map(|v| v / volume);
        Self {
            eye: wide(camera.eye),
            depth: scaled(cross(right, down)),
            column: scaled(cross(down, corner)),
            row: scaled(cross(corner, right)),
        }
    }

    /// Where `point` is; nothing behind the eye.
    pub fn place(&self, point: Vec3) -> Option<GridPlace> {
        let point = wide(point);
        let offset = [point[0] - self.eye[0], point[1] - self.eye[1], point[2] - self.eye[2]];
        let depth = dot(offset, self.depth);
        // Written so that a NaN is nowhere.
        (depth > 0.0).then(|| GridPlace {
            x: dot(offset, self.column) / depth - 0.5,
            y: dot(offset, self.row) / depth - 0.5,
            distance: dot(offset, offset).sqrt(),
        })
    }
}

fn wide(v: Vec3) -> [f64; 3] {
    v.to_array().map(f64::from)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayreel_formats::math::vec3;
    use rayreel_formats::rays::primary;

    /// A point on the ray of a sample is at that sample, however far.
    #[test]
    fn points_of_rays_are_at_their_samples() {
        let camera = Camera {
            eye: vec3(1.0, 2.0, 3.0),
            corner: vec3(-0.9, 0.6, -1.1),
            right: vec3(0.01, 0.0, -0.002),
            down: vec3(0.001, -0.012, 0.0),
        };
        let projection = Projection::new(&camera);
        for (x, y, t) in [(0, 0, 1.0), (17, 5, 0.25), (99, 60, 40.0)] {
            let ray = primary(&camera, x, y);
            let place = projection.place(ray.origin + ray.direction * t).unwrap();
            let near = |a: f64, b: f64, by: f64| assert!((a - b).abs() < by, "{a}, not {b}");
            near(place.x, f64::from(x), 2.0e-3);
            near(place.y, f64::from(y), 2.0e-3);
            near(place.distance, f64::from(t), 1.0e-5 * f64::from(t));
            assert_eq!(projection.place(ray.origin - ray.direction * t), None, "behind the eye");
        }
    }
}
