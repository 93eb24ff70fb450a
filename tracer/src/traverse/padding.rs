//! How much boxes grow, so that no hit is lost to rounding.
//!
//! The intersection test accepts a ray that passes just outside an edge, by as much as its rounding; the box must accept
//! that ray too, and one that lies in the plane of one of its sides. The test subtracts the ray's origin from each corner, and
//! multiplies and adds what is left: about ten roundings, each of at most 2^-24 of the distance to the corner. So a box
//! has to grow by some 2^-21 of the distance from the ray's origin to the farthest point of it; it grows by twice that.
//!
//! To find that distance at each visit of a node would take time there, and saves next to no visits. It is at most the way from
//! the origin to some point of the scene and from there to the farthest point of the box. The first part depends on the ray
//! alone, the second on the box alone, and both are added before the traversal. The point is the median of the vertices: most
//! rays and most boxes are near it, even on a floor that reaches to the horizon.

use rayreel_formats::bvh::{Aabb, Bvh};
use rayreel_formats::math::{Vec3, vec3};
use rayreel_scenes::BOX_PADDING;

use super::lanes::{Lanes, Lanes3};

/// The point that distances go by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Padding {
    /// The median of the vertices, axis by axis; of an even number the upper one.
    middle: Vec3,
}

impl Padding {
    pub fn new(bvh: &Bvh) -> Self {
        let median = |axis: fn(Vec3) -> f32| {
            let mut all: Vec<f32> = bvh.vertices.iter().map(|v| axis(v.position)).collect();
            let middle = all.len() / 2;
            if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(middle, f32::total_cmp).1 }
        };
        Self { middle: vec3(median(|p| p.x), median(|p| p.y), median(|p| p.z)) }
    }

    /// A box grown by its own part of the padding.
    pub fn grown(self, Aabb { min, max }: Aabb) -> Aabb {
        let away =
            vec3((min - self.middle).max_abs(), (max - self.middle).max_abs(), 0.0).max_component() * BOX_PADDING;
        let pad = |v: Vec3| vec3(of(away, v.x), of(away, v.y), of(away, v.z));
        Aabb { min: min - pad(min), max: max + pad(max) }
    }

    /// The part of a ray that starts at `origin`, on each axis.
    #[inline(always)]
    pub fn of_ray(self, origin: Vec3) -> Vec3 {
        let away = (origin - self.middle).max_abs() * BOX_PADDING;
        vec3(of(away, origin.x), of(away, origin.y), of(away, origin.z))
    }

    /// [`Padding::of_ray`] in eight lanes.
    #[inline(always)]
    pub fn of_rays<L: Lanes>(self, origin: Lanes3<L>) -> Lanes3<L> {
        let away = (origin - Lanes3::splat(self.middle)).max_abs() * L::splat(BOX_PADDING);
        let of = |coordinate: L| away + coordinate.abs() * L::splat(f32::EPSILON);
        Lanes3 { x: of(origin.x), y: of(origin.y), z: of(origin.z) }
    }
}

/// The padding of a coordinate: it has to outlast its own addition.
#[inline(always)]
fn of(away: f32, coordinate: f32) -> f32 {
    away + coordinate.abs() * f32::EPSILON
}
