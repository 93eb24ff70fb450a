//! The rules of similarity, interpolation and reuse, once more: written from POLICIES.md, with trees of boxes.

use std::cell::Cell;

use rayreel_replay::policy::{First, Limit, Similarity};

type Rgb = [f32; 3];

/// Where a ray met something.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Number of the object.
    pub object: u32,
    /// Two bits a light, as the trace has them.
    pub shadows: u32,
    /// Of length 1, towards the ray.
    pub normal: [f32; 3],
    /// In the world.
    pub position: [f32; 3],
    /// Distance along the ray.
    pub t: f32,
}

/// A hit or a miss, with what hangs below it: reflection and refraction with their weights.
#[derive(Clone, Debug)]
pub struct Hit {
    /// Its number among the recorded hits of its sample.
    pub number: usize,
    /// `None` for a miss.
    pub surface: Option<Surface>,
    /// Of the hit alone.
    pub local: Rgb,
    /// With what the hits below add.
    pub colour: Rgb,
    /// The ray that found it and its shadow rays.
    pub own_rays: u32,
    /// The same with all rays below.
    pub rays: u32,
    /// Reflection and refraction: weight and hit.
    pub below: [Option<(Rgb, Box<Hit>)>; 2],
}

impl Hit {
    /// A hit whose colour and rays are those of its parts.
    pub fn new(
        number: usize,
        surface: Option<Surface>,
        local: Rgb,
        own_rays: u32,
        below: [Option<(Rgb, Box<Hit>)>; 2],
    ) -> Self {
        let (mut colour, mut rays) = (local, own_rays);
        for (weight, child) in below.iter().flatten() {
            let part = times(*weight, child.colour);
            colour = [colour[0] + part[0], colour[1] + part[1], colour[2] + part[2]];
            rays += child.rays;
        }
        Self { number, surface, local, colour, own_rays, rays, below }
    }

    fn branches(&self) -> [bool; 2] {
        [self.below[0].is_some(), self.below[1].is_some()]
    }

    /// Hits of the whole tree.
    pub fn hits(&self) -> u32 {
        1 + self.below.iter().flatten().map(|(_, child)| child.hits()).sum::<u32>()
    }
}

/// Traces recorded hits one by one.
pub trait Tracing {
    /// The recorded `hit` is traced: what is known of it then, and its local colour. Its path is 1 for a primary hit, twice that of the
    /// hit above for a reflection, one more for a refraction.
    fn see(&mut self, path: u32, hit: &Hit) -> (Option<Surface>, Rgb);

    /// The same with all hits below.
    fn see_all(&mut self, path: u32, hit: &Hit) -> Hit {
        let (surface, local) = self.see(path, hit);
        let mut below = [None, None];
        for (i, child) in hit.below.iter().enumerate() {
            below[i] =
                child.as_ref().map(|(weight, child)| (*weight, Box::new(self.see_all(2 * path + i as u32, child))));
        }
        Hit::new(hit.number, surface, local, hit.own_rays, below)
    }
}

/// Decides about hits whose samples are `gap` apart.
pub struct Judge<'a> {
    /// The rules and their limits.
    pub similarity: &'a Similarity,
    /// Factor on the colour limit.
    pub relax: f64,
    /// Distance of the ends, in samples.
    pub gap: usize,
    /// Primary hits may be interpolated above traced ones.
    pub stand_in: bool,
    /// Pairs of hits whose attributes were compared.
    pub compared: Cell<u32>,
}

impl Judge<'_> {
    /// May samples between `a` and `b` be interpolated?
    pub fn samples(&self, a: &Hit, b: &Hit, foreseen: f64) -> bool {
        let totals = (a.colour, b.colour);
        let seen = difference(totals, totals);
        let found = if foreseen < seen { foreseen } else { seen };
        let rules = self.similarity;
        let Some(limit) = self.limit((a.rays + b.rays) / 2) else {
            return self.alike(a, b) && (!rules.secondary || self.alike_below(a, b));
        };
        let excuses = |share: Limit| found < share.value().unwrap_or(0.0) * limit;
        let (primary, below) = (excuses(rules.unlike_primary), !rules.secondary || excuses(rules.unlike));
        let (is_near, same_kind) = (found <= limit, a.surface.is_none() == b.surface.is_none());
        // Where colours say all there is to say, hits are not looked at.
        match rules.first {
            First::Colours if !is_near => return false,
            First::Colours if primary => return same_kind,
            _ => {}
        }
        if self.alike(a, b) { is_near && (primary || below || self.alike_below(a, b)) } else { same_kind && primary }
    }

    /// May the contributions of `a` and `b` be interpolated?
    fn subtrees(&self, (a, b): (&Hit, &Hit), weights: (Rgb, Rgb), totals: (Rgb, Rgb)) -> bool {
        let found = difference((times(weights.0, a.colour), times(weights.1, b.colour)), totals);
        match self.colours(found, (a.rays + b.rays) / 2) {
            Verdict::Fails => false,
            Verdict::Excuses => true,
            Verdict::Passes => self.alike(a, b) && self.alike_below(a, b),
        }
    }

    fn colours(&self, found: f64, rays: u32) -> Verdict {
        let Some(limit) = self.limit(rays) else { return Verdict::Passes };
        if found.is_nan() || found > limit {
            return Verdict::Fails;
        }
        let excuse = self.similarity.unlike.value().unwrap_or(0.0) * limit;
        if found < excuse { Verdict::Excuses } else { Verdict::Passes }
    }

    fn limit(&self, rays: u32) -> Option<f64> {
        let limit = self.similarity.colour.value()? * self.relax;
        Some(limit * (2.0 / self.gap as f64) * (f64::from(rays) / 3.0).sqrt())
    }

    /// The attributes of two hits agree.
    pub fn alike(&self, a: &Hit, b: &Hit) -> bool {
        self.compared.set(self.compared.get() + 1);
        let rules = self.similarity;
        let (x, y) = match (&a.surface, &b.surface) {
            (None, None) => return true,
            (Some(x), Some(y)) => (x, y),
            _ => return false,
        };
        let step: Vec<f64> = (0..3).map(|i| f64::from(y.position[i]) - f64::from(x.position[i])).collect();
        let reach = f64::from(x.t.min(y.t));
        let mut pass = true;
        if rules.object_id {
            pass &= x.object == y.object;
        }
        if rules.shadow {
            pass &= x.shadows == y.shadows;
        }
        pass &= self.normals(x, y);
        if let Some(limit) = rules.position.value() {
            pass &= (step[0] * step[0] + step[1] * step[1] + step[2] * step[2]).sqrt() <= limit * reach;
        }
        if let Some(limit) = rules.plane.value() {
            let n = x.normal.map(f64::from);
            pass &= (step[0] * n[0] + step[1] * n[1] + step[2] * n[2]).abs() <= limit * reach;
        }
        if let Some(limit) = rules.convexity.value() {
            let lean = |n: [f32; 3]| {
                let n = n.map(f64::from);
                n[0] * step[0] + n[1] * step[1] + n[2] * step[2]
            };
            let (a, b) = (lean(x.normal), lean(y.normal));
            let e = limit * (step[0] * step[0] + step[1] * step[1] + step[2] * step[2]).sqrt();
            let same_way = a > e && b > e || a < -e && b < -e;
            pass &= !same_way && !a.is_nan() && !b.is_nan() && !e.is_nan();
        }
        if let Some(limit) = rules.texture.value() {
            let found = difference((a.local, b.local), (a.local, b.local));
            pass &= !found.is_nan() && found <= limit;
        }
        pass
    }

    fn normals(&self, x: &Surface, y: &Surface) -> bool {
        let Some(degrees) = self.similarity.normal_deg.value() else { return true };
        let dot = |a: [f32; 3], b: [f32; 3]| {
            let (a, b) = (a.map(f64::from), b.map(f64::from));
            a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
        };
        let cosine = libm::cos(degrees.to_radians());
        dot(x.normal, y.normal) >= cosine * (dot(x.normal, x.normal) * dot(y.normal, y.normal)).sqrt()
    }

    fn alike_below(&self, a: &Hit, b: &Hit) -> bool {
        a.branches() == b.branches()
            && (0..2).all(|i| match (&a.below[i], &b.below[i]) {
                (Some((_, a)), Some((_, b))) => self.alike(a, b) && self.alike_below(a, b),
                _ => true,
            })
    }

    /// The sample `recorded` between two ends, hit by hit.
    pub fn rebuild(&self, (near, far): (&Hit, &Hit), s: f32, recorded: &Hit, tracing: &mut dyn Tracing) -> Hit {
        let totals = (near.colour, far.colour);
        let alike = same_branches([near, far, recorded]) && self.alike(near, far);
        let bare = difference((near.local, far.local), totals);
        let limit = self.limit((near.own_rays + far.own_rays) / 2);
        let way = Way { path: 1, weights: ([1.0; 3], [1.0; 3]), totals, s };
        if self.stand_in && alike && limit.is_none_or(|limit| bare <= limit) {
            let below = self.children((near, far), recorded, &way, tracing, true);
            let (surface, local) = (middle(near, far, s), mix(near.local, far.local, s));
            return Hit::new(recorded.number, surface, local, near.own_rays, below);
        }
        self.traced((near, far), recorded, &way, tracing)
    }

    /// A hit that is traced, with its subtree or with children that are decided one by one.
    fn traced(&self, (near, far): (&Hit, &Hit), recorded: &Hit, way: &Way, tracing: &mut dyn Tracing) -> Hit {
        let one = |a: &Hit, b: &Hit| match (&a.surface, &b.surface) {
            (Some(x), Some(y)) => x.object == y.object && self.normals(x, y),
            _ => false,
        };
        if !(same_branches([near, far, recorded]) && one(near, recorded) && one(recorded, far)) {
            return tracing.see_all(way.path, recorded);
        }
        let (surface, local) = tracing.see(way.path, recorded);
        let below = self.children((near, far), recorded, way, tracing, false);
        Hit::new(recorded.number, surface, local, recorded.own_rays, below)
    }

    /// The children of a hit. Their weights are those of the ends' mix, or the traced hit's own.
    fn children(
        &self,
        (near, far): (&Hit, &Hit),
        recorded: &Hit,
        way: &Way,
        tracing: &mut dyn Tracing,
        mixed: bool,
    ) -> [Option<(Rgb, Box<Hit>)>; 2] {
        [0, 1].map(|i| {
            let ((wa, a), (wb, b)) = (near.below[i].as_ref()?, far.below[i].as_ref()?);
            let (w, c) = recorded.below[i].as_ref()?;
            let weights = (times(way.weights.0, *wa), times(way.weights.1, *wb));
            let way = Way { path: 2 * way.path + i as u32, weights, ..*way };
            let child = if self.subtrees((a, b), weights, way.totals) {
                between(a, b, way.s)
            } else {
                self.traced((a, b), c, &way, tracing)
            };
            Some((if mixed { mix(*wa, *wb, way.s) } else { *w }, Box::new(child)))
        })
    }
}

/// Where a hit of a rebuilt sample is.
struct Way {
    /// 1 for the primary hit.
    path: u32,
    /// What a unit of colour adds there to either end.
    weights: (Rgb, Rgb),
    /// The colours of both ends.
    totals: (Rgb, Rgb),
    /// Of the way between them.
    s: f32,
}

/// What the colour test says.
enum Verdict {
    Fails,
    Passes,
    /// Passes, and so well that what lies below need not be alike.
    Excuses,
}

/// Something hangs below, and the same below all.
fn same_branches(hits: [&Hit; 3]) -> bool {
    let [a, b, c] = hits.map(Hit::branches);
    a == b && b == c && a != [false, false]
}

/// The tree `s` of the way from `near` to `far`.
pub fn between(near: &Hit, far: &Hit, s: f32) -> Hit {
    let mut hit = near.clone();
    hit.surface = middle(near, far, s);
    hit.local = mix(near.local, far.local, s);
    hit.colour = mix(near.colour, far.colour, s);
    hit.below = [None, None];
    if near.branches() == far.branches() {
        hit.below = [0, 1].map(|i| {
            let ((wa, a), (wb, b)) = (near.below[i].as_ref()?, far.below[i].as_ref()?);
            Some((mix(*wa, *wb, s), Box::new(between(a, b, s))))
        });
    }
    hit
}

fn middle(near: &Hit, far: &Hit, s: f32) -> Option<Surface> {
    let (Some(a), Some(b)) = (&near.surface, &far.surface) else { return near.surface };
    let mut normal = mix(a.normal, b.normal, s);
    let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
    normal = if length > 0.0 { normal.map(|v| v / length) } else { a.normal };
    Some(Surface { normal, position: mix(a.position, b.position, s), t: a.t + (b.t - a.t) * s, ..*a })
}

/// The colour `s` of the way from `near` to `far`.
pub fn mix(near: Rgb, far: Rgb, s: f32) -> Rgb {
    [0, 1, 2].map(|i| near[i] + (far[i] - near[i]) * s)
}

fn times(a: Rgb, b: Rgb) -> Rgb {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// Origin much two shares of samples differ as displayed.
pub fn difference((a, b): (Rgb, Rgb), (ta, tb): (Rgb, Rgb)) -> f64 {
    let root = |v: f32| {
        // Neither a NaN nor anything above 1 is displayed darker than white; nothing is darker than black.
        if v.is_nan() || v > 1.0 { 1.0 } else { f64::from(v).max(0.0).sqrt() }
    };
    let squares = (0..3).map(|i| {
        if ta[i] >= 1.0 && tb[i] >= 1.0 {
            return 0.0;
        }
        let part = (f64::from(a[i]) - f64::from(b[i])) / (root(ta[i]) + root(tb[i]) + 0.06);
        part * part
    });
    (squares.sum::<f64>() / 3.0).sqrt()
}
