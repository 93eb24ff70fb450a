//! Many small things: a cluster of triangles with ready normals, stamped again and again.
//!
//! A [`Part`] gets its normals from its creases. That suits a handful of solids. For half a million leaves it is slow,
//! and wrong: a leaf is lit like the crown it sits on, not like a loose sheet.

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};

use crate::{
    mesh::normals,
    modelling::part::{Part, sin_cos},
};

/// A sequence of numbers from an integer hash; the same on every machine.
#[derive(Clone, Debug)]
pub struct Rng {
    state: u32,
}

impl Rng {
    /// Starts the sequence of a seed.
    #[must_use]
    pub fn new(seed: u32) -> Self {
        Self { state: seed.wrapping_mul(0x9E37_79B1) ^ 0x5BD1_E995 }
    }

    /// The next number, from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9);
        let mut h = self.state;
        h = (h ^ (h >> 16)).wrapping_mul(0x21F0_AAAD);
        h = (h ^ (h >> 15)).wrapping_mul(0x735A_2D97);
        f64::from(h ^ (h >> 15)) / f64::from(u32::MAX)
    }

    /// The next number between two.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A unit vector, every direction alike.
    pub fn direction(&mut self) -> DVec3 {
        let y = self.between(-1.0, 1.0);
        let (sin, cos) = sin_cos(self.between(0.0, std::f64::consts::TAU));
        let r = (1.0 - y * y).max(0.0).sqrt();
        DVec3::new(r * sin, y, r * cos)
    }

    /// One of `count` things.
    pub fn pick(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }
}

/// Triangles with a normal and a texture coordinate per vertex.
#[derive(Clone, Debug, Default)]
pub struct Cluster {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Texture coordinates.
    pub uvs: Vec<DVec2>,
    /// Counter-clockwise triangles.
    pub triangles: Vec<[u32; 3]>,
}

impl Cluster {
    /// A part with the normals that its crease angle asks for.
    #[must_use]
    pub fn of(part: &Part) -> Self {
        let positions: Vec<Vec3> = part.positions.iter().map(|p| p.as_vec3()).collect();
        let triangles: Vec<[u32; 3]> =
            part.triangles.iter().copied().filter(|t| !normals::is_degenerate(&positions, *t)).collect();
        let corners = normals::corner_normals(&positions, &triangles, &vec![0; triangles.len()], part.crease_cos);
        let mut out = Self::default();
        for (triangle, normals) in triangles.iter().zip(&corners) {
            let corners = triangle.iter().zip(normals);
            let made =
                corners.map(|(v, n)| out.vertex(part.positions[*v as usize], n.as_dvec3(), part.uvs[*v as usize]));
            if let [a, b, c] = made.collect::<Vec<_>>()[..] {
                out.triangles.push([a, b, c]);
            }
        }
        out
    }

    /// Adds a vertex and returns its index; equal neighbours in a row are shared.
    pub fn vertex(&mut self, position: DVec3, normal: DVec3, uv: DVec2) -> u32 {
        let from = self.positions.len().saturating_sub(6);
        let same = |i: &usize| self.positions[*i] == position && self.normals[*i] == normal && self.uvs[*i] == uv;
        if let Some(known) = (from..self.positions.len()).find(same) {
            return known as u32;
        }
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        (self.positions.len() - 1) as u32
    }

    /// Adds a flat polygon that is lit as if it faced along `normal`. Its corners are turned to run
    /// counter-clockwise about the normal, and the normal is bent to be within 70 degrees of the face.
    pub fn polygon(&mut self, corners: &[(DVec3, DVec2)], normal: DVec3) {
        let [(a, _), (b, _), (c, _), ..] = *corners else { return };
        let mut face = (b - a).cross(c - a).normalize_or(DVec3::Y);
        let turned = face.dot(normal) < 0.0;
        if turned {
            face = -face;
        }
        let short = (0.4 - face.dot(normal)).max(0.0);
        let normal = (normal + face * (2.0 * short)).normalize_or(face);
        let at: Vec<u32> = corners.iter().map(|(p, uv)| self.push(*p, normal, *uv)).collect();
        for pair in at[1..].windows(2) {
            self.triangles.push(if turned { [at[0], pair[1], pair[0]] } else { [at[0], pair[0], pair[1]] });
        }
    }

    /// A slim solid from `base` to `tip`, widest at `belly` (0 to 1 of its length), with `sides` sides;
    /// with `belly` 0 a cone whose open foot belongs inside something else.
    /// `v` runs from 0 at the base to 1 at the tip.
    pub fn spindle(&mut self, base: DVec3, tip: DVec3, radius: f64, belly: f64, sides: usize) {
        let axis = (tip - base).normalize_or(DVec3::Y);
        let side = axis.cross(if axis.x.abs() < 0.8 { DVec3::X } else { DVec3::Z }).normalize_or(DVec3::Z);
        let across = axis.cross(side);
        let ring: Vec<u32> = (0..sides)
            .map(|k| {
                let (sin, cos) = sin_cos(std::f64::consts::TAU * k as f64 / sides as f64);
                let out = side * cos + across * sin;
                self.push(base + (tip - base) * belly + out * radius, out, DVec2::new(0.0, belly))
            })
            .collect();
        for k in 0..sides {
            let (a, b) = (ring[k], ring[(k + 1) % sides]);
            self.facet(a, b, tip, DVec2::Y);
            if belly > 0.0 {
                self.facet(b, a, base, DVec2::ZERO);
            }
        }
    }

    /// A triangle from two known corners to a new one that has the normal of the face: a tip is lit
    /// like its flanks.
    fn facet(&mut self, a: u32, b: u32, end: DVec3, uv: DVec2) {
        let [pa, pb] = [a, b].map(|v| self.positions[v as usize]);
        let normal = (pb - pa).cross(end - pa).normalize_or(DVec3::Y);
        let end = self.push(end, normal, uv);
        self.triangles.push([a, b, end]);
    }

    fn push(&mut self, position: DVec3, normal: DVec3, uv: DVec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        (self.positions.len() - 1) as u32
    }

    /// Adds a copy of another cluster, moved by `place`, its texture coordinates shifted by `shade`.
    pub fn stamp(&mut self, other: &Self, place: &DAffine3, shade: DVec2) {
        let base = self.positions.len() as u32;
        let turn = place.matrix3.inverse().transpose();
        self.positions.extend(other.positions.iter().map(|p| place.transform_point3(*p)));
        self.normals.extend(other.normals.iter().map(|n| (turn * *n).normalize_or(DVec3::Y)));
        self.uvs.extend(other.uvs.iter().map(|uv| *uv + shade));
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| base + v)));
    }

    /// The same triangles with other texture coordinates.
    #[must_use]
    pub fn with_uv(mut self, uv: impl Fn(DVec3, DVec2) -> DVec2) -> Self {
        for (at, p) in self.uvs.iter_mut().zip(&self.positions) {
            *at = uv(*p, *at);
        }
        self
    }
}

/// Stands a thing upright: scaled per axis, turned about the vertical axis, moved to a place.
#[must_use]
pub fn upright(at: DVec3, degrees: f64, scale: DVec3) -> DAffine3 {
    let (sin, cos) = sin_cos(degrees.to_radians());
    let turn = DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos));
    DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), at)
}
