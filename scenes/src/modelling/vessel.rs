//! Glass vessels of revolution with walls and contents.
//!
//! Where a vessel is wet, wall and liquid are one body: air meets the outside of the wall, and behind it there is
//! liquid at once. Thin glass between air and liquid only shifts a ray by less than its thickness, and the indices of
//! glass and liquid lie close together, so the picture is that of the real thing; but a ray crosses two surfaces, not
//! four or six, and a tree of four bounces sees what stands behind. There are no coincident faces and no gap, hence
//! no total reflection in a film of air that is not there.

use glam::{DVec2, DVec3};

use crate::modelling::{
    SceneBuilder,
    lathe::lathe_with,
    part::Part,
    profile::{Knot, sample},
};

/// How far the liquid climbs up the wall, and how far from it the surface is flat.
const MENISCUS: DVec2 = DVec2::new(0.07, 0.035);
/// Profile points nearer than this to the edge of the liquid are left out, so that no sliver triangles arise.
const MERGE: f64 = 0.012;

/// A vessel open at the top, standing on y = 0.
#[derive(Clone, Debug)]
pub struct Vessel {
    /// From the axis at the bottom to the rim.
    outer: Vec<DVec2>,
    /// From the rim to the axis at the bottom, inside.
    inner: Vec<DVec2>,
    segments: usize,
    spout: Option<Spout>,
}

/// A lip to pour from, towards +z.
#[derive(Clone, Copy, Debug)]
struct Spout {
    from: f64,
    top: f64,
    reach: f64,
}

/// What a vessel looks like when it is filled.
#[derive(Clone, Debug)]
pub struct Filled {
    /// The dry part of the wall, inside and outside.
    pub glass: Part,
    /// The wet outside and the liquid's surface; they meet `glass` edge to edge.
    pub liquid: [Part; 2],
}

impl Vessel {
    /// A vessel with the given outside, from the axis at the bottom up to the rim, and a wall of even thickness.
    #[must_use]
    pub fn new(knots: &[Knot], step: f64, wall: f64, segments: usize) -> Self {
        let outer = sample(knots, step);
        let mut inner = offset(&outer, wall);
        inner.reverse();
        Self { outer, inner, segments, spout: None }
    }

    /// Gives the rim a lip that starts `depth` below it and reaches out by `reach`.
    #[must_use]
    pub fn spout(mut self, depth: f64, reach: f64) -> Self {
        let top = self.outer.last().map_or(0.0, |p| p.y);
        self.spout = Some(Spout { from: top - depth, top, reach });
        self
    }

    /// The height of the rim.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.outer.last().map_or(0.0, |p| p.y)
    }

    /// The outer radius at a height, on the wall below the rim.
    #[must_use]
    pub fn radius(&self, height: f64) -> f64 {
        crossing(&self.outer, height).1.x
    }

    /// The empty vessel: one closed solid.
    #[must_use]
    pub fn empty(&self) -> Part {
        let mut rows = self.outer.clone();
        rows.push(self.rim());
        rows.extend(&self.inner);
        self.turn(&rows)
    }

    /// The vessel filled up to `level`: the three parts together are one closed solid.
    #[must_use]
    pub fn filled(&self, level: f64) -> Filled {
        let (below, edge) = crossing(&self.outer, level);
        let inside: Vec<DVec2> = self.inner.iter().rev().copied().collect();
        let (under, contact) = crossing(&inside, level + MENISCUS.y);
        let dry = |p: &&DVec2, edge: DVec2| (**p - edge).length() > MERGE;

        let mut wet: Vec<DVec2> = self.outer[..=below].iter().filter(|p| dry(p, edge)).copied().collect();
        wet.push(edge);
        let mut wall = vec![edge];
        wall.extend(self.outer[below + 1..].iter().filter(|p| dry(p, edge)));
        wall.push(self.rim());
        wall.extend(inside[under + 1..].iter().rev().filter(|p| dry(p, contact)));
        wall.push(contact);
        let reach = |share: f64| (contact.x - MENISCUS.x * share).max(contact.x * 0.3);
        let surface = [
            contact,
            DVec2::new(reach(0.3), level + MENISCUS.y * 0.45),
            DVec2::new(reach(0.65), level + MENISCUS.y * 0.12),
            DVec2::new(reach(1.0), level),
            DVec2::new(0.0, level),
        ];
        Filled { glass: self.turn(&wall), liquid: [self.turn(&wet), self.turn(&surface)] }
    }

    /// Adds the vessel to a scene, filled with `liquid` (level, material) if any; wall and liquid become two objects.
    pub fn build(
        &self,
        out: &mut SceneBuilder,
        name: &str,
        glass: u32,
        liquid: Option<(f64, u32)>,
        place: impl Fn(Part) -> Part,
    ) {
        let Some((level, material)) = liquid else {
            out.object(name, &place(self.empty()), glass);
            return;
        };
        let filled = self.filled(level);
        out.object(name, &place(filled.glass), glass);
        let [wet, surface] = filled.liquid;
        out.object(&format!("{name}: liquid"), &place(wet), material);
        out.extend(&place(surface), material);
    }

    /// The middle of the rounded rim.
    fn rim(&self) -> DVec2 {
        let (outer, inner) = (self.outer[self.outer.len() - 1], self.inner[0]);
        let across = outer - inner;
        (outer + inner) / 2.0 + DVec2::new(-across.y, across.x) * 0.4
    }

    fn turn(&self, rows: &[DVec2]) -> Part {
        let shape = |row: usize, angle: f64, _| {
            let p: DVec2 = rows[row];
            let Some(Spout { from, top, reach }) = self.spout else { return p };
            let t = ((p.y - from) / (top - from)).clamp(0.0, 1.2);
            let turn = angle.min(std::f64::consts::TAU - angle) / 0.3;
            DVec2::new(p.x + reach * t * t * libm::exp(-turn * turn), p.y)
        };
        lathe_with(rows.len(), self.segments, shape).crease(55.0)
    }
}

/// The last point of a rising profile below `height`, and the profile's point at that height.
fn crossing(profile: &[DVec2], height: f64) -> (usize, DVec2) {
    let below = profile.iter().rposition(|p| p.y < height).unwrap_or(0).min(profile.len() - 2);
    let (a, b) = (profile[below], profile[below + 1]);
    let t = if b.y > a.y { ((height - a.y) / (b.y - a.y)).clamp(0.0, 1.0) } else { 1.0 };
    (below, DVec2::new(a.x + (b.x - a.x) * t, height))
}

/// The profile moved inwards by `wall`, point by point; ends on the axis stay there.
fn offset(outer: &[DVec2], wall: f64) -> Vec<DVec2> {
    let last = outer.len() - 1;
    let inwards = |i: usize| {
        let way = (outer[i + 1] - outer[i]).normalize_or_zero();
        DVec2::new(-way.y, way.x)
    };
    (0..=last)
        .map(|i| {
            let (before, after) = (inwards(i.max(1) - 1), inwards(i.min(last - 1)));
            let middle = (before + after).normalize_or_zero();
            // Longer at corners, so that both sides keep their thickness.
            let p = outer[i] + middle * (wall / middle.dot(before).max(0.5));
            DVec2::new(if outer[i].x <= 0.0 { 0.0 } else { p.x.max(0.001) }, p.y)
        })
        .collect()
}

/// A rod of glass, rounded at both ends, from one point to another along y.
#[must_use]
pub fn glass_rod(length: f64, radius: f64, segments: usize) -> Part {
    let end = |y: f64, sign: f64| [(0.0, y), (radius * 0.7, y + sign * radius * 0.3), (radius, y + sign * radius)];
    let mut rows: Vec<DVec2> = end(0.0, 1.0).iter().map(|&(r, y)| DVec2::new(r, y)).collect();
    rows.extend(end(length, -1.0).iter().rev().map(|&(r, y)| DVec2::new(r, y)));
    lathe_with(rows.len(), segments, |row, _, _| rows[row]).crease(70.0)
}

/// Moves a part that stands along y so that it runs from `from` towards `to`.
#[must_use]
pub fn along(part: Part, from: DVec3, to: DVec3) -> Part {
    let y = (to - from).normalize_or_zero();
    let x = y.any_orthonormal_vector();
    let z = x.cross(y);
    part.map(|p| from + x * p.x + y * p.y + z * p.z)
}
