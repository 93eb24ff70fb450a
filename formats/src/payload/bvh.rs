//! The `BVH ` payload: the tree's shape, the triangles and the vertices. Boxes follow from them.
//!
//! Numbers are written as differences and split into byte planes, which zstd then packs well: neighbours in leaf order are
//! neighbours in space.

use crate::bvh::{Bvh, Shape, Triangle, Vertex};
use crate::error::{Error, Result, check_limit};
use crate::limits::Limits;
use crate::math::Vec3;
use crate::oct::Oct;
use crate::payload::metadata;
use crate::scene::Material;

/// Names and surfaces: everything of the payload that is not a long array.
#[derive(Debug, bincode::Encode, bincode::Decode)]
struct Tables {
    objects: Vec<String>,
    materials: Vec<Material>,
    /// Pairs of object and material that triangles have, in the order in which they first appear.
    surfaces: Vec<(u32, u32)>,
}

/// Encodes a tree.
///
/// # Errors
/// When its names are too long for a metadata chunk.
pub fn encode(bvh: &Bvh) -> Result<Vec<u8>> {
    let (surfaces, surface_of) = surfaces(&bvh.triangles);
    let tables = Tables { objects: bvh.objects.clone(), materials: bvh.materials.clone(), surfaces };
    let tables = metadata::encode("bvh tables", &tables)?;
    let mut out = Vec::new();
    for count in [bvh.nodes.len(), bvh.triangles.len(), bvh.vertices.len(), tables.len()] {
        out.extend_from_slice(&(count as u32).to_le_bytes());
    }
    out.extend_from_slice(&tables);
    for sides in bvh.shape() {
        out.extend(sides.map(|side| match side {
            Shape::Inner => 0,
            Shape::Leaf(count) => count + 1,
        }));
    }
    push_planes(&mut out, &surface_of);
    push_planes(&mut out, &corner_codes(&bvh.triangles));
    let positions = |pick: fn(Vec3) -> f32| differences(bvh.vertices.iter().map(|v| pick(v.position).to_bits()));
    push_planes(&mut out, &positions(|p| p.x));
    push_planes(&mut out, &positions(|p| p.y));
    push_planes(&mut out, &positions(|p| p.z));
    push_planes(&mut out, &differences(bvh.vertices.iter().map(|v| u32::from(v.normal.u))));
    push_planes(&mut out, &differences(bvh.vertices.iter().map(|v| u32::from(v.normal.v))));
    Ok(out)
}

/// Decodes a tree and puts its boxes on.
///
/// # Errors
/// When the payload is not one, or over a limit.
pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Bvh> {
    let corrupt = |detail: &str| Error::decode("bvh", detail);
    let mut input = Input(bytes);
    let [nodes, triangles, vertices, tables] = input.header().ok_or_else(|| corrupt("the payload is cut short"))?;
    check_limit("bvh nodes", nodes as u64, limits.max_bvh_nodes)?;
    check_limit("triangles", triangles as u64, limits.max_triangles)?;
    let need = 2 * nodes as u64 + 16 * triangles as u64 + 20 * vertices as u64 + tables as u64;
    if need != input.0.len() as u64 {
        return Err(corrupt("the payload's length does not fit its counts"));
    }
    let cut = || corrupt("the payload is cut short");
    let tables: Tables = metadata::decode("bvh tables", input.take(tables).ok_or_else(cut)?, limits)?;
    let shape = input.take(2 * nodes).ok_or_else(cut)?.chunks_exact(2).map(|c| [side(c[0]), side(c[1])]);
    let shape: Vec<[Shape; 2]> = shape.collect();
    let mut planes = |count: usize| input.planes(count).ok_or_else(cut);
    let (surfaces, corners) = (planes(triangles)?, planes(3 * triangles)?);
    let sums = |v: Vec<u32>| {
        v.into_iter().scan(0u32, |sum, d| {
            *sum = sum.wrapping_add(d);
            Some(*sum)
        })
    };
    let (xs, ys, zs) = (sums(planes(vertices)?), sums(planes(vertices)?), sums(planes(vertices)?));
    let (us, vs) = (sums(planes(vertices)?), sums(planes(vertices)?));
    let number = |bits: u32| f32::from_bits(bits);
    let vertices = xs.zip(ys).zip(zs).zip(us.zip(vs)).map(|(((x, y), z), (u, v))| Vertex {
        position: Vec3::new(number(x), number(y), number(z)),
        normal: Oct { u: u as u16, v: v as u16 },
    });
    let triangles =
        triangles_of(&corners, &surfaces, &tables.surfaces).ok_or_else(|| corrupt("a triangle has no surface"))?;
    Bvh::new(&shape, triangles, vertices.collect(), tables.objects, tables.materials).map_err(|e| corrupt(&e))
}

fn side(code: u8) -> Shape {
    if code == 0 { Shape::Inner } else { Shape::Leaf(code - 1) }
}

/// The distinct pairs of object and material, and per triangle the index of its pair.
fn surfaces(triangles: &[Triangle]) -> (Vec<(u32, u32)>, Vec<u32>) {
    let mut numbers = std::collections::HashMap::new();
    let mut surfaces = Vec::new();
    let of = triangles.iter().map(|t| {
        *numbers.entry((t.object, t.material)).or_insert_with(|| {
            surfaces.push((t.object, t.material));
            surfaces.len() as u32 - 1
        })
    });
    let of = of.collect();
    (surfaces, of)
}

/// Per corner how far back its vertex was first named: 0 is the next new one.
fn corner_codes(triangles: &[Triangle]) -> Vec<u32> {
    let mut next = 0u32;
    let code = |v: u32| {
        let code = next.wrapping_sub(v);
        next += u32::from(code == 0);
        code
    };
    triangles.iter().flat_map(|t| t.vertices).map(code).collect()
}

fn triangles_of(corners: &[u32], surface_of: &[u32], surfaces: &[(u32, u32)]) -> Option<Vec<Triangle>> {
    let mut next = 0u32;
    let mut vertex = |code: u32| {
        let v = next.wrapping_sub(code);
        next = next.wrapping_add(u32::from(code == 0));
        v
    };
    let triangle = |(corners, &surface): (&[u32], &u32)| {
        let &(object, material) = surfaces.get(surface as usize)?;
        let vertices = [vertex(corners[0]), vertex(corners[1]), vertex(corners[2])];
        Some(Triangle { vertices, object, material })
    };
    corners.chunks_exact(3).zip(surface_of).map(triangle).collect()
}

fn differences(values: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut last = 0u32;
    values
        .map(|v| {
            let d = v.wrapping_sub(last);
            last = v;
            d
        })
        .collect()
}

/// Writes the lowest bytes of all values, then the next higher ones, and so on.
fn push_planes(out: &mut Vec<u8>, values: &[u32]) {
    for byte in 0..4 {
        out.extend(values.iter().map(|v| (v >> (8 * byte)) as u8));
    }
}

/// The bytes that are still to be read.
struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(head)
    }

    fn header(&mut self) -> Option<[usize; 4]> {
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = u32::from_le_bytes(self.take(4)?.try_into().ok()?) as usize;
        }
        Some(counts)
    }

    fn planes(&mut self, count: usize) -> Option<Vec<u32>> {
        let planes: Vec<&[u8]> = (0..4).map(|_| self.take(count)).collect::<Option<_>>()?;
        Some((0..count).map(|i| u32::from_le_bytes([planes[0][i], planes[1][i], planes[2][i], planes[3][i]])).collect())
    }
}
