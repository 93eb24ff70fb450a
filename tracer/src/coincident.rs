//! Many triangles in one place.
//!
//! A builder that looks for good splits finds none among triangles of one box: it makes a tree as deep as they are many, in a time
//! that grows with their square. So copies of a triangle, alike in everything, are left out where there are many (no ray can tell
//! them from the first), and where a tree gets too deep its lower part is split in halves.

use std::collections::BTreeMap;

use rayreel_scenes::Scene;

/// Copies of one triangle from which on they are left out. Scenes that people model have fewer, and keep their trees to the bit.
const COPIES_MAX: usize = 64;

/// The triangles that are built over, in the order of the mesh; all of them if there are not many copies of one.
pub(crate) fn kept(scene: &Scene) -> Vec<u32> {
    let mesh = &scene.mesh;
    let all = || 0..mesh.triangles.len() as u32;
    if mesh.triangles.len() <= COPIES_MAX {
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
    for same in order.chunk_by(|&a, &b| place(a) == place(b)).filter(|same| same.len() > COPIES_MAX) {
        let mut alike: BTreeMap<_, Vec<u32>> = BTreeMap::new();
        for &t in same {
            let triangle = mesh.triangles[t as usize];
            let key = (triangle.object, triangle.material, triangle.vertices.map(corner));
            alike.entry(key).or_default().push(t);
        }
        // The sort is stable: the first of the mesh is the first here.
        for copies in alike.values().filter(|copies| copies.len() > COPIES_MAX) {
            copies[1..].iter().for_each(|&t| left_out[t as usize] = true);
        }
    }
    all().filter(|&t| !left_out[t as usize]).collect()
}
