//! When two samples are similar enough to interpolate between them.
//!
//! Tests run in f64 on the stored f32 values, with `+ - * / sqrt` only; the one cosine is computed once, by the libm crate, so
//! it is the same on every machine.
//!
//! **Colour as displayed.** Colours are linear, but eyes and PSNR judge them on a curve that is close to a square root. The
//! difference that a contribution makes in a sample of colour `c` is taken as its share of `sqrt(c)`: see [`difference`].
//!
//! **The colour limit** is not one number for all: see [`Tests::colour_limit`].

use rayreel_formats::math::Vec3;

use super::tree::{Node, SurfacePoint, children};
use super::{First, Limit, Similarity};

/// The tests of a policy, ready to run.
#[derive(Clone, Copy, Debug)]
pub struct Tests {
    object_id: bool,
    shadow: bool,
    /// Smallest cosine between the normals.
    normal_cos: Option<f64>,
    position: Option<f64>,
    plane: Option<f64>,
    convexity: Option<f64>,
    texture: Option<f64>,
    colour: Option<f64>,
    /// A well predicted middle sample passes the colour test for its halves.
    pub predict: bool,
    secondary: bool,
    unlike: f64,
    unlike_primary: f64,
    first: First,
}

/// How much work comparing took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compared {
    /// Pairs of hits that were looked at: what a similarity kernel is busy with.
    pub pairs: u32,
    /// Differences of colours that were computed.
    pub colours: u32,
}

impl Tests {
    /// Prepares the tests of `similarity`, with the colour limit multiplied by `relax`.
    pub fn new(similarity: &Similarity, relax: f64) -> Self {
        let cosine = |limit: Limit| limit.value().map(|degrees| libm::cos(degrees.to_radians()));
        Self {
            object_id: similarity.object_id,
            shadow: similarity.shadow,
            normal_cos: cosine(similarity.normal_deg),
            position: similarity.position.value(),
            plane: similarity.plane.value(),
            convexity: similarity.convexity.value(),
            texture: similarity.texture.value(),
            colour: similarity.colour.value().map(|limit| limit * relax),
            predict: similarity.predict,
            secondary: similarity.secondary,
            unlike: similarity.unlike.value().unwrap_or(0.0),
            unlike_primary: similarity.unlike_primary.value().unwrap_or(0.0),
            first: similarity.first,
        }
    }

    /// The largest colour difference that passes across a gap of `gap` samples whose ends cost `rays` rays each; `None` if
    /// colours are not tested.
    ///
    /// The limit is `colour * (2 / gap) * sqrt(rays / 3)`: stricter across wide gaps, more lenient where samples are
    /// expensive. It weighs error against rays. An edge of contrast `d` between the ends leaves an error that grows with `d^2`
    /// and with the number of samples between them. Finding the edge costs the rays of a few samples. Both are in balance
    /// where `d^2 * gap^2` is in proportion to the rays of a sample. `colour` is the limit across a gap of two samples that
    /// cost three rays each: a primary ray and two more.
    pub fn colour_limit(&self, gap: u32, rays: u32) -> Option<f64> {
        let limit = self.colour?;
        Some(limit * (2.0 / f64::from(gap)) * costs(rays))
    }

    /// Tests look at colours first.
    pub fn colours_first(&self) -> bool {
        self.first == First::Colours
    }

    /// True when all tests that are on pass for two samples `gap` apart. `a` is the one with the lower coordinate. Without a
    /// colour test two misses are similar; a hit and a miss never are.
    ///
    /// One of the two may be the traced middle of a gap twice as wide. `foreseen` then says how far its colour was off the one
    /// that interpolation would have given it. The smaller of this and the difference between `a` and `b` is tested.
    pub fn similar(&self, a: &[Node], b: &[Node], gap: u32, foreseen: f64, compared: &mut Compared) -> bool {
        let limit = self.colour_limit(gap, rays_of(a, b));
        let colour = |compared: &mut Compared| {
            compared.colours += u32::from(limit.is_some());
            let totals = (a[0].colour, b[0].colour);
            let seen = difference(totals, totals);
            if foreseen < seen { foreseen } else { seen }
        };
        let mut known = None;
        if let (true, Some(limit)) = (self.colours_first(), limit) {
            let colour = *known.insert(colour(compared));
            if !within(colour, limit) {
                return false;
            }
            if colour < self.unlike_primary * limit {
                return same_kind(a, b);
            }
        }
        compared.pairs += 1;
        let is_alike = self.alike_hits(&a[0], &b[0], compared);
        if !is_alike && (self.unlike_primary == 0.0 || limit.is_none() || !same_kind(a, b)) {
            return false;
        }
        let Some(limit) = limit else { return !self.secondary || self.alike_below(a, b, compared) };
        let colour = known.unwrap_or_else(|| colour(compared));
        if colour < limit * self.unlike_primary {
            return true;
        }
        // A NaN is never within a limit.
        let is_near = is_alike && within(colour, limit);
        is_near && (!self.secondary || colour < limit * self.unlike || self.alike_below(a, b, compared))
    }

    /// As [`Tests::similar`] for two subtrees below similar hits, whose contributions reach the samples with weights
    /// `weights`; the samples' whole colours are `totals`.
    pub fn similar_below(
        &self,
        (a, b): (&[Node], &[Node]),
        weights: (Vec3, Vec3),
        totals: (Vec3, Vec3),
        gap: u32,
        compared: &mut Compared,
    ) -> bool {
        compared.pairs += 1;
        let mut margin = 0.0;
        if let Some(limit) = self.colour_limit(gap, rays_of(a, b)) {
            compared.colours += 1;
            let shares = (weights.0.times(a[0].colour), weights.1.times(b[0].colour));
            let colour = difference(shares, totals);
            if !within(colour, limit) {
                return false;
            }
            margin = limit * self.unlike - colour;
        }
        margin > 0.0 || self.alike_hits(&a[0], &b[0], compared) && self.alike_below(a, b, compared)
    }

    /// True when the hits themselves are alike in their attributes.
    pub fn alike_hits(&self, a: &Node, b: &Node, compared: &mut Compared) -> bool {
        match (&a.surface, &b.surface) {
            (None, None) => true,
            (Some(x), Some(y)) => {
                self.alike_surfaces(x, y)
                    && self.texture.is_none_or(|limit| {
                        compared.colours += 1;
                        let locals = (a.local, b.local);
                        within(difference(locals, locals), limit)
                    })
            }
            _ => false,
        }
    }

    /// True when two hits are on one object and their normals are similar: what they reflect and refract is between theirs,
    /// whatever light falls on them.
    pub fn one_surface(&self, a: &Node, b: &Node) -> bool {
        match (&a.surface, &b.surface) {
            (Some(x), Some(y)) => {
                x.object == y.object && self.normal_cos.is_none_or(|cosine| within_angle(x.normal, y.normal, cosine))
            }
            _ => false,
        }
    }

    /// True when the local colours of two hits may stand for what is between them.
    pub fn alike_locals(
        &self,
        (a, b): (&Node, &Node),
        weights: (Vec3, Vec3),
        totals: (Vec3, Vec3),
        gap: u32,
        compared: &mut Compared,
    ) -> bool {
        self.colour_limit(gap, a.hit_rays.midpoint(b.hit_rays)).is_none_or(|limit| {
            compared.colours += 1;
            let shares = (weights.0.times(a.local), weights.1.times(b.local));
            within(difference(shares, totals), limit)
        })
    }

    /// True when all hits below `a[0]` and `b[0]` are alike.
    fn alike_below(&self, a: &[Node], b: &[Node], compared: &mut Compared) -> bool {
        a[0].branches_as(&b[0])
            && children(a).zip(children(b)).all(|((_, a), (_, b))| {
                compared.pairs += 1;
                self.alike_hits(&a[0], &b[0], compared) && self.alike_below(a, b, compared)
            })
    }

    fn alike_surfaces(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        if self.object_id && a.object != b.object || self.shadow && a.shadows != b.shadows {
            return false;
        }
        let between = offset(b.position, a.position);
        let reach = f64::from(if b.t < a.t { b.t } else { a.t });
        self.normal_cos.is_none_or(|cosine| within_angle(a.normal, b.normal, cosine))
            && self.position.is_none_or(|limit| dot(between, between).sqrt() <= limit * reach)
            && self.plane.is_none_or(|limit| dot(between, wide(a.normal)).abs() <= limit * reach)
            && self.convexity.is_none_or(|limit| bends_one_way(between, (a.normal, b.normal), limit))
    }
}

/// How much more may be wrong where a sample costs `rays` rays than where it costs three.
pub fn costs(rays: u32) -> f64 {
    (f64::from(rays) / 3.0).sqrt()
}

/// Two hits, or two misses.
fn same_kind(a: &[Node], b: &[Node]) -> bool {
    a[0].surface.is_some() == b[0].surface.is_some()
}

/// Mean rays of two trees.
fn rays_of(a: &[Node], b: &[Node]) -> u32 {
    a[0].rays.midpoint(b[0].rays)
}

/// `value <= limit`, and false for a NaN.
fn within(value: f64, limit: f64) -> bool {
    value <= limit
}

/// Added to the square roots of both colours. Near black sRGB is linear, while a square root is infinitely steep: without
/// this, dark colours would be judged more strictly than a display shows them.
const DARK: f64 = 0.06;

/// How much two contributions differ as displayed, when they are parts of samples of the colours `totals`: the root mean
/// square over the channels of `|a - b| / (sqrt(total a) + sqrt(total b) + DARK)`, which for whole samples is the difference of
/// the square roots of their colours. Colours above 1 are displayed as 1.
pub fn difference(shares: (Vec3, Vec3), totals: (Vec3, Vec3)) -> f64 {
    let ([a, b], [ta, tb]) = ([wide(shares.0), wide(shares.1)], [wide(totals.0), wide(totals.1)]);
    let mut sum = 0.0;
    for channel in 0..3 {
        let (ta, tb) = (ta[channel], tb[channel]);
        if ta >= 1.0 && tb >= 1.0 {
            continue;
        }
        let display = |v: f64| if v < 1.0 { if v > 0.0 { v.sqrt() } else { 0.0 } } else { 1.0 };
        let part = (a[channel] - b[channel]) / (display(ta) + display(tb) + DARK);
        sum += part * part;
    }
    (sum / 3.0).sqrt()
}

/// True when the angle between `a` and `b` has at least this cosine. Lengths are divided out, since a unit vector of f32 is
/// not quite one: equal normals pass at any limit.
pub fn within_angle(a: Vec3, b: Vec3, cosine: f64) -> bool {
    let (a, b) = (wide(a), wide(b));
    dot(a, b) >= cosine * (dot(a, a) * dot(b, b)).sqrt()
}

/// True unless the normals at both ends of `between` lean to the same side of it by more than `limit` of its length. On a
/// convex patch both lean apart, on a concave one towards each other, on a flat one neither leans. The same way they lean where a
/// surface bends first one way and then the other, and over a step.
fn bends_one_way(between: [f64; 3], normals: (Vec3, Vec3), limit: f64) -> bool {
    let (first, second) = (dot(wide(normals.0), between), dot(wide(normals.1), between));
    let slack = limit * dot(between, between).sqrt();
    // Written so that a NaN fails.
    (first <= slack || second <= slack) && (first >= -slack || second >= -slack)
}

fn wide(v: Vec3) -> [f64; 3] {
    v.to_array().map(f64::from)
}

fn offset(a: Vec3, b: Vec3) -> [f64; 3] {
    let (a, b) = (wide(a), wide(b));
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

#[cfg(test)]
mod tests;
