//! An I-sample whose ray tree is decided hit by hit (`secondary = true`).
//!
//! Where two samples are alike at a hit but not below it, only what differs is traced:
//!
//! - a **subtree** whose contributions pass the tests is interpolated whole, no ray is traced for it;
//! - with `stand_in`, a **primary hit** that passes is interpolated (no primary ray, no shadow rays), and those of its children
//!   that fail are traced from it;
//! - a hit that fails is traced; if all three hits (both ends and the traced one) are on one object with similar normals and
//!   branch alike, its children are again decided one by one, else the whole subtree is traced.
//!
//! Without `stand_in` every traced ray is one that hardware would trace, and the picture is exactly hardware's: so it is in all
//! presets.
//!
//! **The stand-in.** Hardware would shoot the child of an interpolated hit from the interpolated position along the direction
//! that follows from the interpolated normal. A replay traces nothing, so the recorded child of the sample itself stands for
//! that ray: its path, its hit and its colour. Where the surface bends evenly between the ends, whose normals are `a` or less
//! apart, both rays are near: the interpolated normal is off by less than 0.05 degrees at `a` = 20 degrees (linear against
//! circular interpolation), and the interpolated point lies below the surface by at most `a / 8` of the distance between the
//! hits. There is no bound for other surfaces, since no test sees what lies between the ends: a crease, a silhouette, another
//! object. Measured, half of the rays are off by less than a degree and a few by any angle, and since a recorded child
//! belongs to the picture of full sampling and a shot one would not, a replay shows a better picture here than hardware would:
//! POLICIES.md has by how much. Only primary hits are interpolated above traced ones, so the error does not add up over
//! bounces. Where the recorded sample does not branch as the ends do there is no stand-in, and the hit is traced.

use rayreel_formats::math::Vec3;
use rayreel_formats::tile::{RayClass, Shadows};

use super::history::{History, LightChecks, Past};
use super::interpolate::{interpolate_node, interpolate_tree};
use super::similarity::{Compared, Tests};
use super::tree::{Node, finish};
use super::view::HitTracer;

/// A sample between two others, to be built.
pub struct Rebuild<'a, 't, 'h> {
    /// The tests.
    pub tests: &'a Tests,
    /// A primary hit may be interpolated although some of its children are traced.
    pub stand_in: bool,
    /// The recorded sample.
    pub tracer: &'a mut HitTracer<'t>,
    /// The tree that is built.
    pub out: &'a mut Vec<Node>,
    /// Samples from one end to the other.
    pub gap: u32,
    /// Share of the farther end.
    pub s: f32,
    /// Colours of both ends, the nearer first.
    pub totals: (Vec3, Vec3),
    /// Pairs of hits compared.
    pub compared: Compared,
    /// Hits interpolated.
    pub interpolated: u32,
    /// Whose lights may be known.
    pub eye: &'a mut Eye<'h>,
}

/// What a sample does with the history.
#[derive(Clone, Copy)]
pub enum Look<'a> {
    /// It does not look.
    Nowhere,
    /// It sends no rays to lights that are known.
    Back(&'a History),
    /// It sends all rays, and compares.
    Check(&'a History),
}

/// How hits are traced: with all their shadow rays, or without those that the history makes needless.
#[derive(Clone, Default)]
pub struct Eye<'a> {
    history: Option<&'a History>,
    /// Nothing is taken for known, but compared with what is found.
    checks: bool,
    /// What was compared.
    pub checked: LightChecks,
    past: Option<Past<'a>>,
    /// Age of what was taken from the history; 0 if nothing was.
    age: u8,
    /// The place that was looked up.
    pub place: Option<u32>,
    /// Hits whose lights were looked for.
    pub hits: u32,
}

impl<'a> Eye<'a> {
    /// One that looks back as it is told.
    pub fn new(look: Look<'a>) -> Self {
        let history = match look {
            Look::Nowhere => None,
            Look::Back(history) | Look::Check(history) => Some(history),
        };
        Self { history, checks: matches!(look, Look::Check(_)), ..Self::default() }
    }

    /// Traces hit `node`, which is at `path`.
    fn hit(&mut self, tracer: &mut HitTracer<'_>, node: usize, path: RayClass) -> Node {
        let Some(history) = self.history else { return tracer.hit(node) };
        let seen = tracer.look(node);
        let Some(surface) = &seen.surface else { return tracer.hit(node) };
        if path == RayClass::PRIMARY {
            (self.place, self.past) = history.find(surface);
        }
        self.hits += u32::from(path == RayClass::PRIMARY || self.past.is_some());
        match self.past.as_ref().and_then(|past| past.lights(path, surface)) {
            Some(lights) if self.checks => {
                let traced = tracer.hit(node);
                let states = traced.surface.map_or(0, |surface| surface.shadows.0);
                let mistaken = Shadows(states ^ lights.shadows.0).places().0 & lights.lights;
                self.checked.lights += lights.lights.count_ones();
                self.checked.mistaken += mistaken.count_ones();
                traced
            }
            Some(lights) => {
                self.age = self.past.as_ref().map_or(0, |past| past.age);
                tracer.shade(node, lights)
            }
            None => tracer.hit(node),
        }
    }

    /// Appends a sample's tree, all traced.
    pub fn sample(&mut self, tracer: &mut HitTracer<'_>, out: &mut Vec<Node>) {
        self.subtree(tracer, 0, RayClass::PRIMARY, out);
        out[0].age = self.age;
    }

    /// Appends hit `node`, which is at `path`, and all below it, all traced.
    fn subtree(&mut self, tracer: &mut HitTracer<'_>, node: usize, path: RayClass, out: &mut Vec<Node>) {
        if self.history.is_none() || self.past.is_none() && path != RayClass::PRIMARY {
            return out.extend_from_slice(tracer.subtree(node));
        }
        let traced = self.hit(tracer, node, path);
        self.below(tracer, (node, path, traced), out);
    }

    /// Appends a hit that was traced, and all below it, all traced.
    fn below(
        &mut self,
        tracer: &mut HitTracer<'_>,
        (node, path, traced): (usize, RayClass, Node),
        out: &mut Vec<Node>,
    ) {
        let at = out.len();
        out.push(traced);
        let mut child = node + 1;
        for branch in traced.branches(path) {
            self.subtree(tracer, child, branch, out);
            child += tracer.len(child);
        }
        finish(&mut out[at..]);
    }
}

/// The same hit in three trees: those of both ends, the nearer first, and the recorded one.
#[derive(Clone, Copy)]
struct SameHit<'a> {
    near: &'a [Node],
    far: &'a [Node],
    /// Its number in the recorded tree.
    recorded: usize,
    /// The way down to it.
    path: RayClass,
    /// What a unit of colour here adds to either end.
    weights: (Vec3, Vec3),
}

impl Rebuild<'_, '_, '_> {
    /// Builds the tree between `near` and `far`, which are not similar as a whole.
    pub fn build(&mut self, near: &[Node], far: &[Node]) {
        self.hit(SameHit { near, far, recorded: 0, path: RayClass::PRIMARY, weights: (Vec3::ONE, Vec3::ONE) });
        let of_ends = if self.interpolated > 0 { near[0].age.max(far[0].age) } else { 0 };
        self.out[0].age = of_ends.max(self.eye.age);
    }

    /// Appends the sample's hit and everything below it.
    fn hit(&mut self, hit: SameHit<'_>) {
        let SameHit { near, far, recorded, path, weights } = hit;
        let primary = path == RayClass::PRIMARY;
        if !primary && self.tests.similar_below((near, far), weights, self.totals, self.gap, &mut self.compared) {
            interpolate_tree(near, far, self.s, self.out);
            self.interpolated += 1;
            return;
        }
        let (a, b) = (&near[0], &far[0]);
        let branches = near.len() > 1 && a.branches_as(b) && self.tracer.stands_in(recorded, a);
        let at = self.out.len();
        let alike = self.stand_in && branches && primary && self.tests.alike_hits(a, b, &mut self.compared);
        if alike && self.tests.alike_locals((a, b), weights, self.totals, self.gap, &mut self.compared) {
            self.out.push(interpolate_node(a, b, self.s));
            self.interpolated += 1;
        } else {
            let traced = self.eye.hit(self.tracer, recorded, path);
            if !branches || !self.on_one_surface(a, b, &traced) {
                return self.eye.below(self.tracer, (recorded, path, traced), self.out);
            }
            self.out.push(traced);
        }
        self.children(hit);
        finish(&mut self.out[at..]);
    }

    /// Appends the children of a hit that branches alike in all three trees.
    fn children(&mut self, hit: SameHit<'_>) {
        let (a, b) = (&hit.near[0], &hit.far[0]);
        let (mut i, mut j, mut k) = (1, 1, hit.recorded + 1);
        let weights = [a.reflect.zip(b.reflect), a.refract.zip(b.refract)].into_iter().flatten();
        for (path, weights) in a.branches(hit.path).zip(weights) {
            let weights = (hit.weights.0.times(weights.0), hit.weights.1.times(weights.1));
            let (near, far) = (&hit.near[i..], &hit.far[j..]);
            let (near, far) = (&near[..near[0].len as usize], &far[..far[0].len as usize]);
            self.hit(SameHit { near, far, recorded: k, path, weights });
            (i, j, k) = (i + near.len(), j + far.len(), k + self.tracer.len(k));
        }
    }

    /// True when a traced hit is of one surface with both ends, so that its children are between theirs.
    fn on_one_surface(&mut self, a: &Node, b: &Node, traced: &Node) -> bool {
        self.compared.pairs += 2;
        self.tests.one_surface(a, traced) && self.tests.one_surface(traced, b)
    }
}
