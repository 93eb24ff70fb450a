//! The hits column: triangle, `t` and shading normal of every hit.
//!
//! Given the triangle, `t` and the normal follow from the ray and the triangle by the functions that the tracer used,
//! so they cost one well-predicted bit each; any other value is stored whole. A ray in turn follows from its parent's
//! hit.

use super::classes::{ClassRays, CodingOrder};
use super::coder::{Bit, Coder, Decoder, Encoder};
use super::numbers::{Number, unzigzag, zigzag};
use super::rows::{Around, Rows};
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
    fn triangle<C: Coder>(&mut self, coder: &mut C, around: Around<Met>, last: u32, triangle: u32) -> u32 {
        let list = around.list();
        let Met(first) = list[0];
        // Most often all are there and agree: then there is one question to ask.
        let (near, count) = if first != 0 && list.iter().all(|near| near.0 == first) {
            if coder.bit(&mut self.same[0][4][4], first - 1 == triangle) {
                return first - 1;
            }
            ([first - 1; 4], 4)
        } else {
            let (near, count) = met(list);
            if let Some(same) = self.one_of(coder, &near[..count], triangle) {
                return same;
            }
            (near, count)
        };
        let from = if count > 0 { near[0] } else { last };
        let number = if count == 0 { &mut self.distance_far } else { &mut self.distance };
        let difference = triangle.wrapping_sub(from) as i32;
        from.wrapping_add(unzigzag(number.code(coder, zigzag(difference))) as u32)
    }

    /// Codes whether a triangle is one of those `near`, and gives it if so.
    fn one_of<C: Coder>(&mut self, coder: &mut C, near: &[u32], triangle: u32) -> Option<u32> {
        for (place, &candidate) in near.iter().enumerate() {
            if near[..place].contains(&candidate) {
                continue;
            }
            let agree = near[place..].iter().filter(|&&t| t == candidate).count();
            let model = &mut self.same[place][agree][near.len() - place];
            if coder.bit(model, candidate == triangle) {
                return Some(candidate);
            }
        }
        None
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
    let mut rays = (!computed).then(|| RayRebuilder::new(order.tree, order.rect, geometry));
    code(&mut coder, order, hits, (geometry, rays.as_mut()))?;
    Ok(coder.finish())
}

/// Decodes the hits of a tile; `rays` then knows all of them that others hang on.
///
/// # Errors
/// Says which triangle is not there.
pub fn decode(bytes: &[u8], order: &CodingOrder<'_>, rays: &mut RayRebuilder<'_>) -> Result<Vec<Hit>, String> {
    code(&mut Decoder::new(bytes), order, &[], (rays.geometry(), Some(rays)))
}

/// Without `rays`, whatever is given is known to be what follows from them.
fn code<C: Coder>(
    coder: &mut C,
    order: &CodingOrder<'_>,
    hits: &[Hit],
    (Geometry { bvh, .. }, mut rays): (Geometry<'_>, Option<&mut RayRebuilder<'_>>),
) -> Result<Vec<Hit>, String> {
    let CodingOrder { tree, rect, classes } = order;
    let (mut models, mut rows) = (HitModels::new(), Rows::new(*rect));
    let mut out = vec![Hit::MISS; tree.nodes.len()];
    let mut last = 0;
    for ClassRays { class, rays: list } in classes {
        rows.restart(*rect);
        for &(sample, node) in list {
            let index = node as usize;
            let shape = &tree.nodes[index];
            if !shape.hit {
                continue;
            }
            let given = if C::ENCODES { hits[index] } else { Hit::MISS };
            let x = rows.go_to(sample);
            let triangle = models.triangle(coder, rows.around(x), last, given.triangle);
            if triangle as usize >= bvh.triangles.len() {
                return Err(format!("a hit on triangle {triangle} of {}", bvh.triangles.len()));
            }
            let (t, normal) = match &mut rays {
                None => (given.t, given.normal),
                Some(rays) => {
                    let ray = rays.ray(sample, *class, node);
                    let met = intersect(&ray, bvh.corners(triangle as usize), f32::INFINITY);
                    let (t, u, v) = met.map_or((0.0, 0.0, 0.0), |hit| (hit.t, hit.u, hit.v));
                    (t, bvh.shading_normal(triangle as usize, u, v))
                }
            };
            let t = models.t(coder, t, given.t);
            let normal = models.normal(coder, normal, given.normal);
            out[index] = Hit { triangle, t, normal };
            // Only children need the surface.
            if let Some(rays) = rays.as_mut().filter(|_| shape.reflect || shape.refract) {
                rays.hit(node, &out[index]);
            }
            rows.set(x, Met(triangle + 1));
            last = triangle;
        }
    }
    Ok(out)
}

/// The triangle that a neighbour hit, plus one; 0 for none.
#[derive(Clone, Copy, Debug, Default)]
struct Met(u32);

/// The triangles of the neighbours that hit something, nearest first, and their number.
fn met(list: [Met; 4]) -> ([u32; 4], usize) {
    let (mut found, mut count) = ([0; 4], 0);
    for Met(triangle) in list {
        if triangle != 0 {
            found[count] = triangle - 1;
            count += 1;
        }
    }
    (found, count)
}
