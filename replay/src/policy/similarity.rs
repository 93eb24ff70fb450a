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
            let excused = if self.secondary { self.unlike_primary.min(self.unlike) } else { self.unlike_primary };
            if colour < excused * limit {
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
        match is_alike {
            false => colour < limit * self.unlike_primary,
            // A NaN is never within a limit.
            true if !within(colour, limit) => false,
            true => !self.secondary || colour < limit * self.unlike || self.alike_below(a, b, compared),
        }
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
mod tests {
    use super::*;
    use rayreel_formats::math::vec3;
    use rayreel_formats::tile::Shadows;

    fn surface() -> SurfacePoint {
        let (normal, position) = (vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, -10.0));
        SurfacePoint { object: 1, shadows: Shadows(5), normal, position, t: 10.0 }
    }

    fn node(surface: Option<SurfacePoint>, colour: Vec3) -> Node {
        Node { surface, local: colour, colour, reflect: None, refract: None, hit_rays: 3, rays: 3, len: 1, age: 0 }
    }

    fn pass(rules: &Similarity, a: &Node, b: &Node, gap: u32) -> bool {
        let slice = std::slice::from_ref;
        Tests::new(rules, 1.0).similar(slice(a), slice(b), gap, f64::INFINITY, &mut Compared::default())
    }

    fn similar(rules: &Similarity, a: SurfacePoint, b: SurfacePoint) -> bool {
        pass(rules, &node(Some(a), Vec3::ZERO), &node(Some(b), Vec3::ZERO), 2)
    }

    #[test]
    fn each_test_can_be_switched() {
        let a = surface();
        let object = SurfacePoint { object: 2, ..a };
        assert!(similar(&Similarity::NONE, a, object));
        assert!(!similar(&Similarity { object_id: true, ..Similarity::NONE }, a, object));
        let shadow = SurfacePoint { shadows: Shadows(6), ..a };
        assert!(similar(&Similarity::NONE, a, shadow));
        assert!(!similar(&Similarity { shadow: true, ..Similarity::NONE }, a, shadow));
    }

    #[test]
    fn angles_are_inclusive_and_equal_normals_pass_at_zero() {
        let a = surface();
        let limit = |deg| Similarity { normal_deg: Limit::At(deg), ..Similarity::NONE };
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
        let position = |v| Similarity { position: Limit::At(v), ..Similarity::NONE };
        assert!(similar(&position(0.1), a, beside) && !similar(&position(0.09), a, beside));
        let plane = |v| Similarity { plane: Limit::At(v), ..Similarity::NONE };
        assert!(similar(&plane(0.0), a, beside));
        assert!(similar(&plane(0.1), a, behind) && !similar(&plane(0.09), a, behind));
    }

    #[test]
    fn surfaces_bend_one_way() {
        let one_way = |a: [f32; 3], b: [f32; 3], limit: f64| {
            let first = SurfacePoint { normal: Vec3::from(a).normalized(), ..surface() };
            let position = first.position + vec3(2.0, 0.0, 0.0);
            let second = SurfacePoint { normal: Vec3::from(b).normalized(), position, ..first };
            let like = |a, b| similar(&Similarity { convexity: Limit::At(limit), ..Similarity::NONE }, a, b);
            assert_eq!(like(first, second), like(second, first));
            like(first, second)
        };
        let (left, up, right) = ([-0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]);
        assert!(one_way(left, right, 0.0), "convex");
        assert!(one_way(right, left, 0.0), "concave");
        assert!(one_way(up, up, 0.0), "flat");
        assert!(one_way(up, right, 0.0), "flat, then falling");
        assert!(!one_way(right, right, 0.59) && one_way(right, right, 0.61), "a step");
        assert!(!one_way(left, [-0.8, 0.0, 0.6], 0.59), "an S-bend");
    }

    #[test]
    fn sky_is_like_sky_only() {
        let (sky, hit) = (node(None, Vec3::ZERO), node(Some(surface()), Vec3::ZERO));
        let similar = |a, b| pass(&Similarity::NONE, a, b, 2);
        assert!(similar(&sky, &sky) && !similar(&sky, &hit) && !similar(&hit, &sky));
    }

    /// Square roots 0.5 and 0.6, so a difference of 0.11 / (1.1 + DARK).
    #[test]
    fn colours_are_compared_as_displayed() {
        let grey = |v: f32| vec3(v, v, v);
        let (a, b) = (grey(0.25), grey(0.36));
        let expected = 0.11 / (1.1 + DARK);
        assert!((difference((a, b), (a, b)) - expected).abs() < 1.0e-7);
        assert_eq!(difference((grey(2.0), grey(7.0)), (grey(2.0), grey(7.0))), 0.0, "both are displayed as white");
        let limit = |v| Similarity { colour: Limit::At(v), ..Similarity::NONE };
        let (a, b) = (node(Some(surface()), a), node(Some(surface()), b));
        assert!(pass(&limit(expected + 1.0e-6), &a, &b, 2) && !pass(&limit(expected - 1.0e-6), &a, &b, 2));
        assert!(pass(&limit(2.0 * expected + 1.0e-6), &a, &b, 4), "half the limit across twice the gap");
        assert!(!pass(&limit(2.0 * expected - 1.0e-6), &a, &b, 4));
        let dear = |n: &Node| Node { rays: 12, ..*n };
        assert!(
            pass(&limit(expected / 2.0 + 1.0e-6), &dear(&a), &dear(&b), 2),
            "twice the limit for four times the rays"
        );
        assert!(!pass(&limit(expected / 2.0 - 1.0e-6), &dear(&a), &dear(&b), 2));
        let broken = Node { colour: grey(f32::NAN), ..b };
        assert!(!pass(&limit(1.0), &a, &broken, 2), "a NaN is like nothing");
    }

    #[test]
    fn secondary_hits_are_compared_where_colours_do_not_excuse_them() {
        let weight = Some(vec3(0.5, 0.5, 0.5));
        let tree = |object| {
            let child = node(Some(SurfacePoint { object, ..surface() }), Vec3::ZERO);
            [Node { reflect: weight, len: 2, rays: 6, ..node(Some(surface()), Vec3::ZERO) }, child]
        };
        let (a, b) = (tree(5), tree(6));
        let run = |rules: &Similarity| {
            let mut compared = Compared::default();
            let like = Tests::new(rules, 1.0).similar(&a, &b, 2, f64::INFINITY, &mut compared);
            (like, compared.pairs)
        };
        let ids = Similarity { object_id: true, ..Similarity::NONE };
        assert_eq!(run(&ids), (true, 1), "primary hits only");
        assert_eq!(run(&Similarity { secondary: true, ..ids.clone() }), (false, 2));
        assert_eq!(run(&Similarity { secondary: true, ..Similarity::NONE }), (true, 2));
        let excused = Similarity { secondary: true, colour: Limit::At(0.1), unlike: Limit::At(0.5), ..ids };
        assert_eq!(run(&excused), (true, 1));
    }
}
