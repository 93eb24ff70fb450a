//! The acceleration structure as the trace holds it: two-child nodes, triangles in leaf order, vertices.
//!
//! The boxes are not stored: they follow exactly from the triangles, because minimum and maximum do not round.

use crate::math::Vec3;
use crate::oct::Oct;
use crate::scene::Material;

/// Most triangles a leaf can hold: the path codec keeps two bits a triangle in a byte.
pub const MAX_LEAF_TRIANGLES: u32 = 4;
/// Deepest tree that is accepted, counted in inner nodes from the root. It bounds every traversal stack.
pub const MAX_TREE_DEPTH: usize = 128;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing: its minimum lies above its maximum.
    pub const EMPTY: Self = Self { min: Vec3::splat(f32::MAX), max: Vec3::splat(-f32::MAX) };

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The smallest box around this one and a point.
    pub fn with(self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }
}

/// Reference to a child: an inner node, or a leaf as a run of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const FIRST_BITS: u32 = 28;

    /// Largest number of triangles and of nodes that a reference can address.
    pub const MAX_INDEX: u32 = 1 << Self::FIRST_BITS;
    /// The root, an inner node.
    pub const ROOT: Self = Self(0);

    /// The inner node `index`.
    ///
    /// # Panics
    /// When `index` is not below [`Child::MAX_INDEX`].
    pub fn inner(index: u32) -> Self {
        assert!(index < Self::MAX_INDEX);
        Self(index)
    }

    /// A leaf of `count` triangles from `first` on; an empty leaf has `count` 0.
    ///
    /// # Panics
    /// When `first` is not below [`Child::MAX_INDEX`], or `count` is above [`MAX_LEAF_TRIANGLES`].
    pub fn leaf(first: u32, count: u32) -> Self {
        assert!(first < Self::MAX_INDEX && count <= MAX_LEAF_TRIANGLES);
        Self(Self::LEAF | count << Self::FIRST_BITS | first)
    }

    /// True for a leaf.
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Index of the inner node.
    #[inline(always)]
    pub fn node(self) -> usize {
        self.0 as usize
    }

    /// First triangle of the leaf.
    #[inline(always)]
    pub fn first(self) -> usize {
        (self.0 & (Self::MAX_INDEX - 1)) as usize
    }

    /// Number of triangles in the leaf.
    #[inline(always)]
    pub fn count(self) -> usize {
        (self.0 >> Self::FIRST_BITS & 7) as usize
    }

    /// The triangles of the leaf.
    #[inline(always)]
    pub fn triangles(self) -> std::ops::Range<usize> {
        self.first()..self.first() + self.count()
    }
}

/// A node of two children: what one visit of a two-AABB unit reads (64 B in the modelled memory).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Boxes of the left and the right child.
    pub bounds: [Aabb; 2],
    /// The left and the right child.
    pub children: [Child; 2],
}

/// A vertex: a position and the shading normal, quantised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Position, scene units.
    pub position: Vec3,
    /// Shading normal.
    pub normal: Oct,
}

/// A triangle in leaf order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Indices into [`Bvh::vertices`].
    pub vertices: [u32; 3],
    /// Index into [`Bvh::objects`].
    pub object: u32,
    /// Index into [`Bvh::materials`].
    pub material: u32,
}

/// The shape of the tree without boxes: per inner node, in depth-first order, what its children are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// An inner node.
    Inner,
    /// A leaf of so many triangles.
    Leaf(u8),
}

/// The `BVH ` chunk in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    /// Inner nodes in depth-first order; the root is node 0.
    pub nodes: Vec<Node>,
    /// Triangles in the order in which a depth-first walk meets their leaves.
    pub triangles: Vec<Triangle>,
    /// Vertices in the order in which the triangles first name them.
    pub vertices: Vec<Vertex>,
    /// Object names.
    pub objects: Vec<String>,
    /// Materials.
    pub materials: Vec<Material>,
}

impl Bvh {
    /// Puts boxes on a tree shape.
    ///
    /// # Errors
    /// Says what is wrong when the shape is not one tree over exactly these triangles, or an index is out of range.
    pub fn new(
        shape: &[[Shape; 2]],
        triangles: Vec<Triangle>,
        vertices: Vec<Vertex>,
        objects: Vec<String>,
        materials: Vec<Material>,
    ) -> Result<Self, String> {
        for (i, t) in triangles.iter().enumerate() {
            if t.vertices.iter().any(|&v| v as usize >= vertices.len()) {
                return Err(format!("triangle {i} names a vertex that is not there"));
            }
            if t.object as usize >= objects.len() || t.material as usize >= materials.len() {
                return Err(format!("triangle {i} names an object or a material that is not there"));
            }
        }
        if vertices.iter().any(|v| !v.position.is_finite()) {
            return Err("a vertex is not finite".into());
        }
        let children = link(shape, triangles.len())?;
        let mut bvh = Self { nodes: Vec::new(), triangles, vertices, objects, materials };
        bvh.nodes = bvh.boxes(&children);
        Ok(bvh)
    }

    /// Boxes from the leaves up: children stand behind their parent, so one backward pass is enough.
    fn boxes(&self, children: &[[Child; 2]]) -> Vec<Node> {
        let empty = [Aabb::EMPTY; 2];
        let mut nodes: Vec<Node> = children.iter().map(|&children| Node { bounds: empty, children }).collect();
        for i in (0..nodes.len()).rev() {
            for side in 0..2 {
                let child = nodes[i].children[side];
                nodes[i].bounds[side] = if child.is_leaf() {
                    self.leaf_box(child)
                } else {
                    let [left, right] = nodes[child.node()].bounds;
                    left.union(right)
                };
            }
        }
        nodes
    }

    fn leaf_box(&self, leaf: Child) -> Aabb {
        leaf.triangles().flat_map(|t| self.corners(t)).fold(Aabb::EMPTY, Aabb::with)
    }

    /// The corner positions of triangle `index`.
    #[inline]
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.triangles[index].vertices.map(|v| self.vertices[v as usize].position)
    }

    /// The material of triangle `index`.
    #[inline]
    pub fn material(&self, index: usize) -> &Material {
        &self.materials[self.triangles[index].material as usize]
    }

    /// The shading normal of triangle `index` at barycentric coordinates `u`, `v` (weights of the second and third
    /// corner), quantised. Where the vertex normals cancel out, the face normal takes over.
    #[inline]
    pub fn shading_normal(&self, index: usize, u: f32, v: f32) -> Oct {
        let [a, b, c] = self.triangles[index].vertices.map(|v| self.vertices[v as usize].normal);
        if a == b && b == c {
            return a;
        }
        let n = (a.decode() * ((1.0 - u) - v) + b.decode() * u) + c.decode() * v;
        if n.dot(n) > 1.0e-6 {
            return Oct::encode(n);
        }
        let [p, q, r] = self.corners(index);
        Oct::encode((q - p).cross(r - p))
    }

    /// The shape that [`Bvh::new`] rebuilds this tree from.
    pub fn shape(&self) -> Vec<[Shape; 2]> {
        let of = |child: Child| if child.is_leaf() { Shape::Leaf(child.count() as u8) } else { Shape::Inner };
        self.nodes.iter().map(|node| node.children.map(of)).collect()
    }

    /// The box around everything.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds[0].union(root.bounds[1]))
    }
}

/// Turns a depth-first shape into child references, checking that it is one whole tree.
fn link(shape: &[[Shape; 2]], triangles: usize) -> Result<Vec<[Child; 2]>, String> {
    if shape.is_empty() || shape.len() >= Child::MAX_INDEX as usize || triangles >= Child::MAX_INDEX as usize {
        return Err(format!("a tree of {} nodes over {triangles} triangles is not possible", shape.len()));
    }
    let empty = Child::leaf(0, 0);
    let mut children = vec![[empty; 2]; shape.len()];
    let (mut next_node, mut next_triangle) = (1u32, 0u32);
    // What is still to be linked: (node, side, inner nodes from the root to here), the next one on top.
    let mut open = vec![(0usize, 1usize, 1usize), (0, 0, 1)];
    while let Some((node, side, depth)) = open.pop() {
        children[node][side] = match shape[node][side] {
            Shape::Leaf(count) => {
                let count = u32::from(count);
                if count > MAX_LEAF_TRIANGLES || next_triangle as usize + count as usize > triangles {
                    return Err(format!("node {node} has a leaf of {count} triangles that are not there"));
                }
                next_triangle += count;
                Child::leaf(next_triangle - count, count)
            }
            Shape::Inner => {
                let index = next_node;
                if index as usize >= shape.len() {
                    return Err(format!("node {node} has a child that is not there"));
                }
                // Any child may be put aside on the way down, so the depth of every branch counts, not only of left
                // ones.
                if depth >= MAX_TREE_DEPTH {
                    return Err(format!("the tree is deeper than {MAX_TREE_DEPTH} nodes"));
                }
                next_node += 1;
                open.extend([(index as usize, 1, depth + 1), (index as usize, 0, depth + 1)]);
                Child::inner(index)
            }
        };
    }
    if next_node as usize != shape.len() || next_triangle as usize != triangles {
        return Err(format!(
            "the tree reaches {next_node} of {} nodes and {next_triangle} of {triangles} triangles",
            shape.len()
        ));
    }
    Ok(children)
}
