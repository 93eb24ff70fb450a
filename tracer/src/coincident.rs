//! Many triangles in one place.
//!
//! A builder that looks for good splits finds none among triangles of one box: it makes a tree as deep as they are many, in a time
//! that grows with their square. So copies of a triangle, alike in everything, are left out where there are many: no ray can
//! tell them from the first, but that each copy of glass would tint a shadow once more. Of others of one box the builder sees the first, and all of them are split in halves below it. So is the lower
//! part of a tree that gets too deep.

use std::collections::BTreeMap;

use obvhs::triangle::Triangle as BuildTriangle;
use rayreel_scenes::Scene;

/// Triangles in one place from which on they are not left to the builder: copies, or others of one box. Scenes that people model have
/// fewer, and keep their trees to the bit.
const ALIKE_MAX: usize = 64;

/// The triangles that are built over, in the order of the mesh; all of them if there are not many copies of one.
pub(crate) fn kept(scene: &Scene) -> Vec<u32> {
    let mesh = &scene.mesh;
    let all = || 0..mesh.triangles.len() as u32;
    if mesh.triangles.len() <= ALIKE_MAX {
        return all().collect();
    }
    let corner = |v: u32| {
        let v = v as usize;
        let (p, n, uv) = (mesh.positions[v], mesh.normals[v], mesh.uvs[v]);
        [p.x, p.y, p.z, n.x, n.y, n.z, uv.x, uv.y].map(f32::to_bits)
    };
    // Triangles of one place first: few need to be compared in everything.
    let place =
        |t: u32| mesh.triangles[t as usize].vertices.map(|v| mesh.positions[v as usize].to_array().map(f32::to_bits));
    let mut order: Vec<u32> = all().collect();
    order.sort_by_key(|&t| place(t));
    let mut left_out = vec![false; mesh.triangles.len()];
    for same in order.chunk_by(|&a, &b| place(a) == place(b)).filter(|same| same.len() > ALIKE_MAX) {
        let mut alike: BTreeMap<_, Vec<u32>> = BTreeMap::new();
        for &t in same {
            let triangle = mesh.triangles[t as usize];
            let key = (triangle.object, triangle.material, triangle.vertices.map(corner));
            alike.entry(key).or_default().push(t);
        }
        // The sort is stable: the first of the mesh is the first here.
        for copies in alike.values().filter(|copies| copies.len() > ALIKE_MAX) {
            copies[1..].iter().for_each(|&t| left_out[t as usize] = true);
        }
    }
    all().filter(|&t| !left_out[t as usize]).collect()
}

/// Triangles as the builder sees them: of many in one box the first alone.
pub(crate) struct Crowds {
    /// Those that it sees, ascending.
    seen: Vec<u32>,
    /// Of those that stand for many, all these, ascending.
    members: BTreeMap<u32, Vec<u32>>,
}

impl Crowds {
    /// Finds them.
    pub fn of(triangles: &[BuildTriangle]) -> Self {
        let place = |t: u32| {
            let bounds = triangles[t as usize].aabb();
            [bounds.min, bounds.max].map(|corner| corner.to_array().map(f32::to_bits))
        };
        let all = 0..triangles.len() as u32;
        let mut order: Vec<u32> = all.clone().collect();
        // The sort is stable: each group is ascending.
        order.sort_by_key(|&t| place(t));
        let groups = order.chunk_by(|&a, &b| place(a) == place(b)).filter(|same| same.len() > ALIKE_MAX);
        let members: BTreeMap<u32, Vec<u32>> = groups.map(|same| (same[0], same.to_vec())).collect();
        let mut hidden = vec![false; triangles.len()];
        members.values().flat_map(|members| &members[1..]).for_each(|&t| hidden[t as usize] = true);
        Self { seen: all.filter(|&t| !hidden[t as usize]).collect(), members }
    }

    /// What the builder sees of `triangles`.
    pub fn seen(&self, triangles: &[BuildTriangle]) -> Vec<BuildTriangle> {
        self.seen.iter().map(|&t| triangles[t as usize]).collect()
    }

    /// The triangles that the one stands for which the builder knows by this number.
    pub fn behind(&self, number: u32) -> impl Iterator<Item = u32> {
        let seen = self.seen[number as usize];
        let members = self.members.get(&seen);
        members.into_iter().flatten().copied().chain(members.is_none().then_some(seen))
    }
}
