//! The hits column: triangle, `t` and shading normal of every hit.
//!
//! Given the triangle, `t` and the normal follow from the ray and the triangle by the functions that the tracer used,
//! so they cost one well-predicted bit each; any other value is stored whole. A ray in turn follows from its parent's
//! hit.

use super::classes::{ClassRays, CodingOrder, Neighbours, Raster};
use super::coder::{Bit, Coder, Decoder, Encoder, Number, unzigzag, zigzag};
use crate::intersect::intersect;
use crate::oct::Oct;
use crate::rays::{Geometry, RayRebuilder};
use crate::tile::Hit;

struct HitModels {
    /// Is it this neighbour's triangle? By the neighbour's place in the list, how many from there on have the same
    /// triangle, and how many are left.
    same: [[[Bit; 5]; 5]; 4],
    /// Distance in leaf order from the first neighbour's triangle.
    distance: Number,
    /// Distance from the triangle coded last, where no neighbour hit anything.
    distance_far: Number,
    t: Bit,
    normal: Bit,
}

impl HitModels {
    fn new() -> Self {
        // To begin with, the predictions of `t` and normal are taken to be right.
        let sure = Bit::of(65_000, 30);
        Self {
            same: [[[Bit::EVEN; 5]; 5]; 4],
            distance: Number::default(),
            distance_far: Number::default(),
            t: sure,
            normal: sure,
        }
    }

    /// Codes a triangle: one of the neighbours', or its distance in leaf order from the first neighbour's, or from the
    /// `last` one coded where there is no neighbour.
    fn triangle<C: Coder>(&mut self, coder: &mut C, near: &[u32], last: u32, triangle: u32) -> u32 {
        for (place, &candidate) in near.iter().enumerate() {
            if near[..place].contains(&candidate) {
                continue;
            }
            let agree = near[place..].iter().filter(|&&t| t == candidate).count();
            let model = &mut self.same[place][agree][near.len() - place];
            if coder.bit(model, candidate == triangle) {
                return candidate;
            }
        }
        let from = near.first().copied().unwrap_or(last);
        let number = if near.is_empty() { &mut self.distance_far } else { &mut self.distance };
        let difference = triangle.wrapping_sub(from) as i32;
        from.wrapping_add(unzigzag(number.code(coder, zigzag(difference))) as u32)
    }

    fn t<C: Coder>(&mut self, coder: &mut C, predicted: f32, t: f32) -> f32 {
        if coder.bit(&mut self.t, predicted.to_bits() == t.to_bits()) {
            return predicted;
        }
        f32::from_bits(coder.raw(32, t.to_bits()))
    }

    fn normal<C: Coder>(&mut self, coder: &mut C, predicted: Oct, normal: Oct) -> Oct {
        if coder.bit(&mut self.normal, predicted == normal) {
            return predicted;
        }
        Oct::from_bits(coder.raw(32, normal.to_bits()))
    }
}

/// Codes the hits of a tile; `hits` holds one entry a node. Where they are `computed`, every `t` and normal is known to
/// be what follows from the ray, and the rays need not be rebuilt to see it.
///
/// # Errors
/// Says which triangle is not there.
pub fn encode(
    order: &CodingOrder<'_>,
    hits: &[Hit],
    geometry: Geometry<'_>,
    computed: bool,
) -> Result<Vec<u8>, String> {
    let mut coder = Encoder::default();
    code(&mut coder, order, hits, geometry, computed)?;
    Ok(coder.finish())
}

/// Decodes the hits of a tile.
///
/// # Errors
/// Says which triangle is not there.
pub fn decode(bytes: &[u8], order: &CodingOrder<'_>, geometry: Geometry<'_>) -> Result<Vec<Hit>, String> {
    code(&mut Decoder::new(bytes), order, &[], geometry, false)
}

fn code<C: Coder>(
    coder: &mut C,
    order: &CodingOrder<'_>,
    hits: &[Hit],
    geometry: Geometry<'_>,
    computed: bool,
) -> Result<Vec<Hit>, String> {
    let CodingOrder { tree, rect, classes } = order;
    let mut models = HitModels::new();
    let mut raster = Raster::new(*rect);
    let mut rays = (!computed).then(|| RayRebuilder::new(tree, *rect, geometry));
    let mut out = vec![Hit::MISS; tree.nodes.len()];
    let mut last = 0;
    for ClassRays { class, rays: list } in classes {
        raster.clear();
        for &(sample, node) in list {
            let index = node as usize;
            if !tree.nodes[index].hit {
                continue;
            }
            let given = if C::ENCODES { hits[index] } else { Hit::MISS };
            let near = distinct_order(&raster.neighbours(sample));
            let triangle = models.triangle(coder, &near.0[..near.1], last, given.triangle);
            if triangle as usize >= geometry.bvh.triangles.len() {
                return Err(format!("a hit on triangle {triangle} of {}", geometry.bvh.triangles.len()));
            }
            let (t, normal) = match &mut rays {
                None => (given.t, given.normal),
                Some(rays) => {
                    let ray = rays.ray(sample, *class, node);
                    let corners = geometry.bvh.corners(triangle as usize);
                    let met = intersect(&ray, corners, f32::INFINITY);
                    let (t, u, v) = met.map_or((0.0, 0.0, 0.0), |hit| (hit.t, hit.u, hit.v));
                    (t, geometry.bvh.shading_normal(triangle as usize, u, v))
                }
            };
            let t = models.t(coder, t, given.t);
            let normal = models.normal(coder, normal, given.normal);
            out[index] = Hit { triangle, t, normal };
            // Only children need the surface.
            if let Some(rays) = rays.as_mut().filter(|_| tree.nodes[index].reflect || tree.nodes[index].refract) {
                rays.hit(node, &out[index]);
            }
            raster.set(sample, triangle);
            last = triangle;
        }
    }
    Ok(out)
}

/// The triangles of the neighbours that hit something, nearest first, and their number.
fn distinct_order(near: &Neighbours) -> ([u32; 4], usize) {
    let mut list = [0; 4];
    let mut count = 0;
    for triangle in [near.w, near.n, near.nw, near.ne].into_iter().flatten() {
        list[count] = triangle;
        count += 1;
    }
    (list, count)
}
