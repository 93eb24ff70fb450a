//! The `BVH ` payload: the tree's shape, the triangles and the vertices. Boxes follow from them.
//!
//! Numbers are written as differences and split into byte planes, which zstd then packs well: neighbours in leaf order
//! are neighbours in space.

use crate::bvh::{Bvh, Child, Node, Shape, Triangle, Vertex};
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

/// Memory that decoding takes beside the payload, in bytes a node, a triangle and a vertex: what is made of them and the numbers on
/// the way there. Two bytes of the payload are a node, so a small payload may be a large tree.
const DECODING_BYTES: [u64; 3] = [
    (size_of::<Node>() + size_of::<[Child; 2]>() + size_of::<[Shape; 2]>()) as u64,
    (size_of::<Triangle>() + 4 * size_of::<u32>()) as u64,
    (size_of::<Vertex>() + 5 * size_of::<u32>()) as u64,
];

impl Bvh {
    /// The payload of a `BVH ` chunk.
    ///
    /// # Errors
    /// When its names are longer than a reader would accept.
    pub fn to_payload(&self) -> Result<Vec<u8>> {
        let (surfaces, surface_of) = surfaces(&self.triangles);
        let tables = Tables { objects: self.objects.clone(), materials: self.materials.clone(), surfaces };
        let tables = metadata::encode("bvh tables", &tables)?;
        let mut out = Vec::new();
        for count in [self.nodes.len(), self.triangles.len(), self.vertices.len(), tables.len()] {
            out.extend_from_slice(&(count as u32).to_le_bytes());
        }
        out.extend_from_slice(&tables);
        for sides in self.shape() {
            out.extend(sides.map(|side| match side {
                Shape::Inner => 0,
                Shape::Leaf(count) => count + 1,
            }));
        }
        push_planes(&mut out, &surface_of);
        push_planes(&mut out, &corner_codes(&self.triangles));
        push_vertices(&mut out, &self.vertices);
        Ok(out)
    }

    /// Decodes the payload of a `BVH ` chunk and puts the tree's boxes on. What that takes comes out of [`Limits::memory`].
    ///
    /// # Errors
    /// When the payload is not one, or over a limit.
    pub fn from_payload(bytes: &[u8], limits: &Limits) -> Result<Self> {
        let corrupt = |detail: &str| Error::decode("bvh", detail);
        let cut = || corrupt("the payload is cut short");
        let mut input = Input(bytes);
        let [nodes, triangles, vertices, tables] = input.header().ok_or_else(cut)?;
        check_limit("bvh nodes", nodes as u64, limits.max_bvh_nodes)?;
        check_limit("triangles", triangles as u64, limits.max_triangles)?;
        let need = 2 * nodes as u64 + 16 * triangles as u64 + 20 * vertices as u64 + tables as u64;
        if need != input.0.len() as u64 {
            return Err(corrupt("the payload's length does not fit its counts"));
        }
        let [node, triangle, vertex] = DECODING_BYTES;
        let _share =
            limits.reserve(need + node * nodes as u64 + triangle * triangles as u64 + vertex * vertices as u64)?;
        let tables: Tables = metadata::decode("bvh tables", input.take(tables).ok_or_else(cut)?, limits)?;
        let shape = input.take(2 * nodes).ok_or_else(cut)?.chunks_exact(2).map(|c| [side(c[0]), side(c[1])]);
        let shape: Vec<[Shape; 2]> = shape.collect();
        let (surfaces, corners) = input.planes(triangles).zip(input.planes(3 * triangles)).ok_or_else(cut)?;
        let vertices = input.vertices(vertices).ok_or_else(cut)?;
        let triangles =
            triangles_of(&corners, &surfaces, &tables.surfaces).ok_or_else(|| corrupt("a triangle has no surface"))?;
        Self::new(&shape, triangles, vertices, tables.objects, tables.materials).map_err(|e| corrupt(&e))
    }
}

/// Writes the positions, then the normals, each coordinate as differences from vertex to vertex.
fn push_vertices(out: &mut Vec<u8>, vertices: &[Vertex]) {
    let coordinates: [fn(&Vertex) -> u32; 5] = [
        |v| v.position.x.to_bits(),
        |v| v.position.y.to_bits(),
        |v| v.position.z.to_bits(),
        |v| u32::from(v.normal.u),
        |v| u32::from(v.normal.v),
    ];
    for coordinate in coordinates {
        push_planes(out, &differences(vertices.iter().map(coordinate)));
    }
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

/// The inverse of [`differences`].
fn sums(mut values: Vec<u32>) -> Vec<u32> {
    let mut sum = 0u32;
    for value in &mut values {
        sum = sum.wrapping_add(*value);
        *value = sum;
    }
    values
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

    /// What [`push_vertices`] wrote.
    fn vertices(&mut self, count: usize) -> Option<Vec<Vertex>> {
        let mut coordinate = || self.planes(count).map(sums);
        let (xs, ys, zs, us, vs) = (coordinate()?, coordinate()?, coordinate()?, coordinate()?, coordinate()?);
        let number = |bits: u32| f32::from_bits(bits);
        let vertex = |i: usize| {
            Some(Vertex {
                position: Vec3::new(number(xs[i]), number(ys[i]), number(zs[i])),
                // What is above 16 bits would be in no digest, which hashes what a writer would write.
                normal: Oct { u: u16::try_from(us[i]).ok()?, v: u16::try_from(vs[i]).ok()? },
            })
        };
        (0..count).map(vertex).collect()
    }
}
