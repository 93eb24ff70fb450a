//! The radiance column: local colours and child weights, all half floats.
//!
//! Weights follow from material and angle, so each costs one well-predicted bit. Colours are predicted from the
//! neighbours that hit the same object under the same lights. The bit patterns of half floats are close to logarithms:
//! shading that scales all channels moves the patterns alike. So red and blue are predicted to differ from their
//! neighbours as green did.

use super::classes::{ClassRays, CodingOrder};
use super::coder::{Bit, Coder, Decoder, Encoder};
use super::numbers::Number;
use super::rows::{Around, Rows};
use crate::bvh::Bvh;
use crate::half::Half3;
use crate::rays::{RayRebuilder, children};
use crate::tile::{Hit, Radiance, RayNode};

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
        if coder.doubtful_bit(sign, value < 0) { -magnitude } else { magnitude }
    }

    fn weight<C: Coder>(&mut self, coder: &mut C, child: usize, predicted: Half3, weight: Half3) -> Half3 {
        if coder.bit(&mut self.weight[child], predicted == weight) {
            return predicted;
        }
        Half3(weight.0.map(|w| coder.raw(16, u32::from(w)) as u16))
    }
}

/// Codes the radiance of a tile; both slices hold one entry a node. `rays` knows all hits that rays hang on; without it every
/// weight is known to be what follows from material and angle.
pub fn encode(
    order: &CodingOrder<'_>,
    hits: &[Hit],
    radiance: &[Radiance],
    bvh: &Bvh,
    rays: Option<&RayRebuilder<'_>>,
) -> Vec<u8> {
    let mut coder = Encoder::default();
    code(&mut coder, order, hits, radiance, (bvh, rays));
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
    rays: &RayRebuilder<'_>,
) -> Result<Vec<Radiance>, String> {
    let radiance = code(&mut Decoder::new(bytes), order, hits, &[], (rays.geometry().bvh, Some(rays)));
    let valid = |r: &Radiance| r.local.is_valid() && r.reflect.is_valid() && r.refract.is_valid();
    if radiance.iter().all(valid) { Ok(radiance) } else { Err("a colour is negative or not finite".into()) }
}

fn code<C: Coder>(
    coder: &mut C,
    order: &CodingOrder<'_>,
    hits: &[Hit],
    radiance: &[Radiance],
    (bvh, rays): (&Bvh, Option<&RayRebuilder<'_>>),
) -> Vec<Radiance> {
    let CodingOrder { tree, rect, classes } = order;
    let (mut models, mut rows) = (RadianceModels::new(), Rows::new(*rect));
    let mut out = vec![Radiance::default(); tree.nodes.len()];
    for ClassRays { rays: list, .. } in classes {
        rows.restart(*rect);
        for &(sample, node) in list {
            let index = node as usize;
            let given = if C::ENCODES { radiance[index] } else { Radiance::default() };
            let (x, shape) = (rows.go_to(sample), &tree.nodes[index]);
            let mut here = Near::new(bvh, shape, &hits[index]);
            let prediction = predict(&rows.around(x), &here);
            (here.colour, here.size) = colour(coder, &mut models, &prediction, given.local);
            out[index].local = here.colour;
            rows.set(x, here);
            // Only rays with children have weights.
            if !(shape.reflect || shape.refract) {
                continue;
            }
            let (reflect, refract) = match rays {
                None => (given.reflect, given.refract),
                Some(rays) => {
                    let known = rays.known(node).map(|known| (known, bvh.material(known.triangle as usize)));
                    let weights = known.map(|(hit, material)| children(&hit.surface, hit.direction, material));
                    let weights = weights.unwrap_or_default();
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

/// What a neighbour's ray met, and its colour.
#[derive(Clone, Copy, Default)]
struct Near {
    /// There is one.
    there: bool,
    object: u32,
    material: u32,
    shadows: u32,
    colour: Half3,
    /// The magnitude of its green residual: the activity that its neighbours see.
    size: u32,
}

impl Near {
    /// The colour is still to come.
    #[inline(always)]
    fn new(bvh: &Bvh, node: &RayNode, hit: &Hit) -> Self {
        let (mut object, mut material) = (u32::MAX, 0);
        if node.hit {
            let triangle = &bvh.triangles[hit.triangle as usize];
            (object, material) = (triangle.object, triangle.material);
        }
        Self { there: true, object, material, shadows: node.shadows.0, ..Self::default() }
    }

    #[inline(always)]
    fn is_like(&self, other: &Self) -> bool {
        self.there && (self.object, self.material, self.shadows) == (other.object, other.material, other.shadows)
    }

    #[inline(always)]
    fn values(&self) -> [i32; 3] {
        self.colour.0.map(i32::from)
    }
}

/// A colour to expect, how far to trust it (2 most), and the activity around.
struct Prediction {
    colour: [i32; 3],
    trust: usize,
    activity: usize,
}

#[inline(always)]
fn predict(around: &Around<Near>, here: &Near) -> Prediction {
    let Around { w, n, nw, ne } = around;
    let [alike_w, alike_n, alike_nw] = [w, n, nw].map(|near| near.is_like(here));
    let sum = if alike_w { w.size } else { 0 } + if alike_n { n.size } else { 0 };
    let activity = ((32 - sum.leading_zeros()) as usize).min(ACTIVITIES - 1);
    let (colour, trust) = match (alike_w, alike_n, alike_nw) {
        (true, true, true) => {
            let (w, n, nw) = (w.values(), n.values(), nw.values());
            (std::array::from_fn(|c| median_edge(w[c], n[c], nw[c])), 2)
        }
        (true, true, false) => {
            let (w, n) = (w.values(), n.values());
            (std::array::from_fn(|c| (w[c] + n[c]) / 2), 2)
        }
        (true, ..) => (w.values(), 1),
        (_, true, _) => (n.values(), 1),
        (.., true) => (nw.values(), 1),
        _ if ne.is_like(here) => (ne.values(), 1),
        _ if w.there => (w.values(), 0),
        _ if n.there => (n.values(), 0),
        _ => ([0; 3], 0),
    };
    Prediction { colour, trust, activity }
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
