//! Rays against a mesh, by a grid of equal cells: enough for a few ten thousand rays, and built in one pass.

use std::collections::HashSet;

use glam::{DVec3, IVec3};

use crate::{
    mesh::meet,
    scene::{Mesh, Triangle},
};

/// Cells along the longest axis, finest first.
const RESOLUTIONS: [f64; 5] = [96.0, 48.0, 24.0, 12.0, 4.0];

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Distance, in scene units.
    pub distance: f64,
    /// Whether its shading normal looks towards the ray's origin.
    pub front: bool,
    /// Index of its object.
    pub object: u32,
}

/// The triangles of a mesh by cell.
pub(super) struct Grid<'a> {
    mesh: &'a Mesh,
    low: DVec3,
    high: DVec3,
    cell: f64,
    cells: IVec3,
    /// Where the list of each cell starts, and the end of the last.
    starts: Vec<u32>,
    lists: Vec<u32>,
}

impl<'a> Grid<'a> {
    /// Sorts the triangles of a mesh into cells.
    pub fn new(mesh: &'a Mesh) -> Self {
        let bounds = |(low, high): (DVec3, DVec3), p: &glam::Vec3| (low.min(p.as_dvec3()), high.max(p.as_dvec3()));
        let (low, high) = mesh.positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), bounds);
        let longest = (high - low).max_element().max(1e-30);
        let mut grid =
            Self { mesh, low, high, cell: longest, cells: IVec3::ONE, starts: Vec::new(), lists: Vec::new() };
        // Large triangles lie in many cells: the grid gets coarser until the lists are of a bearable length.
        let bearable = 8 * mesh.triangles.len() as u64 + (1 << 20);
        for resolution in RESOLUTIONS {
            grid.cell = longest / resolution;
            grid.cells = ((high - low) / grid.cell).floor().as_ivec3().max(IVec3::ZERO) + IVec3::ONE;
            if grid.entries() <= bearable {
                break;
            }
        }
        grid.fill();
        grid
    }

    /// First and last cell of a triangle's box.
    fn range(&self, triangle: usize) -> (IVec3, IVec3) {
        let [a, b, c] = self.corners(triangle);
        (self.cell_of(a.min(b).min(c)), self.cell_of(a.max(b).max(c)))
    }

    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.mesh.triangles[triangle].vertices.map(|v| self.mesh.positions[v as usize].as_dvec3())
    }

    fn cell_of(&self, p: DVec3) -> IVec3 {
        ((p - self.low) / self.cell).floor().as_ivec3().clamp(IVec3::ZERO, self.cells - IVec3::ONE)
    }

    fn entries(&self) -> u64 {
        let count = |triangle: usize| {
            let (first, last) = self.range(triangle);
            let size = last - first + IVec3::ONE;
            size.x as u64 * size.y as u64 * size.z as u64
        };
        (0..self.mesh.triangles.len()).map(count).sum()
    }

    fn index(&self, cell: IVec3) -> usize {
        ((cell.z * self.cells.y + cell.y) * self.cells.x + cell.x) as usize
    }

    fn each_cell(&self, triangle: usize, mut act: impl FnMut(usize)) {
        let (first, last) = self.range(triangle);
        for z in first.z..=last.z {
            for y in first.y..=last.y {
                for x in first.x..=last.x {
                    act(self.index(IVec3::new(x, y, z)));
                }
            }
        }
    }

    /// The triangles without exact copies of one before: a ray that meets one meets all, and there may be a million.
    fn distinct(&self) -> Vec<usize> {
        let mut known = HashSet::new();
        let triangles = self.mesh.triangles.iter().enumerate();
        triangles.filter(|(_, triangle)| known.insert((triangle.vertices, triangle.object))).map(|(at, _)| at).collect()
    }

    fn fill(&mut self) {
        let distinct = self.distinct();
        let mut starts = vec![0_u32; (self.cells.x * self.cells.y * self.cells.z) as usize + 1];
        for &triangle in &distinct {
            self.each_cell(triangle, |cell| starts[cell + 1] += 1);
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut lists = vec![0_u32; *starts.last().unwrap_or(&0) as usize];
        let mut next = starts.clone();
        for &triangle in &distinct {
            self.each_cell(triangle, |cell| {
                lists[next[cell] as usize] = triangle as u32;
                next[cell] += 1;
            });
        }
        (self.starts, self.lists) = (starts, lists);
    }

    /// The first hit of a ray from a point inside the grid; `direction` has length one.
    pub fn cast(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let inverse = direction.recip();
        let mut cell = self.cell_of(origin);
        let step = IVec3::new(sign(direction.x), sign(direction.y), sign(direction.z));
        let width = inverse.abs() * self.cell;
        let border = |axis: usize| {
            if step[axis] == 0 {
                return f64::INFINITY;
            }
            let edge = self.low[axis] + self.cell * f64::from(cell[axis] + i32::from(step[axis] > 0));
            (edge - origin[axis]) * inverse[axis]
        };
        let mut next = DVec3::new(border(0), border(1), border(2));
        let mut best: Option<Hit> = None;
        loop {
            let at = self.index(cell);
            for &triangle in &self.lists[self.starts[at] as usize..self.starts[at + 1] as usize] {
                let hit = self.meet(triangle as usize, origin, direction);
                best = match (best, hit) {
                    (Some(a), Some(b)) if b.distance < a.distance => hit,
                    (None, _) => hit,
                    _ => best,
                };
            }
            let leaves = next.min_element();
            if let Some(hit) = best.filter(|hit| hit.distance <= leaves) {
                return Some(hit);
            }
            let axis = if next.x <= next.y && next.x <= next.z {
                0
            } else if next.y <= next.z {
                1
            } else {
                2
            };
            cell[axis] += step[axis];
            if step[axis] == 0 || cell[axis] < 0 || cell[axis] >= self.cells[axis] {
                return best;
            }
            next[axis] += width[axis];
        }
    }

    /// A ray and one triangle.
    fn meet(&self, triangle: usize, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let distance = meet(self.corners(triangle), origin, direction)?;
        // Files turn their triangles either way more often than their normals.
        let Triangle { vertices, object, .. } = self.mesh.triangles[triangle];
        let [na, nb, nc] = vertices.map(|v| self.mesh.normals[v as usize].as_dvec3());
        Some(Hit { distance, front: (na + nb + nc).dot(direction) < 0.0, object })
    }

    /// Smallest and largest corner of the mesh.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        (self.low, self.high)
    }
}

fn sign(x: f64) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::builtin;

    #[test]
    fn the_grid_finds_what_all_triangles_say() {
        let scene = builtin("cornell").expect("is built in");
        let grid = Grid::new(&scene.mesh);
        let (low, high) = grid.bounds();
        let directions = super::super::directions(60);
        for k in 0..20 {
            let share = |prime: i32| f64::from(k * prime % 19) / 20.0 + 0.02;
            let origin = low + (high - low) * DVec3::new(share(1), share(7), share(5));
            for direction in &directions {
                let brute = (0..scene.mesh.triangles.len()).filter_map(|t| grid.meet(t, origin, *direction));
                let brute = brute.map(|hit| hit.distance).fold(f64::INFINITY, f64::min);
                let found = grid.cast(origin, *direction).map_or(f64::INFINITY, |hit| hit.distance);
                assert_eq!(found.to_bits(), brute.to_bits(), "from {origin} along {direction}");
            }
        }
    }
}
