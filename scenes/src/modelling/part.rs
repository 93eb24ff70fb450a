//! A part: triangles without material or object, in `f64`.

use glam::{DVec2, DVec3};

use crate::mesh::normals::CREASE_COS;

/// Triangles under construction. Normals come later, from the crease angle.
#[derive(Clone, Debug)]
pub struct Part {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Texture coordinates per vertex.
    pub uvs: Vec<DVec2>,
    /// Counter-clockwise triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Cosine of the angle from which edges stay sharp.
    pub crease_cos: f64,
}

impl Default for Part {
    fn default() -> Self {
        Self { positions: Vec::new(), uvs: Vec::new(), triangles: Vec::new(), crease_cos: CREASE_COS }
    }
}

impl Part {
    /// A grid of `rows` x `columns` points, `surface(row, column)` each; with `wrap` the last
    /// column meets the first.
    ///
    /// The front is where rows run up and columns run to the right. Rows that fall together in a
    /// point are fine: triangles without area are dropped when the part is built in.
    pub fn grid(rows: usize, columns: usize, wrap: bool, surface: impl Fn(usize, usize) -> DVec3) -> Self {
        let mut part = Self::default();
        for row in 0..rows {
            for column in 0..columns {
                part.positions.push(surface(row, column));
                part.uvs.push(DVec2::new(column as f64 / columns as f64, row as f64 / rows as f64));
            }
        }
        let at = |row: usize, column: usize| (row * columns + column % columns) as u32;
        for row in 1..rows {
            for column in 0..if wrap { columns } else { columns - 1 } {
                let [a, b] = [at(row - 1, column), at(row - 1, column + 1)];
                let [c, d] = [at(row, column + 1), at(row, column)];
                part.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        part
    }

    /// Moves every vertex.
    #[must_use]
    pub fn map(mut self, change: impl Fn(DVec3) -> DVec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p = change(*p));
        self
    }

    /// Shifts the part.
    #[must_use]
    pub fn at(self, x: f64, y: f64, z: f64) -> Self {
        self.map(|p| p + DVec3::new(x, y, z))
    }

    /// Scales the part by a positive factor.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        self.map(|p| p * factor)
    }

    /// Turns the part about the vertical axis, counter-clockwise seen from above.
    #[must_use]
    pub fn turned(self, degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees.to_radians());
        self.map(|p| DVec3::new(p.x * cos + p.z * sin, p.y, p.z * cos - p.x * sin))
    }

    /// Mirrors the part in the plane z = 0; the outside stays outside.
    #[must_use]
    pub fn mirrored_z(self) -> Self {
        self.map(|p| DVec3::new(p.x, p.y, -p.z)).flipped()
    }

    /// Turns the inside out.
    #[must_use]
    pub fn flipped(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self
    }

    /// Keeps an edge only where faces meet at more than this angle.
    #[must_use]
    pub fn crease(mut self, degrees: f64) -> Self {
        self.crease_cos = libm::cos(degrees.to_radians());
        self
    }

    /// Adds another part's triangles.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.uvs.extend(other.uvs);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| base + v)));
        self
    }

    /// Texture coordinates by projection from above: `u` along x, `v` along -z.
    #[must_use]
    pub fn planar_uv(mut self, centre: DVec2, size: f64) -> Self {
        self.uvs = self
            .positions
            .iter()
            .map(|p| DVec2::new((p.x - centre.x) / size + 0.5, 0.5 - (p.z - centre.y) / size))
            .collect();
        self
    }
}

/// Sine and cosine that are the same on every machine.
pub fn sin_cos(radians: f64) -> (f64, f64) {
    (libm::sin(radians), libm::cos(radians))
}
