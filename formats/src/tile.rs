//! One tile of one frame in memory: the ray trees of its samples and what each ray met.

use crate::half::Half3;
use crate::math::Vec3;
use crate::oct::Oct;
use crate::scene::{MAX_LIGHTS, Rect};

/// Deepest ray tree, in bounces: one less than the 16 bits of a class have room for, so the class of a child can be computed of any ray
/// of a tree, whether it has that child or not.
pub const MAX_DEPTH: u32 = 14;

/// The columns of a tile, each readable by itself (with those it is predicted from: see [`Column::needs`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Column {
    /// Shape of the ray trees: hits, children, shadow states.
    Tree = 0,
    /// Triangle, `t` and shading normal per hit.
    Hits = 1,
    /// Local colour and child weights.
    Radiance = 2,
    /// Traversal path of every ray.
    Paths = 3,
}

impl Column {
    /// All columns, in file order.
    pub const ALL: [Self; 4] = [Self::Tree, Self::Hits, Self::Radiance, Self::Paths];

    /// The name, as `info`, `digest` and `diff` print it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::Hits => "hits",
            Self::Radiance => "radiance",
            Self::Paths => "paths",
        }
    }

    /// The columns without which this one cannot be decoded.
    pub fn needs(self) -> &'static [Self] {
        match self {
            Self::Tree => &[],
            Self::Hits | Self::Paths => &[Self::Tree],
            Self::Radiance => &[Self::Tree, Self::Hits],
        }
    }
}

/// Kind of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RayKind {
    /// From the eye.
    Primary = 0,
    /// Mirrored at a surface.
    Reflection = 1,
    /// Bent through a surface.
    Refraction = 2,
    /// From a hit to a light.
    Shadow = 3,
}

impl RayKind {
    /// All kinds, in counter order.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Reflection, Self::Refraction, Self::Shadow];

    /// The name, as reports print it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Reflection => "reflection",
            Self::Refraction => "refraction",
            Self::Shadow => "shadow",
        }
    }
}

/// Place of a closest-hit ray in the ray tree, as a binary heap numbers it: the primary ray is class 1, the reflection
/// child of class c is 2c, the refraction child 2c + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RayClass(pub u16);

impl RayClass {
    /// The primary ray.
    pub const PRIMARY: Self = Self(1);

    /// The reflection child.
    ///
    /// # Panics
    /// Beyond a depth of [`MAX_DEPTH`] (a debug build; else the class is that of another ray).
    pub fn reflection(self) -> Self {
        Self(self.0 * 2)
    }

    /// The refraction child.
    ///
    /// # Panics
    /// As [`RayClass::reflection`].
    pub fn refraction(self) -> Self {
        Self(self.0 * 2 + 1)
    }

    /// The ray that spawned this one; `None` for the primary ray.
    pub fn parent(self) -> Option<Self> {
        (self.0 > 1).then_some(Self(self.0 / 2))
    }

    /// Bounces before this ray: 0 for the primary ray.
    ///
    /// # Panics
    /// When it is 0, which is no class (a debug build; else the number has no meaning).
    pub fn depth(self) -> u32 {
        15 - self.0.leading_zeros()
    }

    /// What the ray is.
    pub fn kind(self) -> RayKind {
        match self.0 {
            1 => RayKind::Primary,
            c if c % 2 == 0 => RayKind::Reflection,
            _ => RayKind::Refraction,
        }
    }
}

/// What a shadow ray found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadowState {
    /// No ray was cast: the light is behind the surface, or the surface does not show it.
    NotCast = 0,
    /// The light is seen.
    Lit = 1,
    /// Something opaque is in the way.
    Blocked = 2,
    /// The light is seen through one or more dielectric surfaces.
    Tinted = 3,
}

/// The states of all lights at one hit: two bits a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shadows(pub u32);

impl Shadows {
    /// The state of light `light`.
    #[inline]
    pub fn get(self, light: usize) -> ShadowState {
        match self.0 >> (2 * light) & 3 {
            0 => ShadowState::NotCast,
            1 => ShadowState::Lit,
            2 => ShadowState::Blocked,
            _ => ShadowState::Tinted,
        }
    }

    /// Sets the state of light `light`.
    #[inline]
    pub fn set(&mut self, light: usize, state: ShadowState) {
        self.0 = self.0 & !(3 << (2 * light)) | (state as u32) << (2 * light);
    }

    /// The lights towards which a ray was cast, ascending.
    pub fn cast(self) -> impl Iterator<Item = usize> {
        (0..MAX_LIGHTS).filter(move |light| self.0 >> (2 * light) & 3 != 0)
    }

    /// The place of the ray to light `light` among the shadow rays; `None` if none was cast.
    #[inline]
    pub fn rank(self, light: usize) -> Option<u32> {
        let below = Self(self.0 & ((1 << (2 * light)) - 1));
        (self.0 >> (2 * light) & 3 != 0).then(|| below.count())
    }

    /// The low bit of each light towards which a ray was cast.
    #[inline]
    pub fn places(self) -> Self {
        Self((self.0 | self.0 >> 1) & 0x5555_5555)
    }

    /// Number of shadow rays.
    #[inline]
    pub fn count(self) -> u32 {
        self.places().0.count_ones()
    }
}

/// One closest-hit ray in a ray tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayNode {
    /// Place in the tree.
    pub class: RayClass,
    /// The ray met a surface.
    pub hit: bool,
    /// A reflection ray was spawned; it is the next node.
    pub reflect: bool,
    /// A refraction ray was spawned; it follows the reflection's subtree.
    pub refract: bool,
    /// Shadow rays and what they found.
    pub shadows: Shadows,
}

/// The ray trees of a tile, sample by sample (row by row), each in depth-first order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tree {
    /// Per sample the index of its first node, and one entry more: the number of nodes.
    pub first: Vec<u32>,
    /// The nodes.
    pub nodes: Vec<RayNode>,
}

impl Tree {
    /// The node indices of sample `sample`; the first is the primary ray.
    ///
    /// # Panics
    /// When there is no such sample.
    #[inline]
    pub fn sample(&self, sample: usize) -> std::ops::Range<usize> {
        self.first[sample] as usize..self.first[sample + 1] as usize
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.first.len().saturating_sub(1)
    }

    /// All rays: one for each node and one for each shadow ray.
    pub fn ray_count(&self) -> u64 {
        self.nodes.iter().map(|n| 1 + u64::from(n.shadows.count())).sum()
    }

    /// Per node the index of its parent node; a primary ray is its own parent.
    ///
    /// # Panics
    /// When a node's class is 0, or deeper than [`MAX_DEPTH`] and one.
    pub fn parents(&self) -> Vec<u32> {
        // The last node seen of each depth: in depth-first order a node's parent is the last one a level up.
        let mut last = [0u32; MAX_DEPTH as usize + 2];
        let mut parents = Vec::with_capacity(self.nodes.len());
        for (i, node) in self.nodes.iter().enumerate() {
            let depth = node.class.depth() as usize;
            last[depth] = i as u32;
            parents.push(last[depth.saturating_sub(1)]);
        }
        parents
    }

    /// Per node the index of its first ray in ray order (each node's closest-hit ray, then its shadow rays by light),
    /// and one entry more: the number of rays.
    pub fn ray_index(&self) -> Vec<u32> {
        let mut index = Vec::with_capacity(self.nodes.len() + 1);
        let mut next = 0;
        for node in &self.nodes {
            index.push(next);
            next += 1 + node.shadows.count();
        }
        index.push(next);
        index
    }
}

/// Where a closest-hit ray ended.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Triangle in leaf order; [`Hit::NONE`] for a miss.
    pub triangle: u32,
    /// Ray parameter; infinite for a miss.
    pub t: f32,
    /// Shading normal, not turned towards the ray.
    pub normal: Oct,
}

/// Equal in every bit, as digests see it.
impl PartialEq for Hit {
    fn eq(&self, other: &Self) -> bool {
        (self.triangle, self.t.to_bits(), self.normal) == (other.triangle, other.t.to_bits(), other.normal)
    }
}

impl Hit {
    /// The triangle of a ray that met nothing.
    pub const NONE: u32 = u32::MAX;
    /// A miss.
    pub const MISS: Self = Self { triangle: Self::NONE, t: f32::INFINITY, normal: Oct { u: 0, v: 0 } };
}

/// What a closest-hit ray contributes: `local + reflect * (reflected) + refract * (refracted)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Radiance {
    /// Local shaded colour, linear RGB; the sky for a miss.
    pub local: Half3,
    /// Weight of the reflection child; zero where none was spawned.
    pub reflect: Half3,
    /// Weight of the refraction child; zero where none was spawned.
    pub refract: Half3,
}

/// One step of a traversal path, as a byte.
pub mod step {
    /// Inner node: neither child's box is met.
    pub const NONE: u8 = 0;
    /// Inner node: only the left child.
    pub const LEFT: u8 = 1;
    /// Inner node: only the right child.
    pub const RIGHT: u8 = 2;
    /// Inner node: both, the left one first.
    pub const LEFT_FIRST: u8 = 3;
    /// Inner node: both, the right one first.
    pub const RIGHT_FIRST: u8 = 4;
    /// Stack pop: the popped child is visited.
    pub const POP: u8 = 5;
    /// Stack pop: the popped child lies behind the closest hit and is dropped.
    pub const CULLED: u8 = 6;
    /// Triangle test: missed.
    pub const MISS: u8 = 7;
    /// Triangle test: the new closest hit; ends a shadow ray.
    pub const HIT: u8 = 8;
    /// Triangle test: met, but the ray passes (cut-out texel, or a dielectric on a shadow ray).
    pub const PASS: u8 = 9;
}

/// The traversal paths of a tile's rays.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// Steps of all rays; see [`step`].
    pub steps: Vec<u8>,
    /// Per ray, in ray order, where its steps start and how many there are.
    pub spans: Vec<(u32, u32)>,
}

impl Paths {
    /// The steps of ray `ray`.
    ///
    /// # Panics
    /// When there is no such ray, or its span is not among the steps.
    #[inline]
    pub fn ray(&self, ray: usize) -> &[u8] {
        let (start, len) = self.spans[ray];
        &self.steps[start as usize..start as usize + len as usize]
    }
}

/// Equal when every ray has the same steps, wherever they are kept.
impl PartialEq for Paths {
    fn eq(&self, other: &Self) -> bool {
        self.spans.len() == other.spans.len() && (0..self.spans.len()).all(|ray| self.ray(ray) == other.ray(ray))
    }
}

/// One tile of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Frame number.
    pub frame: u32,
    /// Tile number in the frame.
    pub index: u32,
    /// Its samples.
    pub rect: Rect,
    /// Ray trees.
    pub tree: Tree,
    /// One entry a node.
    pub hits: Vec<Hit>,
    /// One entry a node.
    pub radiance: Vec<Radiance>,
    /// One path a ray; empty if the column was not read.
    pub paths: Paths,
}

/// The colour of one sample from its nodes in depth-first order: children are added to their parent, deepest first,
/// reflection before refraction.
///
/// # Panics
/// When the nodes are no tree in depth-first order: one lacks a child that it says it has, or more subtrees than a tree of
/// [`MAX_DEPTH`] has stand side by side.
pub fn composite(nodes: &[RayNode], radiance: &[Radiance]) -> Vec3 {
    // Colours of finished subtrees whose parent is still to come; reading backwards, a node finds its children on top.
    let mut done = [Vec3::ZERO; MAX_DEPTH as usize + 2];
    let mut top = 0;
    for (node, values) in nodes.iter().zip(radiance).rev() {
        let mut colour = values.local.to_vec3();
        if node.reflect {
            top -= 1;
            colour = colour + values.reflect.to_vec3().times(done[top]);
        }
        if node.refract {
            top -= 1;
            colour = colour + values.refract.to_vec3().times(done[top]);
        }
        done[top] = colour;
        top += 1;
    }
    done[0]
}
