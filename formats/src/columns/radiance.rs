//! The radiance column: local colours and child weights, all half floats.
//!
//! Weights follow from material and angle, so each costs one well-predicted bit. Colours are predicted from the
//! neighbours that hit the same object under the same lights. The bit patterns of half floats are close to logarithms:
//! shading that scales all channels moves the patterns alike. So red and blue are predicted to differ from their
//! neighbours as green did.

use super::classes::{ClassRays, CodingOrder, Neighbours, Raster};
use super::coder::{Bit, Coder, Decoder, Encoder, Number};
use crate::half::Half3;
use crate::rays::{Geometry, RayRebuilder, children};
use crate::tile::{Hit, Radiance, Tree};

/// Number of contexts by activity: how large the residuals of the neighbours were, as a number of bits.
const ACTIVITIES: usize = 14;

struct RadianceModels {
    /// Magnitudes of residuals, per channel, trust in the prediction, and activity.
    residual: Vec<Number>,
    sign: [[Bit; 3]; 3],
    weight: [Bit; 2],
}

impl RadianceModels {
    fn new() -> Self {
        Self {
            residual: vec![Number::default(); 3 * 3 * ACTIVITIES],
            sign: [[Bit::EVEN; 3]; 3],
            weight: [Bit::of(65_000, 30); 2],
        }
    }

    /// Codes a signed residual of `channel`: magnitude, then sign in the context of the last channel's sign.
    fn residual<C: Coder>(&mut self, coder: &mut C, channel: usize, context: usize, other: i32, value: i32) -> i32 {
        let model = &mut self.residual[channel * 3 * ACTIVITIES + context];
        let magnitude = model.code(coder, value.unsigned_abs()).min(0xffff) as i32;
        if magnitude == 0 {
            return 0;
        }
        let sign = &mut self.sign[channel][(other.signum() + 1) as usize];
        if coder.bit(sign, value < 0) { -magnitude } else { magnitude }
    }

    fn weight<C: Coder>(&mut self, coder: &mut C, child: usize, predicted: Half3, weight: Half3) -> Half3 {
        if coder.bit(&mut self.weight[child], predicted == weight) {
            return predicted;
        }
        Half3(weight.0.map(|w| coder.raw(16, u32::from(w)) as u16))
    }
}

/// Codes the radiance of a tile; both slices hold one entry a node. Where they are `computed`, every weight is known to be
/// what follows from material and angle, and the rays need not be rebuilt to see it.
pub fn encode(
    order: &CodingOrder<'_>,
    hits: &[Hit],
    radiance: &[Radiance],
    geometry: Geometry<'_>,
    computed: bool,
) -> Vec<u8> {
    let mut coder = Encoder::default();
    code(&mut coder, order, hits, radiance, geometry, computed);
    coder.finish()
}

/// Decodes the radiance of a tile.
///
/// # Errors
/// Says so when a value is not a non-negative finite number.
pub fn decode(
    bytes: &[u8],
    order: &CodingOrder<'_>,
    hits: &[Hit],
    geometry: Geometry<'_>,
) -> Result<Vec<Radiance>, String> {
    let radiance = code(&mut Decoder::new(bytes), order, hits, &[], geometry, false);
    let valid = |r: &Radiance| r.local.is_valid() && r.reflect.is_valid() && r.refract.is_valid();
    if radiance.iter().all(valid) { Ok(radiance) } else { Err("a colour is negative or not finite".into()) }
}

fn code<C: Coder>(
    coder: &mut C,
    order: &CodingOrder<'_>,
    hits: &[Hit],
    radiance: &[Radiance],
    geometry: Geometry<'_>,
    computed: bool,
) -> Vec<Radiance> {
    let CodingOrder { tree, rect, classes } = order;
    let mut models = RadianceModels::new();
    let mut raster = Raster::new(*rect);
    let mut rebuilt = (!computed).then(|| RayRebuilder::new(tree, *rect, geometry));
    let surfaces: Vec<_> = tree.nodes.iter().zip(hits).map(|(node, hit)| surface_of(geometry, node.hit, hit)).collect();
    let mut out = vec![Radiance::default(); tree.nodes.len()];
    // Per node the magnitude of its green residual: the activity that its neighbours will see.
    let mut sizes = vec![0u32; tree.nodes.len()];
    for ClassRays { class, rays } in classes {
        raster.clear();
        for &(sample, node) in rays {
            let index = node as usize;
            let given = if C::ENCODES { radiance[index] } else { Radiance::default() };
            let near = raster.neighbours(sample);
            let prediction = predict(&near, index, tree, &surfaces, &out, &sizes);
            (out[index].local, sizes[index]) = colour(coder, &mut models, &prediction, given.local);
            raster.set(sample, node);
            let shape = &tree.nodes[index];
            // Only rays with children have weights, and weights need the ray.
            if !(shape.reflect || shape.refract) {
                continue;
            }
            let (reflect, refract) = match &mut rebuilt {
                None => (given.reflect, given.refract),
                Some(rebuilt) => {
                    let ray = rebuilt.ray(sample, *class, node);
                    let surface = rebuilt.hit(node, &hits[index]);
                    let material = geometry.bvh.material(hits[index].triangle as usize);
                    let weights = surface.map(|s| children(&s, ray.direction, material)).unwrap_or_default();
                    (weights.reflect.unwrap_or_default(), weights.refract.unwrap_or_default())
                }
            };
            if shape.reflect {
                out[index].reflect = models.weight(coder, 0, reflect, given.reflect);
            }
            if shape.refract {
                out[index].refract = models.weight(coder, 1, refract, given.refract);
            }
        }
    }
    out
}

/// A colour to expect, how far to trust it (2 most), and the activity around.
struct Prediction {
    colour: [i32; 3],
    trust: usize,
    activity: usize,
}

fn predict(
    near: &Neighbours,
    index: usize,
    tree: &Tree,
    surfaces: &[(u32, u32)],
    out: &[Radiance],
    sizes: &[u32],
) -> Prediction {
    let here = surfaces[index];
    let alike = |n: Option<u32>| {
        n.map(|n| n as usize).filter(|&n| surfaces[n] == here && tree.nodes[n].shadows == tree.nodes[index].shadows)
    };
    let values = |n: usize| out[n].local.0.map(i32::from);
    let (w, n, nw, ne) = (alike(near.w), alike(near.n), alike(near.nw), alike(near.ne));
    let sum: u32 = [w, n].into_iter().flatten().map(|n| sizes[n]).sum();
    let activity = (32 - sum.leading_zeros()) as usize;
    let activity = activity.min(ACTIVITIES - 1);
    let (colour, trust) = match (w, n, nw) {
        (Some(w), Some(n), Some(nw)) => {
            let (w, n, nw) = (values(w), values(n), values(nw));
            (std::array::from_fn(|c| median_edge(w[c], n[c], nw[c])), 2)
        }
        (Some(w), Some(n), None) => {
            let (w, n) = (values(w), values(n));
            (std::array::from_fn(|c| (w[c] + n[c]) / 2), 2)
        }
        _ => match w.or(n).or(nw).or(ne) {
            Some(n) => (values(n), 1),
            None => (near.w.or(near.n).map_or([0; 3], |n| values(n as usize)), 0),
        },
    };
    Prediction { colour, trust, activity }
}

/// Object and material of what a node hit; the sky counts as one.
fn surface_of(geometry: Geometry<'_>, is_hit: bool, hit: &Hit) -> (u32, u32) {
    if !is_hit {
        return (u32::MAX, 0);
    }
    let triangle = geometry.bvh.triangles[hit.triangle as usize];
    (triangle.object, triangle.material)
}

/// The predictor of LOCO-I: the plane through the three, held between west and north.
fn median_edge(w: i32, n: i32, nw: i32) -> i32 {
    if nw >= w.max(n) {
        w.min(n)
    } else if nw <= w.min(n) {
        w.max(n)
    } else {
        w + n - nw
    }
}

/// Codes a colour; gives it and the magnitude of its green residual.
fn colour<C: Coder>(coder: &mut C, models: &mut RadianceModels, prediction: &Prediction, given: Half3) -> (Half3, u32) {
    let context = prediction.trust * ACTIVITIES + prediction.activity;
    let mut result = [0u16; 3];
    let mut green = 0;
    for channel in [1, 0, 2] {
        let follow = if channel == 1 || prediction.trust == 0 { 0 } else { green };
        let expected = (prediction.colour[channel] + follow).clamp(0, 0x7bff);
        let residual = i32::from(given.0[channel]) - expected;
        let residual = models.residual(coder, channel, context, green, residual);
        result[channel] = (expected + residual).clamp(0, 0xffff) as u16;
        if channel == 1 {
            green = residual;
        }
    }
    (Half3(result), green.unsigned_abs())
}
